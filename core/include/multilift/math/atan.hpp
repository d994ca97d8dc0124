// The inverse tangent of one number and of a quotient, the same to the last bit for a double and a
// lane.
//
// t = smaller / larger of |x| and |y| is in [0, 1], where one minimax polynomial serves, whose
// error in exact arithmetic is below 2e-19 of the result (core/tools/minimax.py); multiples of pi/2
// in two parts do the rest. The error is below 2 units in the last place of the result where that
// is normal (tests/test_atan.py). Zeros, infinities and their signs are as IEC 60559 says.
#pragma once

#include <numbers>

#include "multilift/math/polynomial.hpp"
#include "multilift/scalar/dual.hpp"

namespace multilift {

/// The size of the one number with the sign of the other, the sign of a zero included.
template <Real R>
MULTILIFT_INLINE R with_sign(const R& size, const R& sign) {
  constexpr std::uint64_t sign_bit = 0x8000000000000000;
  return from_bits<R>((bits_of(size) & ~sign_bit) | (bits_of(sign) & sign_bit));
}

/// The angle of the point (x, y), in [-pi, pi], rad.
template <Real R>
R atan2(const R& y, const R& x) {
  const R zero(0.0), one(1.0);
  const R ax = abs(x), ay = abs(y);
  const auto steep = ax < ay;
  const R larger = select(steep, ay, ax), smaller = select(steep, ax, ay);
  // Neither 0/0 nor infinity over infinity is left to the division.
  const R quotient = select(larger <= smaller, one, smaller / larger);
  const R t = select((larger <= zero) & (smaller <= zero), zero, quotient);
  const R u = t * t;
  const R q =
      (t * u) * polynomial({-0x1.5555555555554p-2,  0x1.99999999996f8p-3,  -0x1.24924924858b5p-3,
                            0x1.c71c71c326b30p-4,   -0x1.745d16e651e4fp-4, 0x1.3b13ab3b6d594p-4,
                            -0x1.1110ccaa2a2f1p-4,  0x1.e1dd5f6ab7528p-5,  -0x1.af0b5e7e73a03p-5,
                            0x1.858620d3bf035p-5,   -0x1.61e2af7b4135ap-5, 0x1.4047be9adf1c4p-5,
                            -0x1.1bdb916f39f06p-5,  0x1.dfa4e4d8a5df2p-6,  -0x1.7507100f47d40p-6,
                            0x1.00c5cbd70a613p-6,   -0x1.2c4af128077a9p-7, 0x1.1d8f8b308c26fp-8,
                            -0x1.a3635824b08eap-10, 0x1.bacf3b5777bd8p-12, -0x1.298a6604f4141p-14,
                            0x1.7cdbe4d8f84c6p-18},
                           u);
  // The angle from the positive x axis is atan(t), pi/2 - or + it, or pi - it.
  const auto behind = with_sign(one, x) < zero;
  const R quarters = select(steep, one, select(behind, R(2.0), zero));
  const R side = select(behind, -one, one) * select(steep, -one, one);
  const R angle = quarters * R(0x1.921fb54442d18p+0) +
                  (side * t + (side * q + quarters * R(0x1.1a62633145c07p-54)));
  return with_sign(angle, y);
}

template <Real R>
R atan(const R& x) {
  return atan2(x, R(1.0));
}

template <int N>
Dual<N> atan(const Dual<N>& a) {
  return Dual<N>::chain(atan(a.x), 1.0 / (1.0 + a.x * a.x), a);
}

template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double squared = x.x * x.x + y.x * y.x;
  Dual<N> r(atan2(y.x, x.x));
  for (std::size_t k = 0; k < N; ++k) r.d[k] = (x.x * y.d[k] - y.x * x.d[k]) / squared;
  return r;
}

}  // namespace multilift
