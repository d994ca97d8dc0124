// What surrounds the bodies: ground and air.
#pragma once

#include "multilift/model/spatial/parameters.hpp"

namespace multilift::spatial {

/// A level floor on which vehicles and payload may stand, or none.
template <Real R>
struct Ground {
  R height{0.0};
  R sink{0.001};
  R friction{0.6};
  R vehicle_clearance{0.15};
  R payload_clearance{0.05};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"height", "m", Range::any, "z of the floor"}, self.height);
    v(Field{"sink", "m", Range::positive,
            "how deep a body sinks in under its own weight; sets stiffness and damping"},
      self.sink);
    v(Field{"friction", "", Range::non_negative, "Coulomb friction coefficient"}, self.friction);
    v(Field{"vehicle_clearance", "m", Range::non_negative,
            "height of a vehicle's centre of mass when it stands"},
      self.vehicle_clearance);
    v(Field{"payload_clearance", "m", Range::non_negative,
            "how far below the payload's attachments, or its centre if it is a point, its feet "
            "are"},
      self.payload_clearance);
  }
};

/// Where friction turns from viscous to Coulomb's, m/s; small beside any motion that matters.
inline constexpr double friction_speed = 0.02;
/// Friction slows a body at most at this rate, 1/s, so that steps of up to 2 ms follow it: in hard
/// landings, which press many times a body's weight, it turns viscous at a higher speed instead.
inline constexpr double friction_rate_max = 1000.0;

/// The floor's force on one point of a body of a given weight, W, N: a critically damped spring up,
/// and friction against the slip, both only while the point is below the floor.
template <Real R>
MULTILIFT_INLINE Vec3<R> contact_force(const Ground<R>& ground, const R& weight, const R& gravity,
                                       const Vec3<R>& point, const Vec3<R>& velocity) {
  const R zero(0.0);
  const R depth = ground.height - point.z;
  const R touching = select(zero < depth, R(1.0), zero);
  const R rate = sqrt(gravity / ground.sink);  // of the undamped spring, rad/s
  const R normal =
      touching * weight * max(depth / ground.sink - R(2.0) * velocity.z * rate / gravity, zero);
  const R viscous_below = max(
      R(friction_speed), R(1.0 / friction_rate_max) * ground.friction * gravity * normal / weight);
  const R slip =
      sqrt(velocity.x * velocity.x + velocity.y * velocity.y + viscous_below * viscous_below);
  const R grip = ground.friction * normal / slip;
  return {-grip * velocity.x, -grip * velocity.y, normal};
}

}  // namespace multilift::spatial
