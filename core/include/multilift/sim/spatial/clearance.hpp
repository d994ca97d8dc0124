// How close vehicles come to each other and to each other's cables.
#pragma once

#include "multilift/model/spatial/dynamics.hpp"

namespace multilift::spatial {

/// Integration steps between two measurements of distances, whose number grows with n squared.
inline constexpr long distance_steps = 20;

/// The least distances between vehicles, and between a vehicle and another's whole cable, m.
template <Real R>
struct Clearance {
  R vehicles{unlimited};
  R cables{unlimited};
};

template <Real R, class V>
Clearance<R> clearance_of(const Plant<R>& p, const State<R, V>& x, const Instant<R>& now,
                          const Masks<R>& whole) {
  const R zero(0.0), one(1.0);
  Clearance<R> least_squared;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3<R> tie = x.payload.position + now.payload_turn.to_world(p.attachment[i]);
    const Vec3<R> along = x.vehicle[i].position - tie;
    const R inverse = one / max(dot(along, along), R(1e-12));
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (j == i) continue;
      const Vec3<R> from_tie = x.vehicle[j].position - tie;
      const R part = clamp(dot(from_tie, along) * inverse, zero, one);
      const Vec3<R> off = from_tie - part * along;
      least_squared.cables =
          min(least_squared.cables, select(whole[i].is, dot(off, off), R(unlimited)));
      if (j > i) continue;
      const Vec3<R> apart = x.vehicle[j].position - x.vehicle[i].position;
      least_squared.vehicles = min(least_squared.vehicles, dot(apart, apart));
    }
  }
  return {sqrt(least_squared.vehicles), sqrt(least_squared.cables)};
}

/// How close bodies may come before they count as collided, m; 0 lets everything pass.
template <Real R>
struct SafetyParameters {
  R vehicle_distance{0.0};
  R cable_distance{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"vehicle_distance", "m", Range::non_negative,
            "two vehicles closer than this have collided, which ends the run; 0: never"},
      self.vehicle_distance);
    v(Field{"cable_distance", "m", Range::non_negative,
            "a vehicle closer than this to another's cable has collided; 0: never"},
      self.cable_distance);
  }
};

}  // namespace multilift::spatial
