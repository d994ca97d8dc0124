// Attitudes: unit quaternions, scalar first, and the rotation matrices they stand for.
//
// The attitude q of a frame B turns B's coordinates into the world's: v_W = rotation(q) v_B.
#pragma once

#include "multilift/math/vec3.hpp"

namespace multilift {

template <class R>
struct Quaternion {
  R w{1.0};
  R x{0.0};
  R y{0.0};
  R z{0.0};

  friend MULTILIFT_INLINE Quaternion operator*(const Quaternion& a, const Quaternion& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
};

/// The inverse rotation of a unit quaternion.
template <class R>
MULTILIFT_INLINE Quaternion<R> conjugate(const Quaternion<R>& q) {
  return {q.w, -q.x, -q.y, -q.z};
}

template <Real R>
MULTILIFT_INLINE Quaternion<R> normalised(const Quaternion<R>& q) {
  const R k = R(1.0) / sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {k * q.w, k * q.x, k * q.y, k * q.z};
}

/// The rate of q at the angular rate omega, in the turning frame, rad/s.
template <Real R>
MULTILIFT_INLINE Quaternion<R> quaternion_rate(const Quaternion<R>& q, const Vec3<R>& omega) {
  const R h(0.5);
  return {-h * (q.x * omega.x + q.y * omega.y + q.z * omega.z),
          h * (q.w * omega.x + q.y * omega.z - q.z * omega.y),
          h * (q.w * omega.y + q.z * omega.x - q.x * omega.z),
          h * (q.w * omega.z + q.x * omega.y - q.y * omega.x)};
}

/// Columns are the axes of the turned frame in the world.
template <class R>
struct Rotation {
  Vec3<R> x{R(1.0), R(0.0), R(0.0)};
  Vec3<R> y{R(0.0), R(1.0), R(0.0)};
  Vec3<R> z{R(0.0), R(0.0), R(1.0)};

  /// From the turned frame's coordinates to the world's.
  MULTILIFT_INLINE Vec3<R> to_world(const Vec3<R>& v) const { return v.x * x + v.y * y + v.z * z; }
  /// From the world's coordinates to the turned frame's.
  MULTILIFT_INLINE Vec3<R> to_body(const Vec3<R>& v) const {
    return {dot(x, v), dot(y, v), dot(z, v)};
  }
};

template <Real R>
MULTILIFT_INLINE Rotation<R> rotation(const Quaternion<R>& q) {
  const R one(1.0), two(2.0);
  const R xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const R xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const R wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{one - two * (yy + zz), two * (xy + wz), two * (xz - wy)},
          {two * (xy - wz), one - two * (xx + zz), two * (yz + wx)},
          {two * (xz + wy), two * (yz - wx), one - two * (xx + yy)}};
}

}  // namespace multilift
