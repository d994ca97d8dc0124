// The exponential function, the same to the last bit for a double and a lane.
//
// x = k ln 2 + r with |r| <= ln(2)/2, by parts of ln 2 (Cody and Waite), then a minimax polynomial
// whose error in exact arithmetic is below 6e-20 (core/tools/minimax.py). For every x the error is
// below 1 unit in the last place of the result, subnormal ones included (tests/test_exp.py); beyond
// the range of doubles the result is infinity or 0.
#pragma once

#include "multilift/math/polynomial.hpp"
#include "multilift/scalar/dual.hpp"

namespace multilift {

template <Real R>
R exp(const R& x) {
  // Beyond these bounds the result is infinite or rounds to 0; NaN passes through both.
  const R bounded = clamp(x, R(-746.0), R(710.0));
  // Adding 1.5 * 2^52 rounds to the nearest integer, which then is the sum's low bits.
  const R shift(0x1.8p52);
  const R shifted = bounded * R(0x1.71547652b82fep+0) + shift;
  const R k = shifted - shift;
  // The first part of ln 2 has 41 bits: its product with k is exact, and so is the difference.
  const R high = bounded - k * R(0x1.62e42fefa3000p-1);
  const R low = k * R(0x1.3de6af278ece6p-42);
  const R r = high - low;
  const R p = polynomial(
      {0x1.0000000000000p-1, 0x1.555555555555cp-3, 0x1.555555555555ep-5, 0x1.111111110ebb2p-7,
       0x1.6c16c16c13569p-10, 0x1.a01a01b3bb2dap-13, 0x1.a01a01b45c9ccp-16, 0x1.71ddef93b48d8p-19,
       0x1.27e4bf2556f2dp-22, 0x1.af6cccfa7e8a5p-26, 0x1.1f9dfca510901p-29},
      r);
  const R power = R(1.0) + (high + ((r * r) * p - low));
  // 2^k as a product, since k goes beyond the exponents of normal numbers; where the result is
  // subnormal the last factor rounds, once.
  const R half_shifted = k * R(0.5) + shift;
  const auto half = bits_of(half_shifted) - bits_of(shift);
  const auto rest = (bits_of(shifted) - bits_of(shift)) - half;
  const auto one = bits_of(R(1.0));
  return (power * from_bits<R>((half << 52) + one)) * from_bits<R>((rest << 52) + one);
}

template <int N>
Dual<N> exp(const Dual<N>& a) {
  const double e = exp(a.x);
  return Dual<N>::chain(e, e, a);
}

}  // namespace multilift
