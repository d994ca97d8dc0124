// A dual number has the value that a double has, to the last bit, and as derivatives what finite
// differences approach.
#include "check.hpp"
#include "random_planar.hpp"

using namespace multilift;
using namespace multilift::planar;

namespace {

/// Compares f of a state over dual numbers with f over doubles. f takes and returns arrays.
template <class F>
void check_derivatives(const Numbers<10>& state, const F& f) {
  using Ten = Dual<10>;
  auto x = over<Ten>(state);
  for (int k = 0; k < 10; ++k) {
    const auto index = static_cast<std::size_t>(k);
    x[index] = Ten::variable(state[index], k);
  }
  const auto found = f(x);
  const auto values = f(state);
  const auto size = values.size();
  for (std::size_t i = 0; i < size; ++i) CHECK(same_bits(found[i].x, values[i]));

  for (std::size_t k = 0; k < 10; ++k) {
    const auto slope = [&](double h) {
      auto ahead = state, behind = state;
      ahead[k] += h, behind[k] -= h;
      auto difference = f(ahead);
      const auto back = f(behind);
      for (std::size_t i = 0; i < size; ++i)
        difference[i] = (difference[i] - back[i]) / (ahead[k] - behind[k]);
      return difference;
    };
    // Two central differences, extrapolated: rounding, amplified by a condition number below 150,
    // outweighs truncation at this step.
    const double h = 2e-4;
    const double tolerance = 150.0 * std::numeric_limits<double>::epsilon() / h;
    const auto coarse = slope(h), fine = slope(0.5 * h);
    double scale = 1.0;
    for (std::size_t i = 0; i < size; ++i)
      scale = std::fmax(scale, std::fmax(std::fabs(values[i]), std::fabs(fine[i])));
    for (std::size_t i = 0; i < size; ++i)
      CHECK_CLOSE(found[i].d[k], (4.0 * fine[i] - coarse[i]) / 3.0, tolerance * scale);
  }
}

/// What motion() finds, as it depends on the state.
void motion_has_exact_derivatives(Random& random) {
  const World world = random_world(random);
  check_derivatives(world.state, [&]<Real R>(const std::array<R, 10>& x) {
    return flat(motion_of(over<R>(world.plant), x, over<R>(world.loads)));
  });
}

/// The functions that equations and actuators call, off their kinks.
void functions_have_exact_derivatives(Random& random) {
  check_derivatives(random.several<10>(0.5, 2.0), []<Real R>(const std::array<R, 10>& x) {
    return std::array<R, 5>{multilift::exp(x[0] - x[1]), multilift::log(x[2]),
                            multilift::atan(x[3] - x[4]),
                            multilift::atan2(x[5] - R(3.0), x[6] - x[7]), multilift::sqrt(x[8])};
  });
}

/// Where a run under a law ends, as it depends on its start.
void runs_have_exact_derivatives(Random& random) {
  const World world = gentle_world(random);
  const auto gains = random.several<25>(0.2, 1.0);
  const Timing timing{0.02, 20, 2, 1000};
  check_derivatives(world.state, [&]<Real R>(const std::array<R, 10>& x) {
    const auto p = plant_of(over<R>(world.plant));
    auto law = law_of(gains, p, timing.control_period());
    IdealActuators<R> actuators(p, p);
    IdealSensors<R> sensors;
    const auto outcome = rollout<false>(p, state_of(x), hover(p), law, actuators, sensors, {},
                                        timing, [](const Sample<R>&, bool) {})[0];
    CHECK(outcome.status == Status::finished);
    return flat(outcome.state);
  });
}

}  // namespace

int main() {
  Random random(2);
  for (int n = 0; n < 100; ++n) motion_has_exact_derivatives(random);
  for (int n = 0; n < 100; ++n) functions_have_exact_derivatives(random);
  for (int n = 0; n < 20; ++n) runs_have_exact_derivatives(random);
  return verdict();
}
