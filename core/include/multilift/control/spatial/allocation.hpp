// Which forces the cables shall exert so that a wanted wrench acts on the payload.
//
// Forces f_i at the attachments r_i make the wrench P f = (sum f_i, sum r_i x f_i). The forces of
// least sum of squares that make a given one are P' (P P')^-1 (F, M). About the attachments' mean
// r_m the 6x6 matrix P P' falls into n I and G = sum (|s_i|^2 I - s_i s_i'), s_i = r_i - r_m, so
// that in closed form
//
//     f_i = F / n + b x s_i,   G b = M - r_m x F.
//
// G is singular where cables have no say: moments about the line through the attachments of a bar,
// any moment about the one attachment of a point. Such a moment is not asked for, all else is met
// exactly: b is G's pseudoinverse times the moment.
#pragma once

#include "multilift/math/spd6.hpp"
#include "multilift/model/spatial/parameters.hpp"

namespace multilift::spatial {

/// A force and the moment about the payload's centre of mass, payload frame, N and N m.
template <Real R>
struct Wrench {
  Vec3<R> force, moment;
};

/// Attachments whose width across a line is less than about a hundredth of their length along it
/// count as on that line: moments about it would take forces out of all proportion.
inline constexpr double least_width_squared = 1e-4;
/// Attachments closer together than this count as one point, m.
inline constexpr double least_spread = 1e-3;

namespace detail {

template <Real R>
SymmetricBlock<R> combined(const R& k, const SymmetricBlock<R>& a, const R& l,
                           const SymmetricBlock<R>& b) {
  return {k * a.xx + l * b.xx, k * a.yx + l * b.yx, k * a.yy + l * b.yy,
          k * a.zx + l * b.zx, k * a.zy + l * b.zy, k * a.zz + l * b.zz};
}

template <Real R>
SymmetricBlock<R> squared(const SymmetricBlock<R>& a) {
  return {a.xx * a.xx + a.yx * a.yx + a.zx * a.zx, a.yx * a.xx + a.yy * a.yx + a.zy * a.zx,
          a.yx * a.yx + a.yy * a.yy + a.zy * a.zy, a.zx * a.xx + a.zy * a.yx + a.zz * a.zx,
          a.zx * a.yx + a.zy * a.yy + a.zz * a.zy, a.zx * a.zx + a.zy * a.zy + a.zz * a.zz};
}

template <Real R>
R trace(const SymmetricBlock<R>& a) {
  return a.xx + a.yy + a.zz;
}

template <Real R>
SymmetricBlock<R> chosen(const mask_t<R>& mask, const SymmetricBlock<R>& a,
                         const SymmetricBlock<R>& b) {
  return {select(mask, a.xx, b.xx), select(mask, a.yx, b.yx), select(mask, a.yy, b.yy),
          select(mask, a.zx, b.zx), select(mask, a.zy, b.zy), select(mask, a.zz, b.zz)};
}

/// The pseudoinverse of G = trace(S) I - S of attachments with second moments S about their mean.
template <Real R>
SymmetricBlock<R> pseudoinverse(const SymmetricBlock<R>& g, const R& tiny) {
  const R one(1.0);
  const R size = trace(g);
  const mask_t<R> point = size <= tiny;
  const SymmetricBlock<R> nothing{};
  const SymmetricBlock<R> identity{one, R(0.0), one, R(0.0), R(0.0), one};
  // Of a point everything is left out in the end; until then it shall divide by no zero.
  const SymmetricBlock<R> safe = chosen<R>(point, identity, g);
  const R scale = trace(safe);
  const SymmetricBlock<R> cofactors{
      safe.yy * safe.zz - safe.zy * safe.zy, safe.zx * safe.zy - safe.yx * safe.zz,
      safe.xx * safe.zz - safe.zx * safe.zx, safe.yx * safe.zy - safe.zx * safe.yy,
      safe.yx * safe.zx - safe.xx * safe.zy, safe.xx * safe.yy - safe.yx * safe.yx};
  const R minors = trace(cofactors);
  const R determinant = safe.xx * cofactors.xx + safe.yx * cofactors.yx + safe.zx * cofactors.zx;
  const mask_t<R> line = determinant <= R(least_width_squared) * scale * minors;
  // Of a line the cofactors are the projector on it, up to a part as small as the width's square,
  // which three squarings bring below rounding.
  SymmetricBlock<R> along = combined(one / minors, cofactors, R(0.0), nothing);
  for (int k = 0; k < 3; ++k) {
    const SymmetricBlock<R> next = squared(along);
    along = combined(one / trace(next), next, R(0.0), nothing);
  }
  const R about_line = safe.xx * along.xx + safe.yy * along.yy + safe.zz * along.zz +
                       R(2.0) * (safe.yx * along.yx + safe.zx * along.zx + safe.zy * along.zy);
  // With the line's own eigenvalue raised the inverse exists; then its part is taken out again.
  const SymmetricBlock<R> raised = inverse(combined(one, safe, scale, along));
  const SymmetricBlock<R> of_line = combined(one, raised, -one / (scale + about_line), along);
  return chosen<R>(point, nothing, chosen<R>(line, of_line, inverse(safe)));
}

}  // namespace detail

template <Real R>
class Allocation {
 public:
  explicit Allocation(const std::vector<Vec3<R>>& attachment)
      : share_(1.0 / static_cast<double>(attachment.size())), arm_(attachment) {
    for (const Vec3<R>& r : attachment) mean_ += share_ * r;
    SymmetricBlock<R> g;
    for (Vec3<R>& s : arm_) {
      s -= mean_;
      const R size = dot(s, s);
      g.xx += size;
      g.yy += size;
      g.zz += size;
      g.add_outer(R(-1.0), s);
    }
    const double count = static_cast<double>(attachment.size());
    pseudoinverse_ = detail::pseudoinverse(g, R(2.0 * count * least_spread * least_spread));
  }

  /// What makes up the forces of a wrench: every cable's share, and the b of the moment.
  struct Parts {
    Vec3<R> share;  // N
    Vec3<R> twist;  // N/m
  };
  MULTILIFT_INLINE Parts parts(const Wrench<R>& w) const {
    return {share_ * w.force, pseudoinverse_ * (w.moment - cross(mean_, w.force))};
  }
  /// Cable i's force of least squares, payload frame, N.
  MULTILIFT_INLINE Vec3<R> force(const Parts& parts, std::size_t i) const {
    return parts.share + cross(parts.twist, arm_[i]);
  }

  /// The wrench that forces, payload frame, exert.
  MULTILIFT_INLINE Wrench<R> wrench(const std::vector<Vec3<R>>& force) const {
    Wrench<R> w;
    for (std::size_t i = 0; i < force.size(); ++i) {
      w.force += force[i];
      w.moment += cross(arm_[i], force[i]);
    }
    w.moment += cross(mean_, w.force);
    return w;
  }

 private:
  R share_;
  Vec3<R> mean_;              // r_m, m
  std::vector<Vec3<R>> arm_;  // s_i, m
  SymmetricBlock<R> pseudoinverse_;
};

}  // namespace multilift::spatial
