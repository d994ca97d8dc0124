// A vector in space: x, y, z in one unit; which frame it is in stands where it is used.
#pragma once

#include "multilift/scalar/real.hpp"

namespace multilift {

template <class R>
struct Vec3 {
  R x{0.0};
  R y{0.0};
  R z{0.0};

  friend MULTILIFT_INLINE Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend MULTILIFT_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend MULTILIFT_INLINE Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend MULTILIFT_INLINE Vec3 operator*(const R& k, const Vec3& a) {
    return {k * a.x, k * a.y, k * a.z};
  }
  MULTILIFT_INLINE Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
  MULTILIFT_INLINE Vec3& operator-=(const Vec3& b) { return *this = *this - b; }
};

template <class R>
MULTILIFT_INLINE R dot(const Vec3<R>& a, const Vec3<R>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class R>
MULTILIFT_INLINE Vec3<R> cross(const Vec3<R>& a, const Vec3<R>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Component by component.
template <class R>
MULTILIFT_INLINE Vec3<R> scale(const Vec3<R>& a, const Vec3<R>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

template <Real R>
MULTILIFT_INLINE R norm(const Vec3<R>& a) {
  return sqrt(dot(a, a));
}

template <class R>
MULTILIFT_INLINE Vec3<R> select(const mask_t<R>& mask, const Vec3<R>& a, const Vec3<R>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

}  // namespace multilift
