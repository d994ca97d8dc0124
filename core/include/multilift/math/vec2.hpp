// A vector in the vertical plane: y to the right, z up, both in the same unit. R is a scalar, or
// two of them (scalar/both.hpp).
#pragma once

#include "multilift/scalar/real.hpp"

namespace multilift {

template <class R>
struct Vec2 {
  R y{0.0};
  R z{0.0};

  friend Vec2 operator+(const Vec2& a, const Vec2& b) { return {a.y + b.y, a.z + b.z}; }
  friend Vec2 operator-(const Vec2& a, const Vec2& b) { return {a.y - b.y, a.z - b.z}; }
  friend Vec2 operator-(const Vec2& a) { return {-a.y, -a.z}; }
  friend Vec2 operator*(const R& k, const Vec2& a) { return {k * a.y, k * a.z}; }
  Vec2& operator+=(const Vec2& b) { return *this = *this + b; }
  Vec2& operator-=(const Vec2& b) { return *this = *this - b; }
};

template <class R>
R dot(const Vec2<R>& a, const Vec2<R>& b) {
  return a.y * b.y + a.z * b.z;
}

/// The moment about x of force b acting at a.
template <class R>
R cross(const Vec2<R>& a, const Vec2<R>& b) {
  return a.y * b.z - a.z * b.y;
}

/// a turned by +90 degrees (from y towards z): the velocity of point a per unit of angular rate.
template <class R>
Vec2<R> perpendicular(const Vec2<R>& a) {
  return {-a.z, a.y};
}

/// a turned by -90 degrees (from z towards y).
template <class R>
Vec2<R> clockwise(const Vec2<R>& a) {
  return {a.z, -a.y};
}

/// Component by component.
template <class R>
Vec2<R> scale(const Vec2<R>& a, const Vec2<R>& b) {
  return {a.y * b.y, a.z * b.z};
}

}  // namespace multilift
