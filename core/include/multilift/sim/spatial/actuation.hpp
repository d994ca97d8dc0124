// From the forces that a law commands to what drives the vehicles.
//
// Commands travel over a link with delay, jitter and loss. An ideal vehicle then exerts the force
// within its limits; a quadrotor's autopilot turns it into an attitude and a thrust, and these into
// rotor speeds.
#pragma once

#include <cstdint>

#include "multilift/control/spatial/autopilot.hpp"
#include "multilift/math/normal.hpp"
#include "multilift/sim/lossy_line.hpp"
#include "multilift/sim/steps.hpp"

namespace multilift::spatial {

template <Real R>
struct LinkParameters {
  R delay{0.0};
  R jitter{0.0};
  R loss{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"delay", "s", Range::non_negative,
            "from the control instant to the vehicles; a multiple of the step"},
      self.delay);
    v(Field{"jitter", "s", Range::non_negative,
            "a command is late by up to this more, uniformly, in whole steps"},
      self.jitter);
    v(Field{"loss", "", Range::non_negative, "part of the commands that is lost, below 1"},
      self.loss);
  }
};

template <Real R>
struct LimitParameters {
  explicit LimitParameters(std::size_t n)
      : thrust_min(n, R(0.0)), thrust_max(n, R(unlimited)), tilt_max(n, R(std::numbers::pi / 2)) {}

  std::vector<R> thrust_min, thrust_max, tilt_max;

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"thrust_min", "N", Range::non_negative, "least force commanded of a vehicle"},
      self.thrust_min);
    v(Field{"thrust_max", "N", Range::positive, "greatest force commanded of a vehicle"},
      self.thrust_max);
    v(Field{"tilt_max", "rad", Range::positive,
            "greatest angle of the commanded force from the vertical, at most pi/2"},
      self.tilt_max);
  }
};

/// The force each vehicle is told to exert, W, N, and its heading, rad.
template <Real R>
struct ForceCommand {
  std::vector<Vec3<R>> force;
  R yaw{0.0};

  ForceCommand() = default;
  explicit ForceCommand(std::size_t n) : force(n) {}

  template <class F>
  void visit_scalars(const ForceCommand& other, F&& f) {
    for (std::size_t i = 0; i < force.size(); ++i) zip(f, force[i], other.force[i]);
    f(yaw, other.yaw);
  }
};

