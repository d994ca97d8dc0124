// From the command u to the force on each vehicle.
//
// The paper's outer loop: u_1 = f sin(phi), u_2 = f cos(phi) - (m + m3/2) g, so a command is a
// thrust f and an attitude phi. `IdealActuators` applies it at once. `TestbedActuators` adds what a
// real vehicle has: limits on thrust and tilt, a command delay, and first-order answers of thrust
// and attitude, solved exactly between instants since their command is held.
#pragma once

#include <cmath>
#include <numbers>

#include "multilift/control/planar/measurement.hpp"
#include "multilift/sim/delay_line.hpp"

namespace multilift::planar {

struct ActuatorParameters {
  double thrust_min{0.0};
  double thrust_max{unlimited};
  double tilt_max{std::numbers::pi / 2};
  double thrust_time_constant{0.0};
  double attitude_time_constant{0.0};
  double command_delay{0.0};

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
struct ThrustAttitude {
  std::array<double, 2> thrust{};
  std::array<double, 2> attitude{};
};

/// The thrust and attitude that the command u asks for (paper, below (6)).
inline ThrustAttitude thrust_attitude(const Plant<double>& p, const Command<double>& u) {
  ThrustAttitude result;
  for (std::size_t i = 0; i < 2; ++i) {
    const double fy = u[i].y, fz = u[i].z + p.gravity_share(i);
    result.thrust[i] = std::sqrt(fy * fy + fz * fz);
    result.attitude[i] = std::atan2(fy, fz);
  }
  return result;
}

/// The command u that a thrust and an attitude amount to.
inline Command<double> command_of(const Plant<double>& p, const ThrustAttitude& t) {
  Command<double> u;
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
  void command(long, const Command<R>& u) { u_ = u; }
  void begin_step(long) {}
  const Command<R>& at_start() const { return u_; }
  const Command<R>& at_middle() const { return u_; }
  const Command<R>& at_end() const { return u_; }
  std::array<mask_t<R>, 2> saturated() const { return {}; }

 private:
  Command<R> u_;
};

class TestbedActuators {
 public:
  /// At the start the vehicles hover under their gravity share.
  TestbedActuators(const ActuatorParameters& limits, const Plant<double>& p, double step)
      : limits_(limits),
        plant_(p),
        line_(std::lround(limits.command_delay / step), hover(p)),
        target_(hover(p)),
        actual_(hover(p)),
        thrust_decay_(decay(step, limits.thrust_time_constant)),
        thrust_decay_half_(decay(0.5 * step, limits.thrust_time_constant)),
        attitude_decay_(decay(step, limits.attitude_time_constant)),
        attitude_decay_half_(decay(0.5 * step, limits.attitude_time_constant)) {}

  void command(long step, const Command<double>& u) {
    ThrustAttitude wanted = thrust_attitude(plant_, u);
    for (std::size_t i = 0; i < 2; ++i) {
      const double f = wanted.thrust[i], phi = wanted.attitude[i];
      wanted.thrust[i] = clamp(f, limits_.thrust_min, limits_.thrust_max);
      wanted.attitude[i] = clamp(phi, -limits_.tilt_max, limits_.tilt_max);
      saturated_[i] = wanted.thrust[i] != f || wanted.attitude[i] != phi;
    }
    line_.send(step, wanted);
  }

  void begin_step(long step) {
    if (step > 0) actual_ = approach(thrust_decay_, attitude_decay_);
    target_ = line_.receive(step);
    // Without lag the answer is there at once.
    if (thrust_decay_ == 0.0) actual_.thrust = target_.thrust;
    if (attitude_decay_ == 0.0) actual_.attitude = target_.attitude;
    start_ = command_of(plant_, actual_);
    middle_ = command_of(plant_, approach(thrust_decay_half_, attitude_decay_half_));
    end_ = command_of(plant_, approach(thrust_decay_, attitude_decay_));
  }

  const Command<double>& at_start() const { return start_; }
  const Command<double>& at_middle() const { return middle_; }
  const Command<double>& at_end() const { return end_; }
  std::array<bool, 2> saturated() const { return saturated_; }

 private:
  static ThrustAttitude hover(const Plant<double>& p) {
    return thrust_attitude(p, Command<double>{});
  }
  static double decay(double time, double time_constant) {
    return time_constant > 0.0 ? std::exp(-time / time_constant) : 0.0;
  }
  ThrustAttitude approach(double thrust_decay, double attitude_decay) const {
    ThrustAttitude next;
    for (std::size_t i = 0; i < 2; ++i) {
      next.thrust[i] = target_.thrust[i] + thrust_decay * (actual_.thrust[i] - target_.thrust[i]);
      next.attitude[i] =
          target_.attitude[i] + attitude_decay * (actual_.attitude[i] - target_.attitude[i]);
    }
    return next;
  }

  ActuatorParameters limits_;
  Plant<double> plant_;
  DelayLine<ThrustAttitude> line_;
  ThrustAttitude target_;
  ThrustAttitude actual_;
  double thrust_decay_, thrust_decay_half_, attitude_decay_, attitude_decay_half_;
  Command<double> start_, middle_, end_;
  std::array<bool, 2> saturated_{};
};

}  // namespace multilift::planar
