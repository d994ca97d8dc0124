// From the force that a law asks of a vehicle to what flight stacks take: an attitude and a
// normalised thrust.
//
// Attitudes turn body axes x forward, y left, z up (FLU) into the world's x east, y north, z up
// (ENU); who talks to a stack with other axes turns them there.
#pragma once

#include <vector>

#include "multilift/control/spatial/target.hpp"

namespace multilift::spatial {

/// What the ground station sends to one vehicle.
template <Real R>
struct AttitudeThrust {
  Quaternion<R> attitude;  // of the body in W
  R thrust{0.0};           // normalised, 0 to 1
};

/// The attitude that points body z along `force` and x along the heading before that tilt.
template <Real R>
MULTILIFT_INLINE Quaternion<R> attitude_along(const Vec3<R>& force, const R& size,
                                              const SinCos<R>& half_yaw) {
  const R inverse = R(1.0) / size;
  const Vec3<R> up = inverse * force;
  // The shortest turn from z to `up`.
  const Quaternion<R> tilt = normalised(Quaternion<R>{R(1.0) + up.z, -up.y, up.x, R(0.0)});
  return tilt * Quaternion<R>{half_yaw.cos, R(0.0), R(0.0), half_yaw.sin};
}

/// The normalised thrust that goes with a force of size f, N. With a hover thrust: straight through
/// it, as flight stacks do; otherwise by the rotors' curve.
template <Real R>
MULTILIFT_INLINE R normalised_thrust(const R& force, const R& hover_force, const R& hover_thrust,
                                     const R& greatest_force, const R& curve) {
  const R zero(0.0), one(1.0);
  const R share = force / greatest_force;
  // The mixer's curve run backwards: (1 - c) t + c t^2 of the rotor speed gives the thrust share.
  const R speed = sqrt(max(share, zero));
  const R exact = (one - curve) * speed + curve * share;
  const R through_hover = hover_thrust * force / hover_force;
  return clamp(select(zero < hover_thrust, through_hover, exact), zero, one);
}

/// How newtons become normalised thrust, vehicle by vehicle.
template <Real R>
struct ThrustScale {
  std::vector<R> hover_force;   // of a vehicle's and its share of the load's weight, N
  std::vector<R> hover_thrust;  // normalised thrust that goes with it; 0: the rotors' curve
  std::vector<R> greatest;      // N, and the mixer's curve; both of use without hover thrust only
  std::vector<R> curve;
};

/// What vehicle i is sent so that its rotors exert `force`, W, N.
template <Real R>
MULTILIFT_INLINE AttitudeThrust<R> set_point(const ThrustScale<R>& scale, std::size_t i,
                                             const Vec3<R>& force, const SinCos<R>& half_yaw) {
  const R size = max(norm(force), R(1e-9));
  return {attitude_along(force, size, half_yaw),
          normalised_thrust(size, scale.hover_force[i], scale.hover_thrust[i], scale.greatest[i],
                            scale.curve[i])};
}

/// Weight of each vehicle and of the load that hangs on it at rest, N.
template <Real R>
std::vector<R> hover_forces(const Parameters<R>& assumed, const Formation<R>& formation) {
  std::vector<R> force;
  for (std::size_t i = 0; i < assumed.size(); ++i)
    force.push_back(assumed.vehicle_mass[i] * assumed.gravity + formation.cable_force[i].z);
  return force;
}

}  // namespace multilift::spatial
