// From the state to what the control law is told.
//
// `IdealSensors` tell the truth at the control instant. `TestbedSensors` are a motion capture
// system: samples at their own rate, white Gaussian noise on each value, a delay.
#pragma once

#include <cmath>
#include <cstdint>

#include "multilift/control/planar/measurement.hpp"
#include "multilift/math/philox.hpp"
#include "multilift/sim/delay_line.hpp"

namespace multilift::planar {

struct SensorParameters {
  double period{0.0};
  double delay{0.0};
  double position_noise{0.0};
  double velocity_noise{0.0};
  double angle_noise{0.0};
  double angle_rate_noise{0.0};

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
Measurement<R> truth(const State<R>& state, const Pose<R>& pose) {
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
  Measurement<R> read(long, const State<R>& state, const Pose<R>& pose) {
    return truth(state, pose);
  }
};

class TestbedSensors {
 public:
  TestbedSensors(const SensorParameters& parameters, long control_steps, double step,
                 std::uint64_t seed, const State<double>& state, const Pose<double>& pose)
      : parameters_(parameters),
        every_(parameters.period > 0.0 ? std::lround(parameters.period / step) : control_steps),
        seed_(seed),
        line_(std::lround(parameters.delay / step), truth(state, pose)) {}

  void observe(long step, const State<double>& state, const Pose<double>& pose) {
    if (step % every_ != 0) return;
    Measurement<double> measured = truth(state, pose);
    const auto draw = static_cast<std::uint64_t>(step / every_);
    std::uint64_t stream = 0;
    const auto blur = [&](double& a, double& b, double deviation) {
      if (deviation > 0.0) {
        const auto [na, nb] = normal_pair(seed_, stream, draw);
        a += deviation * na;
        b += deviation * nb;
      }
      ++stream;  // each pair of values keeps its own stream, whichever noises are on
    };
    double unused = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      blur(measured.vehicle[i].y, measured.vehicle[i].z, parameters_.position_noise);
      blur(measured.vehicle_velocity[i].y, measured.vehicle_velocity[i].z,
           parameters_.velocity_noise);
    }
    blur(measured.theta[0], measured.theta[1], parameters_.angle_noise);
    blur(measured.theta[2], unused, parameters_.angle_noise);
    blur(measured.theta_dot[0], measured.theta_dot[1], parameters_.angle_rate_noise);
    blur(measured.theta_dot[2], unused, parameters_.angle_rate_noise);
    measured.angle = sincos_each(measured.theta);
    line_.send(step, measured);
  }

  Measurement<double> read(long step, const State<double>&, const Pose<double>&) {
    return line_.receive(step);
  }

 private:
  SensorParameters parameters_;
  long every_;
  std::uint64_t seed_;
  DelayLine<Measurement<double>> line_;
};

}  // namespace multilift::planar
