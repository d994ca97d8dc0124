// The state of the spatial plant: where payload and vehicles are and how they move.
//
// Every body has its own coordinates; taut cables bind them through forces (cables.hpp), so that
// nothing changes when one goes slack. A rate of change is held in the same type as the state, each
// number being the rate of the number in its place.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "multilift/math/rotation.hpp"

namespace multilift::spatial {

/// A body that turns: position of its centre of mass in W, m; attitude to W; velocity in W, m/s;
/// angular rate in the body's own frame, rad/s.
template <class R>
struct RigidBody {
  Vec3<R> position;
  Quaternion<R> attitude;
  Vec3<R> velocity;
  Vec3<R> rate;
};

/// A vehicle seen as a point: position and velocity in W.
template <class R>
struct PointMass {
  Vec3<R> position;
  Vec3<R> velocity;
};

/// Calls f(a.k, b.k, ...) for every number k of states of one type.
template <Real R, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, R& a, Same&... b) {
  f(a, b...);
}
template <class R, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, Vec3<R>& a, Same&... b) {
  f(a.x, b.x...);
  f(a.y, b.y...);
  f(a.z, b.z...);
}
template <class R, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, Quaternion<R>& a, Same&... b) {
  f(a.w, b.w...);
  f(a.x, b.x...);
  f(a.y, b.y...);
  f(a.z, b.z...);
}
template <class R, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, RigidBody<R>& a, Same&... b) {
  zip(f, a.position, b.position...);
  zip(f, a.attitude, b.attitude...);
  zip(f, a.velocity, b.velocity...);
  zip(f, a.rate, b.rate...);
}
template <class R, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, PointMass<R>& a, Same&... b) {
  zip(f, a.position, b.position...);
  zip(f, a.velocity, b.velocity...);
}

/// V is what the kind of vehicle keeps for each: PointMass, or Craft of quadrotor.hpp.
template <class R, class V>
struct State {
  RigidBody<R> payload;
  std::vector<V> vehicle;

  State() = default;
  explicit State(std::size_t n) : vehicle(n) {}
  std::size_t size() const { return vehicle.size(); }
};

template <class R, class V, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, State<R, V>& a, Same&... b) {
  zip(f, a.payload, b.payload...);
  for (std::size_t i = 0; i < a.vehicle.size(); ++i) zip(f, a.vehicle[i], b.vehicle[i]...);
}

/// Quaternions back to unit length, which an integration step leaves by its own error only.
template <Real R, class V>
MULTILIFT_INLINE void normalise(State<R, V>& x) {
  x.payload.attitude = normalised(x.payload.attitude);
  if constexpr (requires(V v) { v.attitude; })
    for (V& vehicle : x.vehicle) vehicle.attitude = normalised(vehicle.attitude);
}

}  // namespace multilift::spatial
