// How far the payload's attitude is from level with the target's heading.
#pragma once

#include "multilift/control/spatial/target.hpp"

namespace multilift::spatial {

/// The axes of the level frame with the target's heading, W.
template <Real R>
MULTILIFT_INLINE Rotation<R> level_at(const SinCos<R>& heading) {
  const R zero(0.0), one(1.0);
  return {{heading.cos, heading.sin, zero}, {-heading.sin, heading.cos, zero}, {zero, zero, one}};
}

/// The error on SO(3) of an attitude to a wanted one, in the attitude's own frame: the vector of
/// (W' R - R' W) / 2, which is the sine of the angle along the axis.
template <Real R>
struct AttitudeError {
  Rotation<R> wanted;  // the wanted axes in the attitude's frame: R' W
  Vec3<R> error;

  MULTILIFT_INLINE AttitudeError(const Rotation<R>& turn, const Rotation<R>& target)
      : wanted{turn.to_body(target.x), turn.to_body(target.y), turn.to_body(target.z)} {
    const auto& [x, y, z] = wanted;
    error = R(0.5) * Vec3<R>{z.y - y.z, x.z - z.x, y.x - x.y};
  }

  /// The error's rate at a rate of turning relative to the wanted attitude, in this frame.
  MULTILIFT_INLINE Vec3<R> rate(const Vec3<R>& turning) const {
    const R trace = wanted.x.x + wanted.y.y + wanted.z.z;
    return R(0.5) * (trace * turning - wanted.to_world(turning));
  }
};

}  // namespace multilift::spatial
