// Whole spatial runs: their energy audit closes.
#include "check.hpp"
#include "random_outings.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

/// What remains of the audit goes with the fourth power of the step while no cable changes,
/// whatever else happens: unequal masses, wind and gusts, pushes on all bodies, sampled commands
/// and estimates, noise, loss, and a reference that moves and turns.
template <class Cables>
void the_audit_closes_with_the_step(Random& random, const Extras& extras) {
  double coarse = 0.0, fine = 0.0;
  for (std::size_t k = 0; k < 12; ++k) {
    Outing w = random_outing(random, 1 + k % 5);
    w.wind.gust_speed = 0.0;  // gusts are held over a step, so that another step is another gust
    w.push *= 0.2;
    // All taut: elastic cables are stretched to where they hang, which rigid ones ignore.
    for (std::size_t i = 0; i < w.p.size(); ++i)
      w.start.vehicle[i].position = w.start.payload.position + w.formation.offset[i];
    if (!Cables::rigid)
      for (std::size_t i = 0; i < w.p.size(); ++i)
        w.p.cable_length[i] -= norm(w.formation.cable_force[i]) / w.p.cable_stiffness[i];
    const auto error = [&](long division) {
      const double step = 0.004 / static_cast<double>(division);
      const auto end = run_outings<double, Cables>(
          {w}, extras, {step, 250 * division, 5 * division, 1000000})[0];
      CHECK(end.status == Status::finished);
      CHECK(end.audit.at("impact") == 0.0);
      return std::fabs(end.audit.at("largest_integration_error"));
    };
    coarse += error(1), fine += error(2);
  }
  CHECK(coarse < 1e-2);
  CHECK_CLOSE(std::log2(coarse / fine), 4.0, 0.5);
}

/// Through slack phases, impacts and gusts what remains is small beside what went on.
void the_audit_closes_through_impacts(Random& random) {
  double impacts = 0.0;
  for (std::size_t k = 0; k < 20; ++k) {
    const Outing w = random_outing(random, 1 + k % 6);
    const auto end = run_outings<double, RigidCables<double>>({w}, {true, true, false},
                                                              {5e-4, 4000, 20, 1000000})[0];
    CHECK(end.status == Status::finished);
    impacts += end.audit.at("impact") != 0.0 ? 1.0 : 0.0;
    // 1e-7 m of lateness at some 100 N, a few dozen times, weighed by 1 + c of up to 30.
    CHECK_CLOSE(end.audit.at("largest_integration_error"), 0.0, 1e-3);
  }
  CHECK(impacts >= 5.0);
}

/// On the floor, whose springs have kinks at touch-down that cost the steps their order.
void the_audit_closes_on_the_floor(Random& random) {
  for (std::size_t k = 0; k < 5; ++k) {
    Outing w = random_outing(random, 3);
    w.start.payload.position.z += 0.1;
    for (auto& v : w.start.vehicle) v.position.z += 0.1;
    const auto end = run_outings<double, RigidCables<double>>({w}, {false, false, true},
                                                              {1e-4, 10000, 100, 1000000})[0];
    CHECK(end.status == Status::finished);
    CHECK_CLOSE(end.audit.at("largest_integration_error"), 0.0, 5e-2);
  }
}

}  // namespace

int main() {
  Random random(47);
  the_audit_closes_with_the_step<RigidCables<double>>(random, {});
  the_audit_closes_with_the_step<RigidCables<double>>(random, {true, true, false});
  the_audit_closes_with_the_step<ElasticCables<double>>(random, {false, true, false});
  the_audit_closes_through_impacts(random);
  the_audit_closes_on_the_floor(random);
  return verdict();
}
