// The motion of vehicles and payload as a whole, which no force between them changes.
#pragma once

#include <vector>

#include "multilift/model/spatial/parameters.hpp"

namespace multilift::spatial {

/// Mass of payload and vehicles, kg.
template <Real R>
MULTILIFT_INLINE R common_mass(const Parameters<R>& p) {
  R mass = p.payload_mass;
  for (const R& vehicle : p.vehicle_mass) mass += vehicle;
  return mass;
}

/// The mean of what is given of the payload and, by `vehicle(i)`, of each vehicle, weighed by mass.
template <Real R, class Of>
MULTILIFT_INLINE Vec3<R> common_centre(const Parameters<R>& p, const Vec3<R>& payload,
                                       Of&& vehicle) {
  Vec3<R> moment = p.payload_mass * payload;
  for (std::size_t i = 0; i < p.size(); ++i) moment += p.vehicle_mass[i] * vehicle(i);
  return (R(1.0) / common_mass(p)) * moment;
}

/// The mean of `x(i)` along each axis, weighed; `all` becomes the sum of the weights.
template <Real R, class Of>
MULTILIFT_INLINE Vec3<R> weighed_mean(const std::vector<Vec3<R>>& weight, Of&& x, Vec3<R>& all) {
  Vec3<R> moment{};
  all = {};
  for (std::size_t i = 0; i < weight.size(); ++i) {
    moment += scale(weight[i], x(i));
    all += weight[i];
  }
  return {moment.x / all.x, moment.y / all.y, moment.z / all.z};
}

}  // namespace multilift::spatial
