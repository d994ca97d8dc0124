// W worlds side by side in one SIMD register (or several): the scalar type of batched rollouts.
//
// Memory: W contiguous doubles. A compiler's vector extension does the arithmetic, so the same
// source serves SSE2, AVX2, AVX-512 and NEON; the instruction set is the translation unit's.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "multilift/scalar/real.hpp"

namespace multilift {

/// W values of type T in one compiler vector.
template <class T, int W>
struct VectorOf {
  typedef T type __attribute__((vector_size(W * sizeof(T))));
};

template <int W>
struct LaneMask {
  using Bits = typename VectorOf<long long, W>::type;
  Bits bits{};

  LaneMask() = default;
  explicit LaneMask(Bits b) : bits(b) {}

  friend MULTILIFT_INLINE LaneMask operator&(LaneMask a, LaneMask b) {
    return LaneMask(a.bits & b.bits);
  }
  friend MULTILIFT_INLINE LaneMask operator|(LaneMask a, LaneMask b) {
    return LaneMask(a.bits | b.bits);
  }
  friend MULTILIFT_INLINE LaneMask operator!(LaneMask a) { return LaneMask(~a.bits); }
  LaneMask& operator&=(LaneMask b) { return *this = *this & b; }
  LaneMask& operator|=(LaneMask b) { return *this = *this | b; }
  bool operator[](int lane) const { return bits[lane] != 0; }
  void set(int lane, bool truth) { bits[lane] = truth ? -1 : 0; }
};

template <int W>
struct Lanes {
  using Vector = typename VectorOf<double, W>::type;
  static constexpr int width = W;
  Vector v{};

  Lanes() = default;
  Lanes(double x) : v(x - Vector{}) {}  // NOLINT(google-explicit-constructor): a literal is a Real
  explicit Lanes(Vector x) : v(x) {}

  double operator[](int lane) const { return v[lane]; }
  void set(int lane, double x) { v[lane] = x; }

  friend MULTILIFT_INLINE Lanes operator+(Lanes a, Lanes b) { return Lanes(a.v + b.v); }
  friend MULTILIFT_INLINE Lanes operator-(Lanes a, Lanes b) { return Lanes(a.v - b.v); }
  friend MULTILIFT_INLINE Lanes operator*(Lanes a, Lanes b) { return Lanes(a.v * b.v); }
  friend MULTILIFT_INLINE Lanes operator/(Lanes a, Lanes b) { return Lanes(a.v / b.v); }
  friend MULTILIFT_INLINE Lanes operator-(Lanes a) { return Lanes(-a.v); }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
  Lanes& operator-=(Lanes b) { return *this = *this - b; }
  Lanes& operator*=(Lanes b) { return *this = *this * b; }

  friend MULTILIFT_INLINE LaneMask<W> operator<(Lanes a, Lanes b) { return LaneMask<W>(a.v < b.v); }
  friend MULTILIFT_INLINE LaneMask<W> operator<=(Lanes a, Lanes b) {
    return LaneMask<W>(a.v <= b.v);
  }
  friend MULTILIFT_INLINE LaneMask<W> operator>(Lanes a, Lanes b) { return LaneMask<W>(a.v > b.v); }
  friend MULTILIFT_INLINE LaneMask<W> operator>=(Lanes a, Lanes b) {
    return LaneMask<W>(a.v >= b.v);
  }
};

template <int W>
MULTILIFT_INLINE Lanes<W> select(LaneMask<W> mask, Lanes<W> a, Lanes<W> b) {
  return Lanes<W>(mask.bits ? a.v : b.v);
}

template <int W>
MULTILIFT_INLINE Lanes<W> sqrt(Lanes<W> x) {
  for (int k = 0; k < W; ++k) x.v[k] = std::sqrt(x.v[k]);
  return x;
}

template <int W>
MULTILIFT_INLINE Lanes<W> abs(Lanes<W> x) {
  using Bits = typename LaneMask<W>::Bits;
  return Lanes<W>(reinterpret_cast<typename Lanes<W>::Vector>(reinterpret_cast<Bits>(x.v) &
                                                              0x7fffffffffffffffLL));
}

template <int W>
struct WordsOf<Lanes<W>> {
  using type = typename VectorOf<std::uint64_t, W>::type;
};
template <int W>
MULTILIFT_INLINE auto bits_of(Lanes<W> x) {
  return std::bit_cast<words_t<Lanes<W>>>(x.v);
}

template <int W>
MULTILIFT_INLINE bool any(LaneMask<W> mask) {
  // One instruction where there is one: branches ask this a dozen times a step.
#if defined(__AVX512DQ__)
  if constexpr (W == 8) return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask.bits)) != 0;
#endif
#if defined(__AVX__)
  if constexpr (W == 4) return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask.bits)) != 0;
#endif
#if defined(__SSE2__)
  if constexpr (W == 2) return _mm_movemask_pd(reinterpret_cast<__m128d>(mask.bits)) != 0;
#endif
  long long bits = 0;
  for (int k = 0; k < W; ++k) bits |= mask.bits[k];
  return bits != 0;
}

template <int W>
MULTILIFT_INLINE bool all(LaneMask<W> mask) {
  return !any(!mask);
}

template <int W>
inline constexpr int lanes_of<Lanes<W>> = W;
template <int W>
struct LaneScalar<Lanes<W>> {
  using type = double;
};
template <int W>
double lane(const Lanes<W>& x, int k) {
  return x[k];
}
template <int W>
void set_lane(Lanes<W>& x, int k, double share) {
  x.set(k, share);
}
template <int W>
bool lane(const LaneMask<W>& mask, int k) {
  return mask[k];
}
template <int W>
void set_lane(LaneMask<W>& mask, int k, bool truth) {
  mask.set(k, truth);
}

}  // namespace multilift
