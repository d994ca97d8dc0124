// The classical Runge-Kutta step of order 4, for a rate that depends on time through its stages.
#pragma once

#include "multilift/scalar/real.hpp"

namespace multilift {

/// The three instants of a step at which a rate is evaluated.
enum class Stage { start, middle, end };

/// The state after h, given the rate k1 at the start and rate_at(Stage, state) for the others.
/// State offers moved(rate, h); Rate offers + and scalar *.
template <class State, class Rate, class RateAt>
MULTILIFT_INLINE State rk4_step(const State& x, const Rate& k1, double h, RateAt&& rate_at) {
  // Summed as they come, so that only one rate and the sum need be kept.
  Rate k = rate_at(Stage::middle, x.moved(k1, 0.5 * h));
  Rate sum = k1 + 2.0 * k;
  k = rate_at(Stage::middle, x.moved(k, 0.5 * h));
  sum = sum + 2.0 * k;
  k = rate_at(Stage::end, x.moved(k, h));
  return x.moved(sum + k, h / 6.0);
}

}  // namespace multilift
