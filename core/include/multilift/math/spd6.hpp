// The symmetric positive definite 6x6 system that one step of the spatial plant solves.
#pragma once

#include "multilift/math/vec3.hpp"

namespace multilift {

/// Lower triangle of a symmetric 3x3 matrix by rows.
template <Real R>
struct SymmetricBlock {
  R xx{0.0}, yx{0.0}, yy{0.0}, zx{0.0}, zy{0.0}, zz{0.0};

  /// Adds k a a'.
  MULTILIFT_INLINE void add_outer(const R& k, const Vec3<R>& a) {
    const Vec3<R> ka = k * a;
    xx += ka.x * a.x;
    yx += ka.y * a.x;
    yy += ka.y * a.y;
    zx += ka.z * a.x;
    zy += ka.z * a.y;
    zz += ka.z * a.z;
  }
};

/// A 3x3 matrix by rows.
template <Real R>
struct Block {
  Vec3<R> x, y, z;

  /// Adds k a b'.
  MULTILIFT_INLINE void add_outer(const R& k, const Vec3<R>& a, const Vec3<R>& b) {
    x += (k * a.x) * b;
    y += (k * a.y) * b;
    z += (k * a.z) * b;
  }
};

/// The inverse by cofactors, which costs one division; NaN where the matrix is singular.
template <Real R>
MULTILIFT_INLINE SymmetricBlock<R> inverse(const SymmetricBlock<R>& a) {
  const R cxx = a.yy * a.zz - a.zy * a.zy;
  const R cyx = a.zx * a.zy - a.yx * a.zz;
  const R czx = a.yx * a.zy - a.zx * a.yy;
  const R k = R(1.0) / (a.xx * cxx + a.yx * cyx + a.zx * czx);
  return {k * cxx,
          k * cyx,
          k * (a.xx * a.zz - a.zx * a.zx),
          k * czx,
          k * (a.yx * a.zx - a.xx * a.zy),
          k * (a.xx * a.yy - a.yx * a.yx)};
}

template <Real R>
MULTILIFT_INLINE Vec3<R> operator*(const SymmetricBlock<R>& a, const Vec3<R>& b) {
  return {a.xx * b.x + a.yx * b.y + a.zx * b.z, a.yx * b.x + a.yy * b.y + a.zy * b.z,
          a.zx * b.x + a.zy * b.y + a.zz * b.z};
}

/// [A B; B' C] with A and C symmetric.
template <Real R>
struct Symmetric6 {
  SymmetricBlock<R> a;
  Block<R> b;
  SymmetricBlock<R> c;
};

template <Real R>
struct Pair6 {
  Vec3<R> first, second;
};

/// Solves [A B; B' C] [first; second] = [f; g] by the Schur complement of C: two divisions, where
/// a factorisation chains six. Meant for the positive definite matrices of a payload on cables.
template <Real R>
MULTILIFT_INLINE Pair6<R> solve_spd(const Symmetric6<R>& m, const Vec3<R>& f, const Vec3<R>& g) {
  const SymmetricBlock<R> c = inverse(m.c);
  // Rows of B C^-1.
  const Block<R> bc{c * m.b.x, c * m.b.y, c * m.b.z};
  const SymmetricBlock<R> schur{m.a.xx - dot(bc.x, m.b.x), m.a.yx - dot(bc.y, m.b.x),
                                m.a.yy - dot(bc.y, m.b.y), m.a.zx - dot(bc.z, m.b.x),
                                m.a.zy - dot(bc.z, m.b.y), m.a.zz - dot(bc.z, m.b.z)};
  const Vec3<R> first = inverse(schur) * (f - Vec3<R>{dot(bc.x, g), dot(bc.y, g), dot(bc.z, g)});
  const Vec3<R> second = c * (g - (first.x * m.b.x + first.y * m.b.y + first.z * m.b.z));
  return {first, second};
}

}  // namespace multilift
