// What may be asked of vehicles: least and greatest force, and greatest tilt.
#pragma once

#include <numbers>
#include <vector>

#include "multilift/fields.hpp"
#include "multilift/math/sincos.hpp"
#include "multilift/model/spatial/cables.hpp"

namespace multilift::spatial {

template <Real R>
struct LimitParameters {
  explicit LimitParameters(std::size_t n)
      : thrust_min(n, R(0.0)), thrust_max(n, R(unlimited)), tilt_max(n, R(std::numbers::pi / 2)) {}

  std::vector<R> thrust_min, thrust_max, tilt_max;

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"thrust_min", "N", Range::non_negative, "least force commanded of a vehicle"},
      self.thrust_min);
    v(Field{"thrust_max", "N", Range::positive, "greatest force commanded of a vehicle"},
      self.thrust_max);
    v(Field{"tilt_max", "rad", Range::positive,
            "greatest angle of the commanded force from the vertical, at most pi/2"},
      self.tilt_max);
  }
};

/// Cuts forces to the limits.
template <Real R>
class ForceLimits {
 public:
  explicit ForceLimits(const LimitParameters<R>& limits) : limits_(limits) {
    for (const R& tilt : limits.tilt_max) {
      const auto [s, c] = sincos(tilt);
      slope_max_.push_back(s / max(c, R(1e-12)));
    }
  }

  /// `saturated` says whose force, W, N, was cut. Rotors do not pull down, and where the tilt is at
  /// its limit the upright part of a force is kept and the sideways part cut, as autopilots do.
  void cut(std::vector<Vec3<R>>& force, Masks<R>& saturated) const {
    const R zero(0.0), one(1.0);
    for (std::size_t i = 0; i < force.size(); ++i) {
      Vec3<R>& f = force[i];
      const R up = max(f.z, zero);
      const R side = sqrt(f.x * f.x + f.y * f.y);
      const R bound = slope_max_[i] * up;
      const R cut = select(bound < side, bound / max(side, R(1e-12)), one);
      saturated[i].is = (f.z < zero) | (bound < side);
      f = {cut * f.x, cut * f.y, up};
      const R size = norm(f);
      saturated[i].is =
          saturated[i].is | (size < limits_.thrust_min[i]) | (limits_.thrust_max[i] < size);
      const R wanted = clamp(size, limits_.thrust_min[i], limits_.thrust_max[i]);
      const R stretch = wanted / max(size, R(1e-12));
      // A force of no size has no direction: it becomes upright.
      f = select<R>(R(1e-9) < size, stretch * f, {zero, zero, wanted});
    }
  }

 private:
  LimitParameters<R> limits_;
  std::vector<R> slope_max_;
};

}  // namespace multilift::spatial
