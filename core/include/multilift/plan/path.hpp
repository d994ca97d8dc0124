// A way through space as polynomials in time, piece by piece.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace multilift::plan {

/// The highest power of time in a piece: values and four derivatives given at both ends.
inline constexpr std::size_t degree = 9;
/// Coefficients of (t - start)^k.
using Polynomial = std::array<double, degree + 1>;
/// A value and its first four time derivatives.
using Derivatives = std::array<double, 5>;

/// Value and the first N - 1 derivatives at t by Horner's rule.
template <std::size_t N = 5>
std::array<double, N> evaluate(const Polynomial& c, double t) {
  std::array<double, N> value{};
  for (std::size_t j = degree + 1; j-- > 0;) {
    for (std::size_t k = N - 1; k > 0; --k)
      value[k] = value[k] * t + static_cast<double>(k) * value[k - 1];
    value[0] = value[0] * t + c[j];
  }
  return value;
}

template <std::size_t D>
struct Piece {
  double start;  // s
  std::array<Polynomial, D> coordinate;
};

/// Pieces in ascending order, each until the next one. Before the first one all is as it begins,
/// from `end` on it stands still.
template <std::size_t D>
struct Path {
  std::vector<Piece<D>> pieces;
  double end{0.0};

  /// Value and the first N - 1 derivatives of every coordinate.
  template <std::size_t N = 5>
  std::array<std::array<double, N>, D> at(double time) const {
    std::size_t k = pieces.size() - 1;
    while (k > 0 && time < pieces[k].start) --k;
    const bool over = end <= time;
    const double t = std::max((over ? end : time) - pieces[k].start, 0.0);
    std::array<std::array<double, N>, D> all;
    for (std::size_t c = 0; c < D; ++c) {
      all[c] = evaluate<N>(pieces[k].coordinate[c], t);
      if (over) std::fill(all[c].begin() + 1, all[c].end(), 0.0);
    }
    return all;
  }
};

}  // namespace multilift::plan
