// From the command u to the force on each vehicle.
//
// The paper's outer loop: u_1 = f sin(phi), u_2 = f cos(phi) - (m + m3/2) g, so a command is a
// thrust f and an attitude phi, worked out with the masses that the law assumes. `IdealActuators`
// applies it at once. `TestbedActuators` adds what a
// real vehicle has: limits on thrust and tilt, a command delay, and first-order answers of thrust
// and attitude, solved exactly between instants since their command is held.
#pragma once

#include <cmath>
#include <numbers>

#include "multilift/control/planar/measurement.hpp"
#include "multilift/math/atan.hpp"
#include "multilift/math/exp.hpp"
#include "multilift/sim/delay_line.hpp"
#include "multilift/sim/steps.hpp"

namespace multilift::planar {

template <Real R>
struct ActuatorParameters {
  R thrust_min{0.0};
  R thrust_max{unlimited};
  R tilt_max{std::numbers::pi / 2};
  R thrust_time_constant{0.0};
  R attitude_time_constant{0.0};
  R command_delay{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"thrust_min", "N", Range::non_negative, "least thrust of a vehicle"}, self.thrust_min);
    v(Field{"thrust_max", "N", Range::positive, "greatest thrust of a vehicle"}, self.thrust_max);
    v(Field{"tilt_max", "rad", Range::positive, "greatest attitude angle |phi|, at most pi/2"},
      self.tilt_max);
    v(Field{"thrust_time_constant", "s", Range::non_negative,
            "first-order lag of the thrust; 0 answers at once"},
      self.thrust_time_constant);
    v(Field{"attitude_time_constant", "s", Range::non_negative,
            "first-order lag of the attitude phi; 0 answers at once"},
      self.attitude_time_constant);
    v(Field{"command_delay", "s", Range::non_negative,
            "from the control instant to the vehicle's answer; a multiple of the step"},
      self.command_delay);
  }
};

/// Thrust f, N, and attitude phi from the vertical towards +y, rad, of both vehicles.
template <Real R>
struct ThrustAttitude {
  std::array<R, 2> thrust{R(0.0), R(0.0)};
  std::array<R, 2> attitude{R(0.0), R(0.0)};

  template <class F>
  void visit_scalars(const ThrustAttitude& other, F&& f) {
    for (std::size_t i = 0; i < 2; ++i) {
      f(thrust[i], other.thrust[i]);
      f(attitude[i], other.attitude[i]);
    }
  }
};

/// The force that the command u asks of each vehicle's rotors, world y-z, N (paper, below (6)).
template <Real R>
std::array<Vec2<R>, 2> rotor_force(const Plant<R>& p, const Command<R>& u) {
  return {Vec2<R>{u[0].y, u[0].z + p.gravity_share(0)},
          Vec2<R>{u[1].y, u[1].z + p.gravity_share(1)}};
}

/// The same as thrust and attitude.
template <Real R>
ThrustAttitude<R> thrust_attitude(const std::array<Vec2<R>, 2>& force) {
  ThrustAttitude<R> result;
  for (std::size_t i = 0; i < 2; ++i) {
    result.thrust[i] = sqrt(dot(force[i], force[i]));
    result.attitude[i] = atan2(force[i].y, force[i].z);
  }
  return result;
}

/// The command u that a thrust and an attitude amount to.
template <Real R>
Command<R> command_of(const Plant<R>& p, const ThrustAttitude<R>& t) {
  Command<R> u;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [s, c] = sincos(t.attitude[i]);
    u[i] = {t.thrust[i] * s, t.thrust[i] * c - p.gravity_share(i)};
  }
  return u;
}

/// u acts as commanded, held until the next control instant.
template <Real R>
class IdealActuators {
 public:
  static constexpr bool ideal = true;

  IdealActuators(const Plant<R>& assumed, const Plant<R>& actual)
      : surplus_{assumed.gravity_share(0) - actual.gravity_share(0),
                 assumed.gravity_share(1) - actual.gravity_share(1)} {}

  void command(long, const Command<R>& u) {
    for (std::size_t i = 0; i < 2; ++i) u_[i] = {u[i].y, u[i].z + surplus_[i]};
  }
  void begin_step(long) {}
  void keep(const IdealActuators&, const mask_t<R>&, long) {}
  const Command<R>& at_start() const { return u_; }
  const Command<R>& at_middle() const { return u_; }
  const Command<R>& at_end() const { return u_; }
  std::array<mask_t<R>, 2> saturated() const { return {}; }

 private:
  std::array<R, 2> surplus_;  // of the gravity share that the law reckons with, N
  Command<R> u_;
};

template <Real R>
class TestbedActuators {
 public:
  static constexpr bool ideal = false;

