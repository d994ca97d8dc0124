// How rollouts of the planar plant run, converge and end.
#include <functional>
#include <string_view>

#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;
using namespace multilift::planar;

namespace {

/// A law that commands whatever a function of time says.
struct Scripted {
  std::function<Command<double>(double time)> u_at;

  Command<double> step(const Measurement<double>& measured) { return u_at(measured.time); }
  StorageGains<double> storage_gains() const { return {}; }
  std::array<Vec2<double>, 2> d_hat() const { return {}; }
};

Command<double> hold(double) { return {}; }

using Record = std::function<void(const Sample<double>&, bool)>;

/// A run with ideal actuators and sensors from near hover.
template <class Law>
Outcome<double> run(
    const Plant<double>& p, const State<double>& start, Law law,
    const std::vector<Push<double>>& pushes, const Timing& timing,
    const Record& record = [](const Sample<double>&, bool) {}) {
  IdealActuators<double> actuators(p, p);
  IdealSensors<double> sensors;
  return rollout<true>(p, start, hover(p), law, actuators, sensors, pushes, timing, record)[0];
}

void hover_lasts(Random& random) {
  const auto p = plant_of(random_world(random).plant);
  const Timing timing{0.01, 100, 1, 7};
  long records = 0;
  const auto outcome = run(p, State<double>{}, Scripted{hold}, {}, timing,
                           [&](const Sample<double>&, bool) { ++records; });
  CHECK(outcome.status == Status::finished && outcome.culprit == -1);
  CHECK(outcome.end_time == 1.0);
  CHECK(records == 100 / 7 + 2);  // the first, every seventh and the last
  // Roundings of accelerations up to 20 m/s^2, times a condition number below 150, over 1 s.
  for (const double x : flat(outcome.state)) CHECK_CLOSE(x, 0.0, 1e-12);
}

double distance(const State<double>& a, const State<double>& b) {
  const auto x = flat(a), y = flat(b);
  double sum = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) sum += square(x[k] - y[k]);
  return std::sqrt(sum);
}

template <class Reporter>
double entry(const Reporter& reporter, std::string_view name) {
  double found = required;
  reporter.report([&](const Field& field, double x) {
    if (name == field.name) found = x;
  });
  return found;
}

/// Of the end and of the energy audit, summed over worlds under a sampled law and a push with its
/// edges on the grid.
void halving_the_step_divides_errors_by_sixteen(Random& random) {
  std::array<double, 2> state_error{}, audit_error{};  // before and after halving
  for (int n = 0; n < 50; ++n) {
    const World world = gentle_world(random);
    const auto p = plant_of(world.plant);
    const auto gains = random.several<25>(0.2, 1.0);
    const double force = 0.1 * p.bar_mass * p.gravity;
    const std::vector<Push<double>> pushes{{Body::bar,
                                            {force, force},
                                            0.1 * force * p.bar_length,
                                            {PushShape::pulse, 0.08, 0.16, 0.0, {}, {}}}};
    const auto after = [&](long division) {
      const Timing timing{0.04 / static_cast<double>(division), 8 * division, 2 * division, 1000};
      return run(p, state_of(world.state), law_of(gains, p, timing.control_period()), pushes,
                 timing);
    };
    const std::array<Outcome<double>, 3> outcome{after(4), after(8), after(16)};
    CHECK(outcome[2].status == Status::finished);
    for (std::size_t k = 0; k < 2; ++k) {
      state_error[k] += distance(outcome[k].state, outcome[k + 1].state);
      audit_error[k] += entry(outcome[k].audit, "largest_integration_error");
    }
  }
  // The order of convergence, to a quarter: the next one shows a little, in the audit most.
  CHECK_CLOSE(std::log2(state_error[0] / state_error[1]), 4.0, 0.25);
  CHECK_CLOSE(std::log2(audit_error[0] / audit_error[1]), 4.0, 0.25);
}

