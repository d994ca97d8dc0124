// Pushes: outside forces given as functions of time.
#pragma once

#include <numbers>
#include <vector>

#include "multilift/math/sincos.hpp"
#include "multilift/sim/rk4.hpp"

namespace multilift {

enum class PushShape { pulse, half_sine, sine, samples };

/// A force profile of height 1 between start and start + duration, 0 outside.
template <Real R>
struct PushProfile {
  PushShape shape{PushShape::pulse};
  R start{0.0};      // s
  R duration{0.0};   // s
  R frequency{0.0};  // Hz, for sine
  // For samples: two or more times after `start`, s, ascending, with values; linear between them
  // and 0 beyond.
  std::vector<double> sample_times;
  std::vector<double> sample_values;

  /// The height at a stage of an integration step. At the profile's two edges a step that starts
  /// there sees what follows and a step that ends there what went before, so that an edge on the
  /// step grid costs the integrator no order.
  R at(const R& time, Stage stage) const {
    constexpr double rounding = 1e-9;  // s: what time, a multiple of the step, may be off by
    const double bias = stage == Stage::start ? rounding : stage == Stage::end ? -rounding : 0.0;
    const bool sampled = shape == PushShape::samples;
    const R first = sampled ? max(R(0.0), R(sample_times.front())) : R(0.0);
    const R last = sampled ? min(duration, R(sample_times.back())) : duration;
    const R since = time - start;
    const auto active = (first <= since + R(bias)) & (since + R(bias) < last);
    if (!any(active)) return R(0.0);
    return select(active, height(clamp(since, first, last)), R(0.0));
  }

 private:
  R height(const R& t) const {
    switch (shape) {
      case PushShape::pulse:
        return R(1.0);
      case PushShape::half_sine:
        return sincos(R(std::numbers::pi) * t / duration).sin;
      case PushShape::sine:
        return sincos(R(2.0 * std::numbers::pi) * frequency * t).sin;
      case PushShape::samples:
        return interpolate(t);
    }
    return R(0.0);
  }

  R interpolate(const R& t) const {
    R result(0.0);
    for (std::size_t k = 1; k < sample_times.size(); ++k) {
      const R t0(sample_times[k - 1]), t1(sample_times[k]);
      const R v0(sample_values[k - 1]), v1(sample_values[k]);
      result = select(t0 <= t, v0 + (v1 - v0) * (t - t0) / (t1 - t0), result);
    }
    return result;
  }
};

}  // namespace multilift