  /// At the start the vehicles hover under the gravity share that the law reckons with.
  TestbedActuators(const ActuatorParameters<R>& limits, const Plant<R>& assumed,
                   const Plant<R>& actual, double step)
      : limits_(limits),
        assumed_(assumed),
        plant_(actual),
        line_(steps_of(limits.command_delay, step), hover(assumed)),
        target_(hover(assumed)),
        actual_(hover(assumed)),
        slope_max_(tangent(limits.tilt_max)),
        over_step_(decay(step)),
        over_half_step_(decay(0.5 * step)),
        start_(command_of(actual, actual_)),
        middle_(start_),
        end_(start_) {}

  /// Rotors do not pull down, and where the tilt is at its limit the vertical part of the force is
  /// kept and the sideways part cut, as autopilots do; then the thrust is cut to its limits.
  void command(long step, const Command<R>& u) {
    std::array<Vec2<R>, 2> force = rotor_force(assumed_, u);
    for (std::size_t i = 0; i < 2; ++i) {
      auto& [side, up] = force[i];
      const R bound = slope_max_ * max(up, R(0.0));
      saturated_[i] = (up < R(0.0)) | (bound < abs(side));
      up = max(up, R(0.0));
      side = clamp(side, -bound, bound);
    }
    ThrustAttitude<R> wanted = thrust_attitude(force);
    for (std::size_t i = 0; i < 2; ++i) {
      R& f = wanted.thrust[i];
      saturated_[i] = saturated_[i] | (f < limits_.thrust_min) | (limits_.thrust_max < f);
      f = clamp(f, limits_.thrust_min, limits_.thrust_max);
    }
    line_.send(step, wanted);
  }

  void begin_step(long step) {
    if (step > 0) actual_ = approach(over_step_);
    target_ = line_.receive(step);
    // Without lag the answer is there at once.
    const R zero(0.0);
    for (std::size_t i = 0; i < 2; ++i) {
      actual_.thrust[i] = select(over_step_.thrust <= zero, target_.thrust[i], actual_.thrust[i]);
      actual_.attitude[i] =
          select(over_step_.attitude <= zero, target_.attitude[i], actual_.attitude[i]);
    }
    start_ = command_of(plant_, actual_);
    middle_ = command_of(plant_, approach(over_half_step_));
    end_ = command_of(plant_, approach(over_step_));
  }

  /// Takes over at `step` the worlds of `mask` as they are in other actuators of equal parameters
  /// there. The other worlds hover.
  void keep(const TestbedActuators& other, const mask_t<R>& mask, long step) {
    const auto take = [&](R& mine, const R& its) { mine = select(mask, its, mine); };
    line_.keep(other.line_, mask, step);
    target_.visit_scalars(other.target_, take);
    actual_.visit_scalars(other.actual_, take);
    for (std::size_t i = 0; i < 2; ++i) saturated_[i] = mask & other.saturated_[i];
  }

  const Command<R>& at_start() const { return start_; }
  const Command<R>& at_middle() const { return middle_; }
  const Command<R>& at_end() const { return end_; }
  const std::array<mask_t<R>, 2>& saturated() const { return saturated_; }

 private:
  /// What a lag leaves of a difference after some time.
  struct Decay {
    R thrust, attitude;
  };

  static ThrustAttitude<R> hover(const Plant<R>& p) {
    return thrust_attitude(rotor_force(p, Command<R>{}));
  }

  static R tangent(const R& angle) {
    const auto [s, c] = sincos(angle);
    return s / c;
  }

  Decay decay(double time) const {
    const auto left = [time](const R& time_constant) {
      const R zero(0.0);
      return select(zero < time_constant, exp(R(-time) / time_constant), zero);
    };
    return {left(limits_.thrust_time_constant), left(limits_.attitude_time_constant)};
  }

  ThrustAttitude<R> approach(const Decay& left) const {
    ThrustAttitude<R> next;
    for (std::size_t i = 0; i < 2; ++i) {
      next.thrust[i] = target_.thrust[i] + left.thrust * (actual_.thrust[i] - target_.thrust[i]);
      next.attitude[i] =
          target_.attitude[i] + left.attitude * (actual_.attitude[i] - target_.attitude[i]);
    }
    return next;
  }

  ActuatorParameters<R> limits_;
  Plant<R> assumed_;
  Plant<R> plant_;
  DelayLine<R, ThrustAttitude<R>> line_;
  ThrustAttitude<R> target_;
  ThrustAttitude<R> actual_;
  R slope_max_;
  Decay over_step_, over_half_step_;
  Command<R> start_, middle_, end_;
  std::array<mask_t<R>, 2> saturated_{};
};

}  // namespace multilift::planar
