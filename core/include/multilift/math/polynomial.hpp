// Polynomials with literal coefficients, lowest power first.
#pragma once

#include <array>

#include "multilift/scalar/real.hpp"

namespace multilift {

/// c[0] + c[1] x + ... by pairs (Estrin): the loop around waits for its latency, which grows with
/// the logarithm of the degree.
template <Real R, std::size_t N>
MULTILIFT_INLINE R by_pairs(const std::array<R, N>& c, const R& x) {
  if constexpr (N == 1) {
    return c[0];
  } else {
    std::array<R, (N + 1) / 2> pairs;
    for (std::size_t k = 0; k < N / 2; ++k) pairs[k] = c[2 * k] + c[2 * k + 1] * x;
    if constexpr (N % 2 == 1) pairs[N / 2] = c[N - 1];
    return by_pairs(pairs, x * x);
  }
}

template <Real R, std::size_t N>
MULTILIFT_INLINE R polynomial(const double (&coefficients)[N], const R& x) {
  std::array<R, N> c;
  for (std::size_t k = 0; k < N; ++k) c[k] = R(coefficients[k]);
  return by_pairs(c, x);
}

}  // namespace multilift
