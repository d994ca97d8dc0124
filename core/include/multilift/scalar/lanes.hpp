// W worlds side by side in one SIMD register (or several): the scalar type of batched rollouts.
//
// Memory: W contiguous doubles. A compiler's vector extension does the arithmetic, so the same
// source serves SSE2, AVX2, AVX-512 and NEON; the instruction set is the translation unit's.
#pragma once

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
  Bits bits;

  friend MULTILIFT_INLINE LaneMask operator&(LaneMask a, LaneMask b) { return {a.bits & b.bits}; }
  friend MULTILIFT_INLINE LaneMask operator|(LaneMask a, LaneMask b) { return {a.bits | b.bits}; }
  friend MULTILIFT_INLINE LaneMask operator!(LaneMask a) { return {~a.bits}; }
  bool operator[](int lane) const { return bits[lane] != 0; }
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

  friend MULTILIFT_INLINE LaneMask<W> operator<(Lanes a, Lanes b) { return {a.v < b.v}; }
  friend MULTILIFT_INLINE LaneMask<W> operator<=(Lanes a, Lanes b) { return {a.v <= b.v}; }
  friend MULTILIFT_INLINE LaneMask<W> operator>(Lanes a, Lanes b) { return {a.v > b.v}; }
  friend MULTILIFT_INLINE LaneMask<W> operator>=(Lanes a, Lanes b) { return {a.v >= b.v}; }
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
  return select(x < Lanes<W>(0.0), -x, x);
}

template <int W>
MULTILIFT_INLINE bool any(LaneMask<W> mask) {
  bool result = false;
  for (int k = 0; k < W; ++k) result |= mask[k];
  return result;
}

template <int W>
MULTILIFT_INLINE bool all(LaneMask<W> mask) {
  return !any(!mask);
}

}  // namespace multilift
