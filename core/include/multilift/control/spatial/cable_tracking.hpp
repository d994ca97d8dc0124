// One cable's direction, turned on the sphere towards the force that it shall exert.
#pragma once

#include "multilift/math/vec3.hpp"

namespace multilift::spatial {

/// A cable as the payload's frame sees it. Rates are those in the world; only their coordinates are
/// the payload's.
template <Real R>
struct TrackedCable {
  Vec3<R> d, d_rate, omega;      // direction to the vehicle, its rate, d x d_rate
  Vec3<R> mu, mu_rate, mu_jerk;  // wanted force and its derivatives
  Vec3<R> share_rate;            // derivative of mu's coordinates
  R tension{0.0}, tension_rate{0.0};

  /// From the vehicle's place and velocity relative to the attachment.
  MULTILIFT_INLINE void observe(const Vec3<R>& along, const Vec3<R>& apart) {
    const R inverse = R(1.0) / max(norm(along), R(1e-9));
    d = inverse * along;
    d_rate = inverse * (apart - dot(d, apart) * d);
    omega = cross(d, d_rate);
  }

  /// The tension that is mu's part along the cable, which cannot push, as a force on the payload.
  MULTILIFT_INLINE Vec3<R> pull() {
    tension = max(dot(mu, d), R(0.0));
    return tension * d;
  }
  MULTILIFT_INLINE Vec3<R> pull_rate() {
    const R zero(0.0);
    tension_rate = select(zero < tension, dot(mu_rate, d) + dot(mu, d_rate), zero);
    return tension_rate * d + tension * d_rate;
  }

  /// d'' by the tracking law on the sphere across the cable, and by its length along it.
  MULTILIFT_INLINE Vec3<R> wanted_bend(const R& stiffness, const R& damping) const {
    const R inverse = R(1.0) / max(norm(mu), R(1e-9));
    const Vec3<R> wanted = inverse * mu;
    const Vec3<R> w = inverse * cross(wanted, mu_rate);
    const R growth = inverse * dot(wanted, mu_rate);
    const Vec3<R> w_rate =
        inverse * (cross(cross(w, wanted), mu_rate) + cross(wanted, mu_jerk)) - growth * w;
    const R about = dot(d, w);
    const Vec3<R> omega_error = omega - (w - about * d);
    const Vec3<R> omega_rate = (w_rate - dot(d, w_rate) * d) - about * d_rate -
                               stiffness * cross(wanted, d) - damping * omega_error;
    return -(dot(omega, omega) * d) - cross(d, omega_rate);
  }
};

}  // namespace multilift::spatial