/// Limits and link.
template <Real R>
class Transmission {
 public:
  using Seeds = std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)>;

  Transmission(const LinkParameters<R>& link, const LimitParameters<R>& limits, double step,
               long control_steps, const Seeds& seeds, const ForceCommand<R>& start)
      : link_(link),
        limits_(limits),
        seeds_(seed_words<R>(seeds)),
        jitter_(steps_of(link.jitter, step)),
        line_(steps_of(link.delay, step), start,
              room_under_way(longest_of(steps_of(link.delay, step)) + longest_of(jitter_),
                             control_steps)) {
    for (const R& tilt : limits.tilt_max) {
      const auto [s, c] = sincos(tilt);
      slope_max_.push_back(s / max(c, R(1e-12)));
    }
  }

  /// Cuts `command` to the limits and sends it. Rotors do not pull down, and where the tilt is at
  /// its limit the upright part of a force is kept and the sideways part cut, as autopilots do.
  void send(long step, ForceCommand<R>& command, Masks<R>& saturated) {
    const R zero(0.0), one(1.0);
    for (std::size_t i = 0; i < command.force.size(); ++i) {
      Vec3<R>& f = command.force[i];
      const R up = max(f.z, zero);
      const R side = sqrt(f.x * f.x + f.y * f.y);
      const R bound = slope_max_[i] * up;
      const R cut = select(bound < side, bound / max(side, R(1e-12)), one);
      saturated[i].is = (f.z < zero) | (bound < side);
      f = {cut * f.x, cut * f.y, up};
      const R size = norm(f);
      saturated[i].is =
          saturated[i].is | (size < limits_.thrust_min[i]) | (limits_.thrust_max[i] < size);
      const R wanted = clamp(size, limits_.thrust_min[i], limits_.thrust_max[i]);
      const R stretch = wanted / max(size, R(1e-12));
      // A force of no size has no direction: it becomes upright.
      f = select<R>(R(1e-9) < size, stretch * f, {zero, zero, wanted});
    }
    line_.send(step, command, fate(static_cast<std::uint64_t>(step)));
  }

  const ForceCommand<R>& receive(long step) { return line_.receive(step); }

 private:
  static constexpr std::uint64_t stream = (std::uint64_t{1} << 32) + 1;

  StepsOf<R> fate(std::uint64_t draw) const {
    StepsOf<R> late{};
    if (longest_of(jitter_) == 0 && !any(R(0.0) < link_.loss)) return late;
    const auto [u, v] = uniform_pair<R>(seeds_, stream, words_t<R>{} + draw);
    for (int k = 0; k < lanes_of<R>; ++k) {
      const auto i = static_cast<std::size_t>(k);
      late[i] = value(lane(u, k)) < value(lane(link_.loss, k))
                    ? LossyLine<R, ForceCommand<R>>::lost
                    : static_cast<long>(value(lane(v, k)) * static_cast<double>(jitter_[i] + 1));
    }
    return late;
  }

  LinkParameters<R> link_;
  LimitParameters<R> limits_;
  words_t<R> seeds_;
  StepsOf<R> jitter_;
  std::vector<R> slope_max_;
  LossyLine<R, ForceCommand<R>> line_;
};

/// What drives ideal vehicles: the force itself.
template <Real R>
class DirectForce {
 public:
  using Parameters = typename IdealVehicles<R>::Parameters;

  void drive(long, const std::vector<PointMass<R>>&, const ForceCommand<R>& command,
             std::vector<Vec3<R>>& input) {
    input = command.force;
  }
  mask_t<R> saturated(std::size_t) const { return R(0.0) < R(0.0); }
};

/// What drives quadrotors: their autopilots, at periods of their own.
template <Real R>
class Autopilots {
 public:
  /// `hover_force` is each vehicle's and its share of the load's weight, N.
  Autopilots(const AutopilotParameters<R>& p, const typename Quadrotors<R>::Parameters& craft,
             std::vector<R> hover_force, long steps, double step)
      : p_(p),
        autopilot_(p, craft, step * static_cast<double>(steps)),
        hover_force_(std::move(hover_force)),
        steps_(steps) {
    for (std::size_t i = 0; i < craft.size(); ++i)
      greatest_.push_back(R(static_cast<double>(rotors)) * craft.thrust_coefficient[i] *
                          square(craft.rotor_speed_max[i]));
  }

  void drive(long step, const std::vector<Craft<R>>& craft, const ForceCommand<R>& command,
             std::vector<std::array<R, rotors>>& input) {
    if (step % steps_ != 0) return;
    const SinCos<R> half_yaw = sincos(R(0.5) * command.yaw);
    for (std::size_t i = 0; i < craft.size(); ++i) {
      const Vec3<R>& force = command.force[i];
      const R size = max(norm(force), R(1e-9));
      const AttitudeThrust<R> wanted{attitude_along(force, size, half_yaw),
                                     normalised_thrust(size, hover_force_[i], p_.hover_thrust[i],
                                                       greatest_[i], p_.thrust_curve[i])};
      input[i] = autopilot_.step(i, craft[i], wanted);
    }
  }
  const mask_t<R>& saturated(std::size_t i) const { return autopilot_.saturated(i); }

 private:
  AutopilotParameters<R> p_;
  Autopilot<R> autopilot_;
  std::vector<R> hover_force_, greatest_;
  long steps_;
};

}  // namespace multilift::spatial
