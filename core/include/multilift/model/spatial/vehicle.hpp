// The paper's vehicle: a point mass under the force that the law asks for. quadrotor.hpp has the
// other kind. Each kind says what it keeps in the state, what drives it, and what force and turning
// follow; the plant in dynamics.hpp does the rest.
#pragma once

#include "multilift/model/spatial/parameters.hpp"
#include "multilift/model/spatial/state.hpp"

namespace multilift::spatial {

/// Vehicles as points: the commanded force acts at once.
template <Real R>
struct IdealVehicles {
  using State = PointMass<R>;
  using Input = Vec3<R>;  // force of the rotors, W, N

  static constexpr const char* name = "ideal";

  struct Parameters {
    explicit Parameters(std::size_t) {}
    template <class Self, class V>
    static void visit(Self&, V&&) {}
  };

  explicit IdealVehicles(const Parameters&) {}

  /// Force of rotors and of the air that they move, W, N; `air` is the vehicle's velocity relative
  /// to the air, W, m/s.
  MULTILIFT_INLINE Vec3<R> force(std::size_t, const State&, const Input& input,
                                 const Vec3<R>& /*air*/) const {
    return input;
  }
  /// Fills the rates of what turns; a point has nothing that does.
  MULTILIFT_INLINE void turn(std::size_t, const State&, const Input&, State&) const {}
};

}  // namespace multilift::spatial
