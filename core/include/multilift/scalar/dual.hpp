// A value with its exact first derivatives along N directions (forward differentiation).
//
// Memory: N + 1 doubles, and padding where the derivatives lie in one vector register. Comparisons
// look at the value only, so a `select` differentiates the branch that the value takes.
#pragma once

#include <array>
#include <type_traits>

#include "multilift/scalar/lanes.hpp"

namespace multilift {

/// Doubles in a vector register of the translation unit's instruction set.
#if defined(__AVX512F__)
inline constexpr int register_width = 8;
#elif defined(__AVX__)
inline constexpr int register_width = 4;
#else
inline constexpr int register_width = 2;
#endif

template <int N>
struct ArrayOf {
  using type = std::array<double, static_cast<std::size_t>(N)>;
};

template <int N>
struct Dual {
  /// Whether one register holds the derivatives, for which compilers do not find it by themselves.
  static constexpr bool packed = N == register_width || (N == 4 && register_width == 8) || N == 2;

  double x{0.0};
  typename std::conditional_t<packed, VectorOf<double, packed ? N : 2>, ArrayOf<N>>::type d{};

  Dual() = default;
  Dual(double value) : x(value) {}  // NOLINT(google-explicit-constructor): a literal is a Real

  /// An independent variable: value x, unit derivative along `direction`.
  static Dual variable(double x, int direction) {
    Dual result(x);
    result.d[static_cast<std::size_t>(direction)] = 1.0;
    return result;
  }

  /// f(a) from f's value and slope at a.x.
  static MULTILIFT_INLINE Dual chain(double f, double slope, const Dual& a) {
    return each(f, [&](const auto& da) { return slope * da; }, a.d);
  }

  friend MULTILIFT_INLINE Dual operator+(const Dual& a, const Dual& b) {
    return each(a.x + b.x, [](const auto& da, const auto& db) { return da + db; }, a.d, b.d);
  }
  friend MULTILIFT_INLINE Dual operator-(const Dual& a, const Dual& b) {
    return each(a.x - b.x, [](const auto& da, const auto& db) { return da - db; }, a.d, b.d);
  }
  friend MULTILIFT_INLINE Dual operator*(const Dual& a, const Dual& b) {
    return each(
        a.x * b.x, [&](const auto& da, const auto& db) { return b.x * da + a.x * db; }, a.d, b.d);
  }
  friend MULTILIFT_INLINE Dual operator/(const Dual& a, const Dual& b) {
    const double q = a.x / b.x, by_a = 1.0 / b.x, by_b = -q / b.x;
    return each(q, [&](const auto& da, const auto& db) { return by_a * da + by_b * db; }, a.d, b.d);
  }
  friend MULTILIFT_INLINE Dual operator-(const Dual& a) {
    return each(-a.x, [](const auto& da) { return -da; }, a.d);
  }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.x < b.x; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.x <= b.x; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.x > b.x; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.x >= b.x; }

 private:
  /// A value with f of the derivatives, direction by direction.
  template <class F, class... D>
  static MULTILIFT_INLINE Dual each(double value, const F& f, const D&... derivatives) {
    Dual r(value);
    if constexpr (packed)
      r.d = f(derivatives...);
    else
      for (std::size_t k = 0; k < N; ++k) r.d[k] = f(derivatives[k]...);
    return r;
  }
};

/// At 0, where it has no slope, with slope 0: what |v| v asks for at rest.
template <int N>
Dual<N> sqrt(const Dual<N>& a) {
  const double root = std::sqrt(a.x);
  return Dual<N>::chain(root, a.x == 0.0 ? 0.0 : 0.5 / root, a);
}

template <int N>
Dual<N> abs(const Dual<N>& a) {
  return a.x < 0.0 ? -a : a;
}

template <int N>
Dual<N> select(bool mask, const Dual<N>& a, const Dual<N>& b) {
  return mask ? a : b;
}

template <int N>
double value(const Dual<N>& a) {
  return a.x;
}

template <int N>
inline constexpr bool differentiates<Dual<N>> = true;

}  // namespace multilift
