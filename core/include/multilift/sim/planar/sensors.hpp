// From the state to what the control law is told.
//
// `IdealSensors` tell the truth at the control instant. `TestbedSensors` are a motion capture
// system: samples at their own rate, white Gaussian noise on each value, a delay.
#pragma once

#include <cstdint>
#include <numeric>
#include <type_traits>

#include "multilift/control/planar/measurement.hpp"
#include "multilift/math/normal.hpp"
#include "multilift/sim/delay_line.hpp"

namespace multilift::planar {

template <Real R>
struct SensorParameters {
  R period{0.0};
  R delay{0.0};
  R position_noise{0.0};
  R velocity_noise{0.0};
  R angle_noise{0.0};
  R angle_rate_noise{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"period", "s", Range::non_negative,
            "between two samples, a multiple of the step; 0 samples at every control instant"},
      self.period);
    v(Field{"delay", "s", Range::non_negative,
            "from capture to the control law; a multiple of the step"},
      self.delay);
    v(Field{"position_noise", "m", Range::non_negative,
            "standard deviation of each measured position"},
      self.position_noise);
    v(Field{"velocity_noise", "m/s", Range::non_negative,
            "standard deviation of each measured velocity"},
      self.velocity_noise);
    v(Field{"angle_noise", "rad", Range::non_negative, "standard deviation of each measured angle"},
      self.angle_noise);
    v(Field{"angle_rate_noise", "rad/s", Range::non_negative,
            "standard deviation of each measured angular rate"},
      self.angle_rate_noise);
  }
};

template <Real R>
MULTILIFT_INLINE Measurement<R> truth(const State<R>& state, const Pose<R>& pose) {
  Measurement<R> measured;
  measured.vehicle = pose.vehicle;
  measured.vehicle_velocity = pose.vehicle_velocity;
  measured.theta = state.theta;
  measured.angle = pose.angle;
  measured.theta_dot = state.theta_dot;
  return measured;
}

template <Real R>
class IdealSensors {
 public:
  void observe(long, const State<R>&, const Pose<R>&) {}
  void observe(long, const R&, const State<R>&, const Pose<R>&) {}
  void keep(const IdealSensors&, const mask_t<R>&, long) {}
  Measurement<R> read(long, const State<R>& state, const Pose<R>& pose) {
    return truth(state, pose);
  }
};

template <Real R>
class TestbedSensors {
 public:
  using Seeds = std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)>;

  /// All worlds sample at the first one's period; every other number is a world's own.
  TestbedSensors(const SensorParameters<R>& parameters, long control_steps, double step,
                 const Seeds& seeds, const State<R>& state, const Pose<R>& pose)
      : parameters_(parameters),
        every_(value(lane(parameters.period, 0)) > 0.0 ? steps_of(parameters.period, step)[0]
                                                       : control_steps),
        divisor_(std::gcd(every_, control_steps)),
        seeds_(seed_words<R>(seeds)),
        line_(steps_of(parameters.delay, step), truth(state, pose), divisor_, control_steps),
        latest_(truth(state, pose)) {}

  /// At every integration step, `step` since the start of all worlds.
  void observe(long step, const State<R>& state, const Pose<R>& pose) {
    if (step % every_ != 0) return;
    line_.send(step, sample(words_t<R>{} + static_cast<std::uint64_t>(step / every_), state, pose));
  }

  /// The same where each world began at a control instant of its own: `clock` counts for all of
  /// them, `steps` for each since its start.
  void observe(long clock, const R& steps, const State<R>& state, const Pose<R>& pose) {
    if (clock % divisor_ != 0) return;
    words_t<R> draws{};
    mask_t<R> due{};
    for (int k = 0; k < lanes_of<R>; ++k) {
      const auto own = static_cast<long>(value(lane(steps, k)));
      const auto draw = static_cast<std::uint64_t>(own / every_);
      if constexpr (lanes_of<R> == 1)
        draws = draw;
      else
        draws[k] = draw;
      set_lane(due, k, own % every_ == 0);
    }
    if (!any(due)) return;
    // To a world that takes no sample its last one goes once more, which changes nothing there.
    latest_.visit_scalars(sample(draws, state, pose),
                          [&](R& mine, const R& its) { mine = select(due, its, mine); });
    line_.send(clock, latest_);
  }

  /// Takes over at `clock` the worlds of `mask` as they are in other sensors of equal parameters
  /// there. The other worlds have measured nothing.
  void keep(const TestbedSensors& other, const mask_t<R>& mask, long clock) {
    line_.keep(other.line_, mask, clock);
    latest_.visit_scalars(other.latest_,
                          [&](R& mine, const R& its) { mine = select(mask, its, mine); });
  }

  Measurement<R> read(long step, const State<R>&, const Pose<R>&) { return line_.receive(step); }

 private:
  /// The truth under each world's noise of these draws.
  Measurement<R> sample(const words_t<R>& draw, const State<R>& state, const Pose<R>& pose) const {
    Measurement<R> measured = truth(state, pose);
    std::uint64_t stream = 0;
    R unused(0.0);
    // Each pair of values keeps its own stream, whichever noises are on.
    for (std::size_t i = 0; i < 2; ++i) {
      blur(measured.vehicle[i].y, measured.vehicle[i].z, parameters_.position_noise, stream++,
           draw);
      blur(measured.vehicle_velocity[i].y, measured.vehicle_velocity[i].z,
           parameters_.velocity_noise, stream++, draw);
    }
    blur(measured.theta[0], measured.theta[1], parameters_.angle_noise, stream++, draw);
    blur(measured.theta[2], unused, parameters_.angle_noise, stream++, draw);
    blur(measured.theta_dot[0], measured.theta_dot[1], parameters_.angle_rate_noise, stream++,
         draw);
    blur(measured.theta_dot[2], unused, parameters_.angle_rate_noise, stream++, draw);
    measured.angle = sincos_each(measured.theta);
    return measured;
  }

  void blur(R& a, R& b, const R& deviation, std::uint64_t stream, const words_t<R>& draw) const {
    if (!any(R(0.0) < deviation)) return;
    const auto [na, nb] = normal_pair<Drawn>(seeds_, stream, draw);
    a = a + deviation * R(na);
    b = b + deviation * R(nb);
  }

  /// Draws depend on no number of a scenario, and so have no derivatives.
  using Drawn = std::conditional_t<lanes_of<R> == 1, double, R>;

  SensorParameters<R> parameters_;
  long every_;    // steps between two samples of a world
  long divisor_;  // steps that those of worlds which began at different control instants are apart
  words_t<R> seeds_{};
  DelayLine<R, Measurement<R>> line_;
  Measurement<R> latest_;
};

}  // namespace multilift::planar
