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
};

template <Real R>
using Command = std::array<Vec2<R>, 2>;  // the paper's u = [u1 u2 u3 u4], N

/// A control law: constructed from its gains, the plant it assumes, the goal and its period;
/// stepped once a period; able to name the gains of its storage function and its drag estimate.
/// One law is one file with a `Gains` struct that describes itself, and one line in laws.hpp.
template <class Law, class R>
concept ControlLaw = Real<R> && requires(Law law, const Measurement<R>& measured) {
  { law.step(measured) } -> std::same_as<Command<R>>;
  { law.storage_gains() } -> std::same_as<StorageGains<R>>;
  { law.d_hat() } -> std::convertible_to<std::array<Vec2<R>, 2>>;
};

}  // namespace multilift::planar
