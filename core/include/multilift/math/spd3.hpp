// The symmetric positive definite 3x3 system that one step of the planar plant solves.
#pragma once

#include <array>

#include "multilift/scalar/real.hpp"

namespace multilift {

/// Lower triangle of a symmetric matrix, row by row: a00, a10, a11, a20, a21, a22.
template <Real R>
struct Symmetric3 {
  R a00{0.0}, a10{0.0}, a11{0.0}, a20{0.0}, a21{0.0}, a22{0.0};
};

/// Solves A x = b by cofactors: one division, where a factorisation chains three. Accurate for the
/// well-scaled positive definite matrices it is meant for; NaN where A is singular.
template <Real R>
MULTILIFT_INLINE std::array<R, 3> solve_spd(const Symmetric3<R>& a, const std::array<R, 3>& b) {
  const R c00 = a.a11 * a.a22 - a.a21 * a.a21;
  const R c10 = a.a20 * a.a21 - a.a10 * a.a22;
  const R c20 = a.a10 * a.a21 - a.a20 * a.a11;
  const R c11 = a.a00 * a.a22 - a.a20 * a.a20;
  const R c21 = a.a10 * a.a20 - a.a00 * a.a21;
  const R c22 = a.a00 * a.a11 - a.a10 * a.a10;
  const R determinant = a.a00 * c00 + a.a10 * c10 + a.a20 * c20;
  // A hundred roundings of its largest product leave no digit of a smaller determinant.
  const R resolved = R(2e-14) * a.a00 * a.a11 * a.a22;
  const R scale =
      select(resolved < determinant, R(1.0), R(std::numeric_limits<double>::quiet_NaN())) /
      determinant;
  return {scale * (c00 * b[0] + c10 * b[1] + c20 * b[2]),
          scale * (c10 * b[0] + c11 * b[1] + c21 * b[2]),
          scale * (c20 * b[0] + c21 * b[1] + c22 * b[2])};
}

}  // namespace multilift
