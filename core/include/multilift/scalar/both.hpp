// A quantity of both cables, or of both vehicles, side by side.
//
// What holds for each of the two alike is written once and computed for them together. Memory: for
// double one SIMD register, otherwise two R. Everything goes element by element, so that each of
// the two has the bits that it would have alone.
#pragma once

#include <array>
#include <type_traits>

#include "multilift/math/sincos.hpp"
#include "multilift/math/vec2.hpp"
#include "multilift/scalar/lanes.hpp"

namespace multilift {

template <class R>
struct Two {
  R first, second;

  Two(const R& a, const R& b) : first(a), second(b) {}
  explicit Two(const R& same) : Two(same, same) {}

  const R& operator[](int i) const { return i == 0 ? first : second; }

  friend MULTILIFT_INLINE Two operator+(const Two& a, const Two& b) {
    return {a.first + b.first, a.second + b.second};
  }
  friend MULTILIFT_INLINE Two operator-(const Two& a, const Two& b) {
    return {a.first - b.first, a.second - b.second};
  }
  friend MULTILIFT_INLINE Two operator*(const Two& a, const Two& b) {
    return {a.first * b.first, a.second * b.second};
  }
  friend MULTILIFT_INLINE Two operator-(const Two& a) { return {-a.first, -a.second}; }
};

template <class R>
using Both = std::conditional_t<std::is_same_v<R, double>, Lanes<2>, Two<R>>;

/// One value for each of the two ...
template <class R>
MULTILIFT_INLINE Both<R> both(const R& a, const R& b) {
  if constexpr (std::is_same_v<R, double>)
    return Lanes<2>(Lanes<2>::Vector{a, b});
  else
    return {a, b};
}
template <class R>
MULTILIFT_INLINE Both<R> both(const std::array<R, 2>& x) {
  return both<R>(x[0], x[1]);
}
template <class R>
MULTILIFT_INLINE Vec2<Both<R>> both(const std::array<Vec2<R>, 2>& x) {
  return {both<R>(x[0].y, x[1].y), both<R>(x[0].z, x[1].z)};
}

/// ... or the same for both.
template <class R>
MULTILIFT_INLINE Both<R> both(const R& same) {
  return Both<R>(same);
}
template <class R>
MULTILIFT_INLINE Vec2<Both<R>> both(const Vec2<R>& same) {
  return {Both<R>(same.y), Both<R>(same.z)};
}

/// Apart again.
template <class R>
MULTILIFT_INLINE std::array<R, 2> each(const Both<R>& x) {
  return {x[0], x[1]};
}
template <class R>
MULTILIFT_INLINE std::array<Vec2<R>, 2> each(const Vec2<Both<R>>& x) {
  return {Vec2<R>{x.y[0], x.z[0]}, Vec2<R>{x.y[1], x.z[1]}};
}

/// The first, and the second with the opposite sign: the paper counts the second cable's angle the
/// other way round.
MULTILIFT_INLINE Lanes<2> alternate(const Lanes<2>& x) {
  return x * Lanes<2>(Lanes<2>::Vector{1.0, -1.0});
}
template <class R>
MULTILIFT_INLINE Two<R> alternate(const Two<R>& x) {
  return {x.first, -x.second};
}

/// First plus second.
MULTILIFT_INLINE double sum(const Lanes<2>& x) { return x[0] + x[1]; }
template <class R>
MULTILIFT_INLINE R sum(const Two<R>& x) {
  return x.first + x.second;
}
template <class B>
MULTILIFT_INLINE auto sum(const Vec2<B>& x) {
  return Vec2{sum(x.y), sum(x.z)};
}

template <class R>
MULTILIFT_INLINE SinCos<Two<R>> sincos(const Two<R>& x) {
  SinCos<R> first = sincos(x.first), second = sincos(x.second);
  return {{first.sin, second.sin}, {first.cos, second.cos}};
}

}  // namespace multilift
