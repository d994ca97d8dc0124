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
  Rate k2 = rate_at(Stage::middle, x.moved(k1, 0.5 * h));
  Rate first_two = k1 + 2.0 * k2;
  Rate k3 = rate_at(Stage::middle, x.moved(k2, 0.5 * h));
  Rate first_three = first_two + 2.0 * k3;
  Rate k4 = rate_at(Stage::end, x.moved(k3, h));
  return x.moved(first_three + k4, h / 6.0);
}

}  // namespace multilift
