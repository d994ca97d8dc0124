// The natural logarithm of positive normal numbers, the same to the last bit for a double and a
// lane; of anything else, 0, infinity and subnormal numbers included, NaN.
//
// x = 2^k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)), which both are exact. With s = f / (2 + f),
// log(1 + f) = 2 artanh(s) = f - s (f - s^2 P(s^2)), since 2 s = f - s f; this form leaves of the
// rounding of s only a fraction. P is a minimax polynomial whose error in exact arithmetic is below
// 9e-21 of the result (core/tools/minimax.py). The error is below 1 unit in the last place
// (tests/test_log.py).
#pragma once

#include "multilift/math/polynomial.hpp"
#include "multilift/scalar/dual.hpp"

namespace multilift {

template <Real R>
MULTILIFT_INLINE R log(const R& x) {
  constexpr std::uint64_t root_half = 0x3fe6a09e667f3bcd, one = 0x3ff0000000000000;
  constexpr std::uint64_t fraction = 0x000fffffffffffff, two_to_52 = 0x4330000000000000;
  // Counted from sqrt(1/2), the exponent's field is k + 1023 and the fraction that of 1 + f.
  const auto counted = bits_of(x) + (one - root_half);
  const R k = from_bits<R>((counted >> 52) | two_to_52) - R(0x1p52 + 1023.0);
  const R f = from_bits<R>((counted & fraction) + root_half) - R(1.0);
  const R s = f / (R(2.0) + f);
  const R u = s * s;
  const R p = u * polynomial({0x1.5555555555555p-1, 0x1.9999999999dfcp-2, 0x1.249249242b70ep-2,
                              0x1.c71c7258cb971p-3, 0x1.745cde43af40ap-3, 0x1.3b20a9649c2fbp-3,
                              0x1.0f5cf54cafa8fp-3, 0x1.0f61a4017ea2ep-3},
                             u);
  // ln 2 in two parts: the product of k with the first, of 41 bits, is exact.
  const R result = k * R(0x1.62e42fefa3000p-1) + (f - (s * (f - p) - k * R(0x1.3de6af278ece6p-42)));
  const auto inside = (R(std::numeric_limits<double>::min()) <= x) & is_finite(x);
  return select(inside, result, R(std::numeric_limits<double>::quiet_NaN()));
}

template <int N>
Dual<N> log(const Dual<N>& a) {
  return Dual<N>::chain(log(a.x), 1.0 / a.x, a);
}

}  // namespace multilift
