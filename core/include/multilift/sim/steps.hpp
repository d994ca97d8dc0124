// Times as whole numbers of integration steps, world by world.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "multilift/scalar/real.hpp"

namespace multilift {

template <class R>
using StepsOf = std::array<long, static_cast<std::size_t>(lanes_of<R>)>;

/// A time as a whole number of integration steps, world by world.
template <Real R>
StepsOf<R> steps_of(const R& time, double step) {
  StepsOf<R> steps{};
  for (int k = 0; k < lanes_of<R>; ++k)
    steps[static_cast<std::size_t>(k)] = std::lround(value(lane(time, k)) / step);
  return steps;
}

}  // namespace multilift
