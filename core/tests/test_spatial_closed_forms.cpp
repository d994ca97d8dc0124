// Motions of the spatial plant that have closed forms, or limits that are another model's.
#include "check.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Vector = Vec3<double>;
using Point = State<double, PointMass<double>>;

Parameters<double> two_bodies(Random& random) {
  Parameters<double> p = random_parameters(random, 1);
  p.attachment[0] = {};
  return p;
}

double reduced_mass(const Parameters<double>& p) {
  return p.vehicle_mass[0] * p.payload_mass / (p.vehicle_mass[0] + p.payload_mass);
}

/// A load that circles below a vehicle thrust up by F: seen from the vehicle, F per mass is
/// gravity. At an angle a from upright it goes round at w^2 = g / (l cos a), the cable pulling m g
/// / cos a.
void a_conical_pendulum_goes_round_evenly(Random& random) {
  const Parameters<double> p = two_bodies(random);
  const double g = random(2.0, 20.0), a = random(0.1, 1.2), length = p.cable_length[0];
  const double omega = std::sqrt(g / (length * std::cos(a)));
  const double radius = length * std::sin(a), depth = length * std::cos(a);
  Point x(1);
  x.payload.position = {radius, 0.0, -depth};
  x.payload.velocity = {0.0, radius * omega, 0.0};
  Flight<double> flight(p, x, {{0.0, 0.0, g * p.vehicle_mass[0]}});
  const double h = 1e-3, tension = reduced_mass(p) * g / std::cos(a);
  for (long k = 1; k <= 3000; ++k) {
    flight.advance(h);
    const double angle = omega * h * static_cast<double>(k);
    const Vector below = flight.x.payload.position - flight.x.vehicle[0].position;
    const Vector expected{radius * std::cos(angle), radius * std::sin(angle), -depth};
    // (w h)^5 / 120 a step with w up to 10/s and 3000 steps leave 1e-9; ten times that where the
    // circle is all but level.
    CHECK_CLOSE(norm(below - expected), 0.0, 1e-7);
    CHECK_CLOSE(flight.observe().motion.tension[0], tension, 1e-6 * tension);
  }
}

/// Two bodies on a stretched Kelvin-Voigt cable, along its axis: a damped oscillator of the reduced
/// mass until spring and damper together would push.
void a_stretched_cable_is_a_damped_oscillator(Random& random) {
  Parameters<double> p = two_bodies(random);
  p.gravity = 0.0;
  p.cable_stiffness[0] = random(500.0, 5000.0);
  p.cable_damping[0] = random(0.0, 20.0);
  const double mass = reduced_mass(p), c = 0.5 * p.cable_damping[0] / mass;
  const double omega = std::sqrt(p.cable_stiffness[0] / mass - square(c)), stretch = 0.02;
  Vector d = random_vector(random, 1.0);
  d = (1.0 / norm(d)) * d;
  Point x(1);
  x.vehicle[0].position = (p.cable_length[0] + stretch) * d;
  Flight<double, ElasticCables<double>> flight(p, x, {Vector{}});
  const double h = 1e-4;
  long compared = 0;
  for (long k = 1;; ++k) {
    flight.advance(h);
    if (flight.observe().motion.tension[0] <= 0.0) break;
    ++compared;
    const double t = h * static_cast<double>(k);
    const double expected =
        stretch * std::exp(-c * t) * (std::cos(omega * t) + c / omega * std::sin(omega * t));
    const double length = norm(flight.x.vehicle[0].position - flight.x.payload.position);
    // (w h)^4 / 120 of it, w up to 150/s.
    CHECK_CLOSE(length - p.cable_length[0], expected, 1e-9);
  }
  CHECK(compared > 50);
}

/// Stiff cables approach taut ones in proportion to their compliance. They start unstretched, and
/// damping settles what that sets ringing.
void stiff_cables_approach_rigid_ones(Random& random, std::array<double, 2>& apart) {
  const std::size_t n = 3;
  Parameters<double> p = random_parameters(random, n);
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / 3.0;
    p.attachment[i] = {0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.1};
  }
  Point x(n);
  for (std::size_t i = 0; i < n; ++i)
    x.vehicle[i].position = p.attachment[i] + Vector{0.0, 0.0, p.cable_length[i]};
  std::vector<Vector> force(n);
  for (std::size_t i = 0; i < n; ++i)
    force[i] = {random(-1.0, 1.0), random(-1.0, 1.0),
                9.8 * (p.vehicle_mass[i] + p.payload_mass / 3.0)};
  Flight<double> rigid(p, x, force);
  rigid.advance(5e-5, 10000);
  CHECK(rigid.stepper.events().impacts == 0.0);
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      p.cable_stiffness[i] = k == 0 ? 2e4 : 2e5;
      p.cable_damping[i] = std::sqrt(p.cable_stiffness[i]);
    }
    Flight<double, ElasticCables<double>> elastic(p, x, force);
    elastic.advance(5e-5, 10000);
    apart[k] += norm(elastic.x.payload.position - rigid.x.payload.position);
  }
}

/// A payload whose cables are slack falls and turns on its own.
void a_payload_without_cables_falls(Random& random) {
  const Parameters<double> p = random_parameters(random, 2);
  Point x = random_state(random, p, 1.0, 0.5);
  // Free fall of all: what is slack and stays near stays slack.
  x.payload.rate = {0.0, 0.0, random(-1.0, 1.0)};
  for (auto& v : x.vehicle) v.velocity = x.payload.velocity;
  Flight<double> flight(p, x, std::vector<Vector>(2));
  flight.advance(1e-3, 200);
  const double t = 0.2;
  const Vector expected =
      x.payload.position + t * x.payload.velocity - Vector{0.0, 0.0, 0.5 * 9.8 * t * t};
  CHECK(flight.stepper.events().impacts == 0.0);
  CHECK_CLOSE(norm(flight.x.payload.position - expected), 0.0, 1e-12);
  // About a principal axis it turns evenly.
  const double half = 0.5 * t * x.payload.rate.z;
  const auto turned =
      x.payload.attitude * Quaternion<double>{std::cos(half), 0.0, 0.0, std::sin(half)};
  const auto off = conjugate(turned) * flight.x.payload.attitude;
  CHECK_CLOSE(std::fabs(off.w), 1.0, 1e-12);
}

}  // namespace

int main() {
  Random random(61);
  std::array<double, 2> apart{};
  for (int k = 0; k < 10; ++k) {
    a_conical_pendulum_goes_round_evenly(random);
    a_stretched_cable_is_a_damped_oscillator(random);
    stiff_cables_approach_rigid_ones(random, apart);
    a_payload_without_cables_falls(random);
  }
  CHECK_CLOSE(apart[0] / apart[1], 10.0, 1.0);
  return verdict();
}
