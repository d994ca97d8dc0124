// From the forces that a law commands to what drives the vehicles.
//
// Commands travel over a link with delay, jitter and loss. An ideal vehicle then exerts the force
// within its limits; a quadrotor's autopilot turns it into an attitude and a thrust, and these into
// rotor speeds.
#pragma once

#include <cstdint>

#include "multilift/control/spatial/autopilot.hpp"
#include "multilift/control/spatial/force_limits.hpp"
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
                             control_steps)) {}

  /// Cuts `command` to the limits and sends it.
  void send(long step, ForceCommand<R>& command, Masks<R>& saturated) {
    limits_.cut(command.force, saturated);
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
  ForceLimits<R> limits_;
  words_t<R> seeds_;
  StepsOf<R> jitter_;
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
      : autopilot_(p, craft, step * static_cast<double>(steps)),
        scale_(thrust_scale(p, craft, std::move(hover_force))),
        steps_(steps) {}

  void drive(long step, const std::vector<Craft<R>>& craft, const ForceCommand<R>& command,
             std::vector<std::array<R, rotors>>& input) {
    if (step % steps_ != 0) return;
    const SinCos<R> half_yaw = sincos(R(0.5) * command.yaw);
    for (std::size_t i = 0; i < craft.size(); ++i)
      input[i] = autopilot_.step(i, craft[i], set_point(scale_, i, command.force[i], half_yaw));
  }
  /// The same from what the autopilots are sent.
  void follow(long step, const std::vector<Craft<R>>& craft,
              const std::vector<AttitudeThrust<R>>& wanted,
              std::vector<std::array<R, rotors>>& input) {
    if (step % steps_ != 0) return;
    for (std::size_t i = 0; i < craft.size(); ++i)
      input[i] = autopilot_.step(i, craft[i], wanted[i]);
  }
  const mask_t<R>& saturated(std::size_t i) const { return autopilot_.saturated(i); }

 private:
  Autopilot<R> autopilot_;
  ThrustScale<R> scale_;
  long steps_;
};

}  // namespace multilift::spatial
