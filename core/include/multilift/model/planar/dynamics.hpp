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
  using B = Both<R>;
  const B mass = both(p.vehicle_mass), rate = both(state.theta_dot[0], state.theta_dot[1]);
  const Vec2<B> d = both(pose.direction), t = both(pose.tangent), arm = both(pose.arm);
  const B bar_rate_squared = both(square(state.theta_dot[2]));
  const Vec2<R> half_bar_weight{R(0.0), R(0.5) * p.bar_mass * p.gravity};

  // Levers about the bar's centre of mass of forces on its ends, along and across the cables.
  const B lever = cross(arm, d), lever_across = cross(arm, t);
  // Swing damping is a couple: this force along t on the vehicle, and against t on the bar's end.
  const B couple = both(p.swing_damping[0], p.swing_damping[1]) * rate * both(p.inverse_length);
  const Vec2<B> net = both(loads.u) + both(half_bar_weight) + both(loads.vehicle_push) -
                      scale(both(p.vehicle_drag), both(pose.vehicle_velocity));
  const B net_across = dot(t, net) + couple;
  // The tension if neither the bar's centre of mass nor its turning accelerated.
  const B pull =
      dot(d, net) + mass * (both(p.cable_length) * rate * rate + bar_rate_squared * dot(d, arm));

  const Vec2<B> mass_d = mass * d;
  const B mass_lever = mass * lever;
  const Symmetric3<R> inertia{p.bar_mass + sum(mass_d.y * d.y),
                              sum(mass_d.y * d.z),
                              p.bar_mass + sum(mass_d.z * d.z),
                              sum(mass_lever * d.y),
                              sum(mass_lever * d.z),
                              p.bar_inertia + sum(mass_lever * lever)};
  const Vec2<R> force = sum(pull * d - couple * t) + loads.bar_push - R(2.0) * half_bar_weight;
  const R torque = sum(pull * lever - couple * lever_across) + loads.bar_torque -
                   p.swing_damping[2] * state.theta_dot[2];
  const auto [ay, az, alpha] = solve_spd(inertia, {force.y, force.z, torque});

  const Vec2<R> acceleration{ay, az};
  const B tension = pull - mass * (dot(d, both(acceleration)) + both(alpha) * lever);
  // Across the cable, the acceleration of the bar's end less the vehicle's.
  const B theta_ddot =
      both(p.inverse_length) * (dot(t, both(acceleration)) + both(alpha) * lever_across -
                                bar_rate_squared * dot(t, arm) - both(p.inverse_mass) * net_across);
  return {acceleration,
          {theta_ddot[0], theta_ddot[1], alpha},
          each<R>(tension),
          each<R>(tension * d - couple * t)};
}

}  // namespace multilift::planar
