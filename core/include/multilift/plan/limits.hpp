// How fast a polynomial way gets, bounded from above.
//
// Between its ends a polynomial stays within the convex hull of its Bernstein coefficients, and so
// does a curve in space. Halved often enough, the hulls are as narrow as the curve.
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

/// Splits a hull in half (de Casteljau): returns the first half's and leaves the second one's.
template <std::size_t D>
Hull<D> split(Hull<D>& hull, std::size_t size) {
  Hull<D> first;
  for (std::size_t c = 0; c < D; ++c) {
    for (std::size_t k = 0; k < size; ++k) {
      first[c][k] = hull[c][0];
      for (std::size_t i = 0; i + 1 < size - k; ++i)
        hull[c][i] = 0.5 * (hull[c][i] + hull[c][i + 1]);
    }
  }
  return first;
}

/// The hull of a derivative of order 1 to 4 along t/T; `way` is in t/T.
template <std::size_t D>
Hull<D> hull_of(const Coordinates<D>& way, std::size_t order) {
  const std::size_t size = degree + 1 - order;
  Hull<D> hull{};
  for (std::size_t c = 0; c < D; ++c) {
    std::array<double, degree + 1> power{};
    for (std::size_t i = 0; i < size; ++i) {
      double factor = 1.0;
      for (std::size_t k = 0; k < order; ++k) factor *= static_cast<double>(i + order - k);
      power[i] = factor * way[c][i + order] / binomial[size - 1][i];
    }
    for (std::size_t j = 0; j < size; ++j)
      for (std::size_t i = 0; i <= j; ++i) hull[c][j] += binomial[j][i] * power[i];
  }
  return hull;
}

}  // namespace detail

namespace detail {

/// Whether a curve stays within a distance of 0, by its hull, or by those of its halves where that
/// is too wide. The hull's ends lie on the curve.
template <std::size_t D>
bool stays_within(Hull<D> hull, std::size_t size, double square_limit, int depth) {
  if (farthest<D>(hull, size) <= square_limit) return true;
  double first = 0.0, last = 0.0;
  for (std::size_t c = 0; c < D; ++c) {
    first += hull[c][0] * hull[c][0];
    last += hull[c][size - 1] * hull[c][size - 1];
  }
  if (depth == 0 || !(first <= square_limit && last <= square_limit)) return false;
  const Hull<D> half = split<D>(hull, size);
  return stays_within<D>(half, size, square_limit, depth - 1) &&
         stays_within<D>(hull, size, square_limit, depth - 1);
}

}  // namespace detail

/// Whether a piece keeps to all limits.
template <std::size_t D>
bool keeps(const Coordinates<D>& way, double duration, const Limits& limits) {
  constexpr double rounding = 1.0 + 1e-7;
  constexpr int depth = 16;  // where a way touches its limit, to a part of 1e-9 or so
  double time = 1.0;
  for (std::size_t k = 0; k < limits.size(); ++k) {
    time *= duration;
    const double limit = rounding * limits[k] * time;
    if (std::isfinite(limits[k]) &&
        !detail::stays_within<D>(detail::hull_of<D>(way, k + 1), degree - k, limit * limit, depth))
      return false;
  }
  return true;
}

}  // namespace multilift::plan
