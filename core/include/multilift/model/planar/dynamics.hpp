// Equations of motion of the planar plant, the fast way: one pass over the cables.
//
// Each cable's length is constant, so its tension is affine in the bar's acceleration. Inserted
// into the bar's Newton and Euler equations, one symmetric positive definite 3x3 system in the
// bar's acceleration remains, regular for a bar without rotational inertia too unless both cables'
// lines pass through its centre of mass, where nothing would say how it turns. Equivalent to
// (7)-(13) closed by c(q) = 0; redundant.hpp states that form, and tests hold the two together.
#pragma once

#include "multilift/math/spd3.hpp"
#include "multilift/model/planar/state.hpp"

namespace multilift::planar {

/// What acts on the plant from outside, besides gravity and the damping (14).
template <Real R>
struct Loads {
  std::array<Vec2<R>, 2> u;             // the paper's u: thrust less the gravity share, N
  std::array<Vec2<R>, 2> vehicle_push;  // N
  Vec2<R> bar_push;                     // at the bar's centre of mass, N
  R bar_torque{0.0};                    // about x, from y towards z, N m
};

template <Real R>
struct Motion {
  Vec2<R> bar_acceleration;            // m/s^2
  std::array<R, 3> theta_ddot;         // rad/s^2
  std::array<R, 2> tension;            // N, negative where a real cable would be slack
  std::array<Vec2<R>, 2> cable_force;  // what each cable exerts on the bar, N

  StateRate<R> rate(const State<R>& state) const {
    return {state.bar_velocity, state.theta_dot, bar_acceleration, theta_ddot};
  }
};

template <Real R>
MULTILIFT_INLINE Motion<R> motion(const Plant<R>& p, const State<R>& state, const Pose<R>& pose,
                                  const Loads<R>& loads) {
  const R half_bar_weight = R(0.5) * p.bar_mass * p.gravity;
  const R bar_rate_squared = square(state.theta_dot[2]);
  Symmetric3<R> inertia{p.bar_mass, R(0.0), p.bar_mass, R(0.0), R(0.0), p.bar_inertia};
  Vec2<R> force{loads.bar_push.y, loads.bar_push.z - R(2.0) * half_bar_weight};
  R torque = loads.bar_torque - p.swing_damping[2] * state.theta_dot[2];

  std::array<Vec2<R>, 2> free_acceleration;  // of a vehicle whose cable carries no tension
  std::array<Vec2<R>, 2> couple_force;       // swing damping, as a force on the bar's end
  std::array<R, 2> pull;                     // tension if the bar's end did not accelerate
  std::array<R, 2> lever;

  for (std::size_t i = 0; i < 2; ++i) {
    const auto& [d, t, arm] = pose.cable[i];
    const R mass = p.vehicle_mass[i];
    const R length = p.cable_length[i];
    couple_force[i] = (-p.swing_damping[i] * state.theta_dot[i] * p.inverse_length[i]) * t;
    const Vec2<R> net = loads.u[i] + Vec2<R>{R(0.0), half_bar_weight} + loads.vehicle_push[i] -
                        scale(p.vehicle_drag[i], pose.vehicle_velocity[i]) - couple_force[i];
    free_acceleration[i] = p.inverse_mass[i] * net;
    pull[i] =
        dot(d, net) + mass * (length * square(state.theta_dot[i]) + bar_rate_squared * dot(d, arm));
    lever[i] = cross(arm, d);

    inertia.a00 += mass * d.y * d.y;
    inertia.a10 += mass * d.y * d.z;
    inertia.a11 += mass * d.z * d.z;
    inertia.a20 += mass * lever[i] * d.y;
    inertia.a21 += mass * lever[i] * d.z;
    inertia.a22 += mass * lever[i] * lever[i];
    force += pull[i] * d + couple_force[i];
    torque += pull[i] * lever[i] + cross(arm, couple_force[i]);
  }

  const auto [ay, az, alpha] = solve_spd(inertia, {force.y, force.z, torque});

  Motion<R> result;
  result.bar_acceleration = {ay, az};
  result.theta_ddot[2] = alpha;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& [d, t, arm] = pose.cable[i];
    const Vec2<R> end_acceleration =
        result.bar_acceleration + alpha * perpendicular(arm) - bar_rate_squared * arm;
    result.tension[i] =
        pull[i] - p.vehicle_mass[i] * (dot(d, result.bar_acceleration) + alpha * lever[i]);
    result.theta_ddot[i] = dot(t, end_acceleration - free_acceleration[i]) * p.inverse_length[i];
    result.cable_force[i] = result.tension[i] * d + couple_force[i];
  }
  return result;
}

}  // namespace multilift::planar
