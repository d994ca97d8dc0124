// Polynomials from what they and their derivatives are at both ends.
#pragma once

#include "multilift/plan/path.hpp"

namespace multilift::plan {

/// A place in D coordinates with its first four time derivatives.
template <std::size_t D>
using Motion = std::array<Derivatives, D>;

template <std::size_t D>
using Coordinates = std::array<Polynomial, D>;

/// Binomial coefficient.
constexpr double choose(std::size_t n, std::size_t k) {
  double value = 1.0;
  for (std::size_t i = 0; i < k; ++i)
    value *= static_cast<double>(n - i) / static_cast<double>(i + 1);
  return value;
}

namespace detail {

/// choose(n, k) for all that a polynomial asks for.
inline constexpr auto binomial = [] {
  std::array<std::array<double, degree + 1>, degree + 1> table{};
  for (std::size_t n = 0; n <= degree; ++n)
    for (std::size_t k = 0; k <= n; ++k) table[n][k] = choose(n, k);
  return table;
}();

/// x^(k) T^k / k!: what a polynomial in t/T has for coefficients.
template <std::size_t N>
std::array<double, N> scaled(const Derivatives& x, double duration) {
  std::array<double, N> value;
  double factor = 1.0;
  for (std::size_t k = 0; k < N; ++k) {
    value[k] = factor * x[k];
    factor *= duration / static_cast<double>(k + 1);
  }
  return value;
}

}  // namespace detail

/// The polynomial of degree 2N - 1 in t/T with N derivatives given at 0 and at T. In
///
///     c_0 + ... + c_{N-1} s^{N-1} + s^N (h_0 + ... + h_{N-1} (s - 1)^{N-1})
///
/// the first half is the start's; h is the Taylor series at 1 of what is left over s^N. With
/// `free_end` the end's value is not given: it is the one that makes the highest power vanish.
template <std::size_t N>
Polynomial join(const Derivatives& from, const Derivatives& to, double duration,
                bool free_end = false) {
  const auto begin = detail::scaled<N>(from, duration), end = detail::scaled<N>(to, duration);
  std::array<double, N> left = end;
  for (std::size_t k = 0; k < N; ++k)
    for (std::size_t i = k; i < N; ++i) left[k] -= detail::binomial[i][k] * begin[i];
  // Of s^-N about 1.
  std::array<double, N> inverse;
  for (std::size_t m = 0; m < N; ++m) inverse[m] = (m % 2 == 0 ? 1.0 : -1.0) * choose(N - 1 + m, m);
  if (free_end) {
    left[0] = 0.0;
    for (std::size_t m = 0; m + 1 < N; ++m)
      left[0] -= inverse[m] * left[N - 1 - m] / inverse[N - 1];
  }
  Polynomial c{};
  for (std::size_t k = 0; k < N; ++k) c[k] = begin[k];
  for (std::size_t m = 0; m < N; ++m) {
    double h = 0.0;
    for (std::size_t k = 0; k <= m; ++k) h += inverse[m - k] * left[k];
    for (std::size_t i = 0; i <= m; ++i)
      c[N + i] += ((m - i) % 2 == 0 ? 1.0 : -1.0) * detail::binomial[m][i] * h;
  }
  return c;
}

/// A polynomial in t/T as one in t.
inline Polynomial in_time(Polynomial c, double duration) {
  double factor = 1.0;
  for (double& x : c) {
    x *= factor;
    factor /= duration;
  }
  return c;
}

}  // namespace multilift::plan
