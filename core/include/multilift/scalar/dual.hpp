// A value with its exact first derivatives along N directions (forward differentiation).
//
// Memory: N + 1 doubles. Comparisons look at the value only, so a `select` differentiates the
// branch that the value takes.
#pragma once

#include <array>

#include "multilift/scalar/real.hpp"

namespace multilift {

template <int N>
struct Dual {
  double x{0.0};
  std::array<double, N> d{};

  Dual() = default;
  Dual(double value) : x(value) {}  // NOLINT(google-explicit-constructor): a literal is a Real

  /// An independent variable: value x, unit derivative along `direction`.
  static Dual variable(double x, int direction) {
    Dual result(x);
    result.d[static_cast<std::size_t>(direction)] = 1.0;
    return result;
  }

  /// f(a) from f's value and slope at a.x.
  static Dual chain(double f, double slope, const Dual& a) {
    Dual r(f);
    for (std::size_t k = 0; k < N; ++k) r.d[k] = slope * a.d[k];
    return r;
  }

  friend Dual operator+(const Dual& a, const Dual& b) { return combine(a.x + b.x, 1.0, a, 1.0, b); }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return combine(a.x - b.x, 1.0, a, -1.0, b);
  }
  friend Dual operator*(const Dual& a, const Dual& b) { return combine(a.x * b.x, b.x, a, a.x, b); }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double q = a.x / b.x;
    return combine(q, 1.0 / b.x, a, -q / b.x, b);
  }
  friend Dual operator-(const Dual& a) { return chain(-a.x, -1.0, a); }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.x < b.x; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.x <= b.x; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.x > b.x; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.x >= b.x; }

 private:
  static Dual combine(double f, double fa, const Dual& a, double fb, const Dual& b) {
    Dual r(f);
    for (std::size_t k = 0; k < N; ++k) r.d[k] = fa * a.d[k] + fb * b.d[k];
    return r;
  }
};

template <int N>
Dual<N> sqrt(const Dual<N>& a) {
  const double root = std::sqrt(a.x);
  return Dual<N>::chain(root, 0.5 / root, a);
}

template <int N>
Dual<N> abs(const Dual<N>& a) {
  return a.x < 0.0 ? -a : a;
}

template <int N>
Dual<N> exp(const Dual<N>& a) {
  const double e = std::exp(a.x);
  return Dual<N>::chain(e, e, a);
}

template <int N>
Dual<N> atan(const Dual<N>& a) {
  return Dual<N>::chain(std::atan(a.x), 1.0 / (1.0 + a.x * a.x), a);
}

template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double squared = x.x * x.x + y.x * y.x;
  Dual<N> r(std::atan2(y.x, x.x));
  for (std::size_t k = 0; k < N; ++k) r.d[k] = (x.x * y.d[k] - y.x * x.d[k]) / squared;
  return r;
}

template <int N>
Dual<N> select(bool mask, const Dual<N>& a, const Dual<N>& b) {
  return mask ? a : b;
}

template <int N>
double value(const Dual<N>& a) {
  return a.x;
}

}  // namespace multilift