void a_force_beyond_all_bounds_ends_the_run_as_diverged(Random& random, double force) {
  const auto p = plant_of(random_world(random).plant);
  const auto lift = [&](double time) {
    const Vec2<double> u{0.0, time < 0.0295 ? 0.0 : force};
    return Command<double>{u, u};
  };
  const auto outcome = run(p, State<double>{}, Scripted{lift}, {}, {0.01, 100, 1, 1});
  CHECK(outcome.status == Status::diverged && outcome.culprit == -1);
  CHECK(outcome.end_time == 0.03);
  // Metrics tell of the run before.
  CHECK(std::isfinite(entry(outcome.metrics, "peak_thrust")));
  CHECK(std::isfinite(entry(outcome.metrics, "min_tension")));
}

/// One vehicle is thrust down while the bar, too hard to turn for its far end to rise, hangs on.
void a_cable_that_would_have_to_push_ends_the_run_as_slack(Random& random, int cable) {
  Parameters<double> parameters = plant_of(gentle_world(random).plant);
  parameters.bar_inertia = 0.5 * parameters.bar_mass * square(parameters.bar_length);
  const Plant<double> p(parameters);
  const auto i = static_cast<std::size_t>(cable);
  const Push<double> push{cable == 0 ? Body::vehicle_1 : Body::vehicle_2,
                          {0.0, -2.0 * p.gravity_share(i)},
                          0.0,
                          {PushShape::half_sine, 0.1, 0.2, 0.0, {}, {}}};
  std::vector<double> tensions;
  const auto outcome = run(p, State<double>{}, Scripted{hold}, {push}, {0.001, 2000, 1, 1},
                           [&](const Sample<double>& sample, bool) {
                             tensions.push_back(sample.now.motion.tension[i]);
                           });
  CHECK(outcome.status == Status::slack && outcome.culprit == cable);
  CHECK(0.1 < outcome.end_time && outcome.end_time < 0.2);
  CHECK(tensions.back() < 0.0);
  tensions.pop_back();
  for (const double tension : tensions) CHECK(tension >= 0.0);
}

/// Without gravity, a bar on parallel cables turns about equal vehicles at a constant rate, as two
/// masses on a string do: theta1 = -theta2 = rate * time until either reaches a right angle.
void a_right_angle_ends_the_run_at_its_time(Random& random) {
  Parameters<double> p;
  p.vehicle_mass.fill(random(0.5, 5.0));
  p.cable_length.fill(random(0.5, 3.0));
  p.bar_mass = random(0.2, 5.0);
  p.bar_length = random(0.5, 3.0);
  p.bar_half_thickness = 0.0;
  p.bar_inertia = 0.1;
  p.gravity = 0.0;
  const double rate = random(1.0, 3.0), step = 0.001;
  State<double> start;
  start.theta_dot = {rate, -rate, 0.0};
  const auto outcome = run(Plant<double>(p), start, Scripted{hold}, {}, {step, 5000, 1, 1});
  CHECK(outcome.status == Status::swing_limit);
  CHECK(outcome.culprit == 0 || outcome.culprit == 1);
  const double steps = std::ceil(std::numbers::pi / 2.0 / (rate * step));
  CHECK_CLOSE(outcome.end_time, step * steps, 0.5 * step);
  // Fourth order at a thousandth of a turn leaves nothing but roundings.
  CHECK_CLOSE(outcome.state.theta[0], rate * outcome.end_time, 1e-11);
  CHECK_CLOSE(outcome.state.theta[1], -rate * outcome.end_time, 1e-11);
}

}  // namespace

int main() {
  Random random(5);
  for (int n = 0; n < 20; ++n) {
    hover_lasts(random);
    a_cable_that_would_have_to_push_ends_the_run_as_slack(random, n % 2);
    a_right_angle_ends_the_run_at_its_time(random);
  }
  halving_the_step_divides_errors_by_sixteen(random);
  for (const double force : {required, unlimited, 1e9})
    a_force_beyond_all_bounds_ends_the_run_as_diverged(random, force);
  return verdict();
}
