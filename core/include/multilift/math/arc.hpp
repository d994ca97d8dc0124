// Inverse sine, cosine and tangent outside the hot loop, by the C library.
#pragma once

#include <cmath>

#include "multilift/scalar/dual.hpp"

namespace multilift {

inline double arcsin(double x) { return std::asin(x); }
inline double arccos(double x) { return std::acos(x); }
inline double arctan(double x) { return std::atan(x); }

template <int N>
Dual<N> arcsin(const Dual<N>& a) {
  return Dual<N>::chain(std::asin(a.x), 1.0 / std::sqrt(1.0 - a.x * a.x), a);
}
template <int N>
Dual<N> arccos(const Dual<N>& a) {
  return Dual<N>::chain(std::acos(a.x), -1.0 / std::sqrt(1.0 - a.x * a.x), a);
}
template <int N>
Dual<N> arctan(const Dual<N>& a) {
  return Dual<N>::chain(std::atan(a.x), 1.0 / (1.0 + a.x * a.x), a);
}

}  // namespace multilift
