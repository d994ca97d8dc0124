// Pushes: outside forces given as functions of time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "multilift/sim/rk4.hpp"

namespace multilift {

enum class PushShape { pulse, half_sine, sine, samples };

/// A force profile of unit height between start and start + duration, 0 outside.
struct PushProfile {
  PushShape shape{PushShape::pulse};
  double start{0.0};      // s
  double duration{0.0};   // s
  double frequency{0.0};  // Hz, for sine
  // For samples: two or more times after `start`, s, ascending, with values; linear between them
  // and 0 beyond.
  std::vector<double> sample_times;
  std::vector<double> sample_values;

  /// The height at a stage of an integration step. At the profile's two edges a step that starts
  /// there sees what follows and a step that ends there what went before, so that an edge on the
  /// step grid costs the integrator no order.
  double at(double time, Stage stage) const {
    constexpr double rounding = 1e-9;  // s: what time, a multiple of the step, may be off by
    const double bias = stage == Stage::start ? rounding : stage == Stage::end ? -rounding : 0.0;
    const bool sampled = shape == PushShape::samples;
    const double first = sampled ? std::max(0.0, sample_times.front()) : 0.0;
    const double last = sampled ? std::min(duration, sample_times.back()) : duration;
    const double t = time - start;
    if (t + bias < first || t + bias >= last) return 0.0;
    switch (shape) {
      case PushShape::pulse:
        return 1.0;
      case PushShape::half_sine:
        return std::sin(std::numbers::pi * t / duration);
      case PushShape::sine:
        return std::sin(2.0 * std::numbers::pi * frequency * t);
      case PushShape::samples:
        return interpolate(t);
    }
    return 0.0;
  }

 private:
  double interpolate(double t) const {
    std::size_t k = 1;
    while (k + 1 < sample_times.size() && sample_times[k] <= t) ++k;
    const double t0 = sample_times[k - 1], t1 = sample_times[k];
    const double v0 = sample_values[k - 1], v1 = sample_values[k];
    return v0 + (v1 - v0) * (t - t0) / (t1 - t0);
  }
};

}  // namespace multilift
