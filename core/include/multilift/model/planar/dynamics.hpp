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
  bool pushed{true};                    // where not, the pushes above are zero, and left out
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
  B mass = both(p.vehicle_mass);
  Vec2<B> d = both(pose.direction), arm = both(pose.arm);
  // Both cables' turning, counted from y towards z, and "across": d turned from z towards y.
  B spin = alternate(both(state.theta_dot[0], state.theta_dot[1]));
  B bar_rate_squared = both(square(state.theta_dot[2]));

  // Levers about the bar's centre of mass of forces on its ends, along and against across.
  B lever = cross(arm, d), reach = dot(arm, d);
  // Swing damping is a couple: this force across on the vehicle, and against it on the bar's end.
  B couple = both(p.couple_rate) * spin;
  Vec2<B> net = both(loads.u) - scale(both(p.vehicle_drag), both(pose.vehicle_velocity));
  net.z = net.z + both(p.half_bar_weight);
  if (loads.pushed) net = net + both(loads.vehicle_push);
  B net_across = cross(net, d) + couple;
  // The tension if neither the bar's centre of mass nor its turning accelerated.
  B pull = dot(net, d) + (both(p.mass_length) * (spin * spin) + mass * bar_rate_squared * reach);

  Vec2<B> mass_d = mass * d;
  B mass_lever = mass * lever;
  R yy = p.bar_mass + sum(mass_d.y * d.y);
  const Symmetric3<R> inertia{yy,
                              sum(mass_d.y * d.z),
                              p.twice_bar_and_vehicles - yy,  // as d is a unit vector
                              sum(mass_lever * d.y),
                              sum(mass_lever * d.z),
                              p.bar_inertia + sum(mass_lever * lever)};
  Vec2<B> couple_across = couple * clockwise(d);
  Vec2<R> force = sum(pull * d - couple_across);
  force.z = force.z - R(2.0) * p.half_bar_weight;
  R torque = sum(pull * lever + couple * reach) - p.swing_damping[2] * state.theta_dot[2];
  if (loads.pushed) {
    force = force + loads.bar_push;
    torque = torque + loads.bar_torque;
  }
  auto [ay, az, alpha] = solve_spd(inertia, {force.y, force.z, torque});

  Vec2<B> acceleration{both(ay), both(az)};
  B tension = pull - (dot(mass_d, acceleration) + both(alpha) * mass_lever);
  // Across the cable, the acceleration of the bar's end less the vehicle's.
  B apart = cross(acceleration, d) - (both(alpha) * reach + bar_rate_squared * lever) -
            both(p.inverse_mass) * net_across;
  B theta_ddot = alternate(both(p.inverse_length) * apart);
  return {{ay, az},
          {theta_ddot[0], theta_ddot[1], alpha},
          each<R>(tension),
          each<R>(tension * d - couple_across)};
}

}  // namespace multilift::planar
