// How fast a polynomial way gets, bounded from above.
//
// Between its ends a polynomial stays within the convex hull of its Bernstein coefficients, and so
// does a curve in space. On the quarters of its time the hull is little wider than the curve.
#pragma once

#include <cmath>
#include <limits>

#include "multilift/plan/hermite.hpp"

namespace multilift::plan {

/// Of speed, acceleration, jerk and snap, in this order: m/s to m/s^4.
using Limits = std::array<double, 4>;

namespace detail {

template <std::size_t D>
using Hull = std::array<std::array<double, degree + 1>, D>;  // control points of degree `size`-1

template <std::size_t D>
double farthest(const Hull<D>& hull, std::size_t size) {
  double most = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    double square = 0.0;
    for (std::size_t c = 0; c < D; ++c) square += hull[c][i] * hull[c][i];
    most = square > most ? square : most;
  }
  return most;
}

/// The largest square of a norm over both halves, each halved again `depth` times (de Casteljau).
template <std::size_t D>
double farthest_within(Hull<D> hull, std::size_t size, int depth) {
  if (depth == 0) return farthest<D>(hull, size);
  Hull<D> first;
  for (std::size_t c = 0; c < D; ++c) {
    for (std::size_t k = 0; k < size; ++k) {
      first[c][k] = hull[c][0];
      for (std::size_t i = 0; i + 1 < size - k; ++i)
        hull[c][i] = 0.5 * (hull[c][i] + hull[c][i + 1]);
    }
  }
  // What is left in place is the second half.
  const double a = farthest_within<D>(first, size, depth - 1);
  const double b = farthest_within<D>(hull, size, depth - 1);
  return a > b ? a : b;
}

}  // namespace detail

/// An upper bound of a derivative's norm over a piece, of order 1 to 4; `way` is in t/T.
template <std::size_t D>
double peak(const Coordinates<D>& way, double duration, std::size_t order) {
  const std::size_t size = degree + 1 - order;
  detail::Hull<D> hull{};
  for (std::size_t c = 0; c < D; ++c) {
    std::array<double, degree + 1> power{};
    for (std::size_t i = 0; i < size; ++i) {
      double factor = 1.0;
      for (std::size_t k = 0; k < order; ++k) factor *= static_cast<double>(i + order - k);
      power[i] = factor * way[c][i + order] / detail::binomial[size - 1][i];
    }
    for (std::size_t j = 0; j < size; ++j)
      for (std::size_t i = 0; i <= j; ++i) hull[c][j] += detail::binomial[j][i] * power[i];
  }
  return std::sqrt(detail::farthest_within<D>(hull, size, 2)) /
         std::pow(duration, static_cast<double>(order));
}

/// Whether a piece keeps to all limits.
template <std::size_t D>
bool keeps(const Coordinates<D>& way, double duration, const Limits& limits) {
  const double rounding = 1.0 + 1e-9;
  for (std::size_t k = 0; k < limits.size(); ++k)
    if (std::isfinite(limits[k]) && !(peak<D>(way, duration, k + 1) <= rounding * limits[k]))
      return false;
  return true;
}

}  // namespace multilift::plan
