// Gaussian elimination with partial pivoting, for the readable reference formulation only.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "multilift/scalar/real.hpp"

namespace multilift {

template <Real R, std::size_t N>
using Matrix = std::array<std::array<R, N>, N>;

/// Solves A x = b. Returns false, and leaves x unspecified, where A is singular to working
/// precision. Pivots are chosen by value, so R is double or dual.
template <Real R, std::size_t N>
bool solve_dense(Matrix<R, N> a, std::array<R, N> b, std::array<R, N>& x) {
  double largest = 0.0;
  for (const auto& row : a)
    for (const R& entry : row) largest = std::fmax(largest, std::fabs(value(entry)));
  for (std::size_t k = 0; k < N; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < N; ++i)
      if (std::fabs(value(a[i][k])) > std::fabs(value(a[pivot][k]))) pivot = i;
    if (!(std::fabs(value(a[pivot][k])) > 1e-14 * largest)) return false;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < N; ++i) {
      const R factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < N; ++j) a[i][j] = a[i][j] - factor * a[k][j];
      b[i] = b[i] - factor * b[k];
    }
  }
  for (std::size_t k = N; k-- > 0;) {
    R sum = b[k];
    for (std::size_t j = k + 1; j < N; ++j) sum = sum - a[k][j] * x[j];
    x[k] = sum / a[k][k];
  }
  return true;
}

}  // namespace multilift
