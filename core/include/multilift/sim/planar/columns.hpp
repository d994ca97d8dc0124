// The columns of a recorded trajectory: name, unit, meaning and value of each in one place.
#pragma once

#include <tuple>

#include "multilift/sim/planar/metrics.hpp"

namespace multilift::planar {

template <Real R>
struct Sample {
  const Instant<R>& now;
  const Plant<R>& plant;
  const std::array<Vec2<R>, 2>& d_hat;
  const Powers<R>& powers;
  R mechanical_energy;
};

/// Calls v(Field, value) for each column.
template <Real R, class V>
void visit_columns(const Sample<R>& s, V&& v) {
  const auto column = [&](const char* name, const char* unit, const char* doc, const R& x) {
    v(Field{name, unit, Range::any, doc}, x);
  };
  const auto& [pose, motion] = std::tie(s.now.pose, s.now.motion);
  const State<R>& state = s.now.state;
  const Seven<R> q = join_seven(pose.vehicle, state.theta);
  const Vec2<R> gap = closure(s.plant, q);

  column("t", "s", "time", R(s.now.time));
  column("y1", "m", "vehicle 1, to the right", pose.vehicle[0].y);
  column("z1", "m", "vehicle 1, up", pose.vehicle[0].z);
  column("y2", "m", "vehicle 2, to the right", pose.vehicle[1].y);
  column("z2", "m", "vehicle 2, up", pose.vehicle[1].z);
  column("theta1", "rad", "angle of cable 1", state.theta[0]);
  column("theta2", "rad", "angle of cable 2", state.theta[1]);
  column("theta3", "rad", "deflection of the bar", state.theta[2]);
  column("y1_dot", "m/s", "rate of y1", pose.vehicle_velocity[0].y);
  column("z1_dot", "m/s", "rate of z1", pose.vehicle_velocity[0].z);
  column("y2_dot", "m/s", "rate of y2", pose.vehicle_velocity[1].y);
  column("z2_dot", "m/s", "rate of z2", pose.vehicle_velocity[1].z);
  column("theta1_dot", "rad/s", "rate of theta1", state.theta_dot[0]);
  column("theta2_dot", "rad/s", "rate of theta2", state.theta_dot[1]);
  column("theta3_dot", "rad/s", "rate of theta3", state.theta_dot[2]);
  column("bar_y", "m", "bar's centre of mass, to the right", state.bar.y);
  column("bar_z", "m", "bar's centre of mass, up", state.bar.z);
  column("u1", "N", "command to vehicle 1 along y", s.now.commanded[0].y);
  column("u2", "N", "command to vehicle 1 along z, less its gravity share", s.now.commanded[0].z);
  column("u3", "N", "command to vehicle 2 along y", s.now.commanded[1].y);
  column("u4", "N", "command to vehicle 2 along z, less its gravity share", s.now.commanded[1].z);
  column("u1_applied", "N", "u1 as it acts after limits, delay and lag", s.now.applied[0].y);
  column("u2_applied", "N", "u2 as it acts", s.now.applied[0].z);
  column("u3_applied", "N", "u3 as it acts", s.now.applied[1].y);
  column("u4_applied", "N", "u4 as it acts", s.now.applied[1].z);
  column("tension1", "N", "tension of cable 1", motion.tension[0]);
  column("tension2", "N", "tension of cable 2", motion.tension[1]);
  column("d_hat_y1", "N s/m", "drag estimate of vehicle 1 along y", s.d_hat[0].y);
  column("d_hat_z1", "N s/m", "drag estimate of vehicle 1 along z", s.d_hat[0].z);
  column("d_hat_y2", "N s/m", "drag estimate of vehicle 2 along y", s.d_hat[1].y);
  column("d_hat_z2", "N s/m", "drag estimate of vehicle 2 along z", s.d_hat[1].z);
  column("energy", "J", "mechanical energy (18)", s.mechanical_energy);
  column("storage", "J", "storage function (49)", s.now.storage);
  column("power_dissipation", "W", "right side of (57)", s.powers.dissipation);
  column("power_internal_force", "W", "the term (57) lacks", s.powers.internal);
  column("power_push", "W", "of the pushes", s.powers.push);
  column("power_actuation", "W", "of the force applied less the law's", s.powers.actuation);
  column("power_adaptation", "W", "of the estimate held between instants", s.powers.adaptation);
  column("closure_residual", "m", "size of c(q), by which the coordinates miss the bar's geometry",
         sqrt(dot(gap, gap)));
}

}  // namespace multilift::planar
