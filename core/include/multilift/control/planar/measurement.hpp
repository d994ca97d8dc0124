// What a planar control law is given at each control instant, and what it must offer.
#pragma once

#include <concepts>

#include "multilift/model/planar/energy.hpp"

namespace multilift::planar {

template <Real R>
struct Measurement {
  double time{0.0};                                    // of the control instant, s
  std::array<Vec2<R>, 2> vehicle;                      // xi_i, world y-z, m
  std::array<Vec2<R>, 2> vehicle_velocity;             // m/s
  std::array<R, 3> theta{R(0.0), R(0.0), R(0.0)};      // rad
  std::array<SinCos<R>, 3> angle;                      // sine and cosine of theta
  std::array<R, 3> theta_dot{R(0.0), R(0.0), R(0.0)};  // rad/s
  std::array<mask_t<R>, 2> saturated{};                // vehicle i's last command hit a limit
  const Target<R>* target{nullptr};                    // where all shall be; null: at the goal

  /// Pairs every sensed number with another measurement's.
  template <class F>
  void visit_scalars(const Measurement& other, F&& f) {
    for (std::size_t i = 0; i < 2; ++i) {
      f(vehicle[i].y, other.vehicle[i].y);
      f(vehicle[i].z, other.vehicle[i].z);
      f(vehicle_velocity[i].y, other.vehicle_velocity[i].y);
      f(vehicle_velocity[i].z, other.vehicle_velocity[i].z);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      f(theta[k], other.theta[k]);
      f(angle[k].sin, other.angle[k].sin);
      f(angle[k].cos, other.angle[k].cos);
      f(theta_dot[k], other.theta_dot[k]);
    }
  }
};

template <Real R>
using Command = std::array<Vec2<R>, 2>;  // the paper's u = [u1 u2 u3 u4], N

/// A control law: constructed from its gains, the plant it assumes, the goal and its period;
/// stepped once a period; able to name the gains of its storage function and its drag estimate.
/// One law is one file with a `Gains` struct that describes itself, and one line in laws.hpp.
template <class Law, class R>
concept ControlLaw = Real<R> && requires(Law law, const Measurement<R>& measured) {
  { law.step(measured) } -> std::same_as<Command<R>>;
  law.storage_gains();
  { law.d_hat() } -> std::convertible_to<std::array<Vec2<R>, 2>>;
};

}  // namespace multilift::planar
