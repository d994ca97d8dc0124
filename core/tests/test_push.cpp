// Profiles of pushes as the stages of integration steps see them, and their sum on the bodies.
#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;
using planar::Random;

namespace {

constexpr double pi = std::numbers::pi;

/// Steps of length 1/rate, and a profile with both edges on their grid, each rounded by itself.
struct Case {
  double rate;  // Hz
  long first, width;
  PushProfile<double> profile;

  explicit Case(Random& random)
      : rate(std::round(random(50.0, 2000.0))),
        first(static_cast<long>(random(0.0, 200.0))),
        width(static_cast<long>(random(1.0, 190.0))) {
    profile.start = at(first);
    profile.duration = at(width);
  }
  double at(long step) const { return static_cast<double>(step) / rate; }

  /// Integral by the weights that Runge-Kutta steps give their stages: Simpson's rule.
  double impulse() const {
    const double h = 1.0 / rate;
    double sum = 0.0;
    for (long k = 0; k < first + width + 10; ++k) {
      const double t = h * static_cast<double>(k);
      sum += profile.at(t, Stage::start) + 4.0 * profile.at(t + 0.5 * h, Stage::middle) +
             profile.at(t + h, Stage::end);
    }
    return h / 6.0 * sum;
  }
  /// Some hundred roundings of terms of size 1/rate.
  double rounding() const { return 1e-13 * profile.duration; }
  /// Error bound of Simpson's rule for a sine of the given angular frequency.
  double truncation(double omega) const {
    const double half_step = 0.5 / rate;
    return profile.duration / 180.0 * std::pow(omega * half_step, 4);
  }
};

void pulse_gives_exactly_its_duration(Random& random) {
  const Case c(random);
  CHECK_CLOSE(c.impulse(), c.profile.duration, c.rounding());
}

void sines_cost_no_order_of_the_integrator(Random& random) {
  Case c(random);
  const double duration = c.profile.duration;
  c.profile.shape = PushShape::half_sine;
  const double tolerance = c.truncation(pi / duration) + c.rounding();
  CHECK_CLOSE(c.impulse(), 2.0 / pi * duration, tolerance);

  c.profile.shape = PushShape::sine;
  c.profile.frequency = random(0.1, 0.1 * c.rate);
  const double omega = 2.0 * pi * c.profile.frequency;
  // The angle at the end, and with it the sine, is rounded in proportion to its size.
  const double angle = omega * duration;
  CHECK_CLOSE(c.impulse(), (1.0 - std::cos(angle)) / omega,
              c.truncation(omega) + (1.0 + angle) * c.rounding());
}

void samples_are_joined_by_lines_and_zero_beyond(Random& random) {
  Case c(random);
  c.profile.shape = PushShape::samples;
  // They may begin after the start, and end before the duration does.
  const auto late = static_cast<long>(random(0.0, 10.0));
  double expected = 0.0;
  for (long k = 0; k <= c.width; ++k) {
    c.profile.sample_times.push_back(c.at(late + k));
    c.profile.sample_values.push_back(random(-1.0, 1.0));
  }
  c.profile.duration = c.at(late + c.width + static_cast<long>(random(0.0, 10.0)));
  c.first += late;
  for (std::size_t k = 1; k < c.profile.sample_values.size(); ++k)
    expected += 0.5 / c.rate * (c.profile.sample_values[k - 1] + c.profile.sample_values[k]);
  CHECK_CLOSE(c.impulse(), expected, c.rounding());
}

void pushes_add_up_on_what_they_act_on(Random& random) {
  using namespace planar;
  const Vec2<double> f{random(-1.0, 1.0), random(-1.0, 1.0)};
  const PushProfile<double> profile{PushShape::pulse, 0.0, 1.0, 0.0, {}, {}};
  const std::vector<Push<double>> pushes{{Body::vehicle_1, f, 0.0, profile},
                                         {Body::vehicle_2, 2.0 * f, 0.0, profile},
                                         {Body::vehicle_2, 2.0 * f, 0.0, profile},
                                         {Body::bar, 8.0 * f, 3.0, profile},
                                         {Body::bar, 8.0 * f, 4.0, profile}};
  const std::array<Vec2<double>, 2> applied{Vec2<double>{1.0, 2.0}, Vec2<double>{3.0, 4.0}};
  const auto during = loads_at(0.5, Stage::start, applied, pushes);
  CHECK(during.u[0].y == 1.0 && during.u[0].z == 2.0 && during.u[1].y == 3.0);
  CHECK(during.vehicle_push[0].y == f.y && during.vehicle_push[0].z == f.z);
  CHECK(during.vehicle_push[1].y == 4.0 * f.y && during.vehicle_push[1].z == 4.0 * f.z);
  CHECK(during.bar_push.y == 16.0 * f.y && during.bar_push.z == 16.0 * f.z);
  CHECK(during.bar_torque == 7.0);
  const auto after = loads_at(1.0, Stage::start, applied, pushes);
  CHECK(after.vehicle_push[1].y == 0.0 && after.bar_push.z == 0.0 && after.bar_torque == 0.0);
}

}  // namespace

int main() {
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    pulse_gives_exactly_its_duration(random);
    sines_cost_no_order_of_the_integrator(random);
    samples_are_joined_by_lines_and_zero_beyond(random);
  }
  pushes_add_up_on_what_they_act_on(random);
  return verdict();
}
