// Sine and cosine together, the same to the last bit for a double and a lane.
//
// Reduction by multiples of pi/2 in three parts (Cody and Waite), then minimax polynomials on
// [-pi/4, pi/4] whose relative error in exact arithmetic is below 4e-18. Valid for |x| < 1e5; the
// error there is below 1 unit in the last place of a result of size 1 (tests/test_sincos.py).
#pragma once

#include <array>

#include "multilift/scalar/dual.hpp"
#include "multilift/scalar/real.hpp"

namespace multilift {

template <class R>
struct SinCos {
  R sin;
  R cos;
};

/// Sine and cosine of r in [-pi/4, pi/4].
template <Real R>
MULTILIFT_INLINE SinCos<R> sincos_reduced(const R& r) {
  const R u = r * r;
  // Both polynomials by pairs (Estrin): the loop around waits for their latency.
  const R u2 = u * u;
  const R p = (R(-0x1.5555555555549p-3) + R(0x1.111111110f871p-7) * u) +
              u2 * ((R(-0x1.a01a019c105cdp-13) + R(0x1.71de35769858cp-19) * u) +
                    u2 * (R(-0x1.ae5e6551e13e6p-26) + R(0x1.5d92bb3538f29p-33) * u));
  const R q = (R(0x1.555555555554cp-5) + R(-0x1.6c16c16c15173p-10) * u) +
              u2 * ((R(0x1.a01a019cb0b22p-16) + R(-0x1.27e4f80926e1fp-22) * u) +
                    u2 * (R(0x1.1ee9eb5aa2bbcp-29) + R(-0x1.8fae5000d43dep-37) * u));
  const R half = R(0.5) * u;
  const R head = R(1.0) - half;
  // (1 - head) - half is what rounding took from head.
  return {r + (r * u) * p, head + (((R(1.0) - head) - half) + u2 * q)};
}

template <Real R>
MULTILIFT_INLINE SinCos<R> sincos(const R& x) {
  // Swinging loads stay here; the rest of this function would give the same bits for them.
  if (all(abs(x) < R(0.785))) return sincos_reduced(x);

  // Adding and subtracting 1.5 * 2^52 rounds to the nearest integer in the default rounding mode.
  const R shift(0x1.8p52);
  const R k = (x * R(0x1.45f306dc9c883p-1) + shift) - shift;
  // pi/2 in parts of 33 bits: their products with k are exact up to |k| = 2^20.
  const R r =
      ((x - k * R(0x1.921fb544p+0)) - k * R(0x1.0b4611a6p-34)) - k * R(0x1.3198a2e037073p-69);
  const auto [sine, cosine] = sincos_reduced(r);

  // k mod 4 in {-2, -1, 0, 1, 2}: odd swaps sine and cosine, |.| and sign choose the half plane.
  const R quadrant = k - R(4.0) * ((k * R(0.25) + shift) - shift);
  const R size = abs(quadrant);
  const auto odd = abs(size - R(1.0)) < R(0.5);
  const auto opposite = R(1.5) < size;
  const R s = select(odd, cosine, sine);
  const R c = select(odd, sine, cosine);
  const auto negative_sine = opposite | (quadrant < R(-0.5));
  const auto negative_cosine = opposite | (R(0.5) < quadrant);
  return {select(negative_sine, -s, s), select(negative_cosine, -c, c)};
}

template <int N>
MULTILIFT_INLINE SinCos<Dual<N>> sincos(const Dual<N>& a) {
  const auto [s, c] = sincos(a.x);
  return {Dual<N>::chain(s, c, a), Dual<N>::chain(c, -s, a)};
}

/// Several angles at once.
template <Real R, std::size_t N>
MULTILIFT_INLINE std::array<SinCos<R>, N> sincos_each(const std::array<R, N>& x) {
  std::array<SinCos<R>, N> result;
  for (std::size_t k = 0; k < N; ++k) result[k] = sincos(x[k]);
  return result;
}

}  // namespace multilift
