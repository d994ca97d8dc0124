// What rigid cables do on the way: they go slack, are pulled taut, and leave alone what they must.
#include "multilift/model/spatial/energy.hpp"

#include "check.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Vector = Vec3<double>;
using Point = State<double, PointMass<double>>;

std::vector<Vector> idle(std::size_t n) { return std::vector<Vector>(n); }

/// Bodies without outside forces, tumbling through slack and taut phases. Restitution 1, 0.5, 0.
void momentum_and_energy_are_kept_through_impacts(Random& random, std::size_t n,
                                                  double restitution) {
  Parameters<double> p = random_parameters(random, n);
  p.gravity = 0.0;
  p.cable_restitution = restitution;
  const Point start = random_state(random, p, 1.5, random(0.3, 0.95));
  Flight<double> flight(p, start, idle(n));
  const Plant<double> plant(p);
  const double energy = mechanical_energy(plant, start);
  const Vector linear = momentum(p, start), angular = angular_momentum(p, start);
  double tension = 0.0;
  const double h = 5e-4;
  for (int k = 0; k < 6000; ++k) {
    for (const double t : flight.observe().motion.tension) tension = std::fmax(tension, t);
    flight.advance(h);
  }
  const auto& events = flight.stepper.events();
  CHECK(n > 1 || events.impacts > 0.0);
  // Linear momentum is a sum that Runge-Kutta steps and impulses leave but for roundings, 1e-16 of
  // some tens of kg m/s 6000 times.
  CHECK_CLOSE(norm(momentum(p, flight.x) - linear), 0.0, 1e-11);
  // Angular momentum is quadratic in the state, so that it feels the fourth-order error: rates of
  // some 10/s turned by h each, to the fifth, 6000 times, leave 1e-8 of some 10.
  CHECK_CLOSE(norm(angular_momentum(p, flight.x) - angular), 0.0, 1e-6);
  // A cable counts as taut up to 1e-7 m late, and the way back costs that much tension.
  const double late = 2.0 * contact_tolerance * tension * (1.0 + events.impacts);
  CHECK_CLOSE(mechanical_energy(plant, flight.x) + events.energy_lost, energy, 1e-6 + late);
  CHECK(events.energy_lost >= 0.0);
  if (restitution == 1.0) {
    // Nothing is lost but in rebounds that are too slow to be any.
    CHECK(events.energy_lost <= 5.0 * events.impacts * square(least_rebound));
  }
}

/// Payload and vehicle fly apart until the cable between them is taut: time, velocities and loss.
void two_bodies_jerk_as_in_closed_form(Random& random) {
  Parameters<double> p = random_parameters(random, 1);
  p.gravity = 0.0;
  p.attachment[0] = {};
  p.cable_restitution = random(0.0, 1.0);
  Vector d = random_vector(random, 1.0);
  d = (1.0 / norm(d)) * d;
  const double speed = random(0.5, 5.0), part = random(0.5, 0.99);
  Point x(1);
  x.vehicle[0].position = (part * p.cable_length[0]) * d;
  x.vehicle[0].velocity = speed * d;
  Flight<double> flight(p, x, idle(1));
  const double contact = (1.0 - part) * p.cable_length[0] / speed;
  const double h = 1e-3;
  const long steps = std::lround(contact / h) + 20;
  flight.advance(h, steps);
  const double mass = p.vehicle_mass[0] * p.payload_mass / (p.vehicle_mass[0] + p.payload_mass);
  const double e = p.cable_restitution * speed > least_rebound ? p.cable_restitution : 0.0;
  const double impulse = mass * (1.0 + e) * speed;
  const auto& events = flight.stepper.events();
  CHECK(events.impacts == 1.0);
  // Taut is found 1e-7 m late and to 2^-20 of a step.
  const double late = contact_tolerance / speed + h * 0x1p-20;
  const double since = h * static_cast<double>(steps) - contact;
  CHECK_CLOSE(events.hardest_impulse, impulse, 1e-12 * impulse);
  CHECK_CLOSE(events.energy_lost, 0.5 * mass * (1.0 - e * e) * square(speed), 1e-11);
  const double after = impulse / p.payload_mass;
  CHECK_CLOSE(dot(d, flight.x.payload.position), after * since, 1.01 * late * after + 1e-12);
  CHECK_CLOSE(dot(d, flight.x.payload.velocity), after, 1e-6 * after + 1e-12);
}

/// A bob is swung over the top of a vehicle that is thrust up: seen from the vehicle, thrust per
/// mass is its gravity and the reduced mass its mass. It leaves the circle, flies a parabola, and
/// is jerked where parabola and circle meet again.
void a_bob_over_the_top_flies_a_parabola(Random& random) {
  Parameters<double> p = random_parameters(random, 1);
  p.attachment[0] = {};
  const double length = p.cable_length[0], g = random(2.0, 20.0);
  const double cosine = random(0.3, 0.8), sine = std::sqrt(1.0 - square(cosine));
  // The circle is left where v^2 = g l cos, at that angle before the top.
  const double leaving = std::sqrt(g * length * cosine);
  const double bottom = std::sqrt(square(leaving) + 2.0 * g * length * (1.0 + cosine));
  Point x(1);
  x.vehicle[0].position = {0.0, 0.0, length};
  x.payload.velocity = {bottom, 0.0, 0.0};
  Flight<double> flight(p, x, {{0.0, 0.0, p.vehicle_mass[0] * g}});
  const double h = 2e-4;
  Vector where{};
  for (int k = 0; k < 20000 && flight.stepper.events().impacts == 0.0; ++k) {
    if (flight.stepper.taut()[0].is)
      where = flight.x.payload.position - flight.x.vehicle[0].position;
    flight.advance(h);
  }
  // The last step that began on the circle began at most a step before it was left.
  CHECK_CLOSE(where.z, length * cosine, leaving * h);
  CHECK_CLOSE(where.x, length * sine, leaving * h);
  // From l (sin, cos) at v (-cos, sin), |p + v t - g t^2/2| = l again at t = 4 v sin / g, since
  // v^2 = g l cos takes the square terms away.
  const double t = 4.0 * leaving * sine / g;
  const Vector at{length * sine - leaving * cosine * t, 0.0,
                  length * cosine + leaving * sine * t - 0.5 * g * t * t};
  const Vector v{-leaving * cosine, 0.0, leaving * sine - g * t};
  const double jerk = dot(at, v) / length;
  const double mass = p.vehicle_mass[0] * p.payload_mass / (p.vehicle_mass[0] + p.payload_mass);
  const auto& events = flight.stepper.events();
  CHECK(events.impacts == 1.0);
  // 1e-7 m of lateness in a field of 20 m/s^2, and as much again from leaving when the tension of a
  // step's last stage, rather than of its end, is 0.
  CHECK_CLOSE(events.energy_lost, 0.5 * mass * square(jerk), 4e-6 * mass);
  CHECK_CLOSE(events.hardest_impulse, mass * jerk, 4e-6 * mass);
}

/// A slack cable that is caught within the tolerance about its full length at a step's edge is no
/// taut one yet: it still has to be jerked.
void no_impact_slips_through_the_tolerance(Random& random) {
  for (const double off : {-9e-8, -1e-8, 0.0, 1e-8, 9e-8}) {
    for (const bool from_start : {false, true}) {
      Parameters<double> p = random_parameters(random, 1);
      p.gravity = 0.0;
      p.attachment[0] = {};
      const double speed = 2.0, h = 1e-3, length = p.cable_length[0] + off;
      Point x(1);
      x.vehicle[0].velocity = {0.0, 0.0, speed};
      x.vehicle[0].position = {0.0, 0.0, length - (from_start ? 0.0 : speed * h)};
      Flight<double> flight(p, x, idle(1));
      flight.advance(h, 3);
      CHECK(flight.stepper.events().impacts == 1.0);
      const double common = speed * p.vehicle_mass[0] / (p.vehicle_mass[0] + p.payload_mass);
      // What is left of closing in: length_correction times the tolerance, 4e-6 m/s.
      CHECK_CLOSE(flight.x.vehicle[0].velocity.z, common, 1e-5);
    }
  }
}

/// After an impact no cable stretches, none that is let go is stretched, and every impulse pulls.
void chains_of_taut_and_slack_cables_share_a_jerk(Random& random, std::size_t n) {
  Parameters<double> p = random_parameters(random, n);
  p.cable_restitution = random(0.0, 1.0) < 0.5 ? 0.0 : random(0.2, 1.0);
  Point x = random_state(random, p, 1.0);
  // Half of the cables are at full length and stretch, all at once; the others are taut.
  std::vector<bool> jerked(n);
  Instant<double> now(n);
  const Plant<double> plant(p);
  const Dynamics<double, IdealVehicles<double>, RigidCables<double>> dynamics(
      plant, IdealVehicles<double>(IdealVehicles<double>::Parameters(n)), {});
  dynamics.lay_cables(x, now);
  for (std::size_t i = 0; i < n; ++i) {
    jerked[i] = i == 0 || random(0.0, 1.0) < 0.5;
    if (!jerked[i]) continue;
    const Vector d = now.cable[i].direction;
    const double rate = random(0.1, 3.0);
    // Where it was a tenth of a millisecond ago, slack.
    x.vehicle[i].velocity += rate * d;
    x.vehicle[i].position -= (1e-4 * rate) * d;
  }
  Flight<double> flight(p, x, idle(n));
  const Vector before = momentum(p, x);
  const double energy = mechanical_energy(plant, x);
  const double h = 2e-4;
  // One jerk may set off another, more of them than one step takes up.
  const long steps = 5;
  flight.advance(h, steps);
  const auto& events = flight.stepper.events();
  CHECK(events.impacts >= 1.0);
  dynamics.lay_cables(flight.x, now);
  for (std::size_t i = 0; i < n; ++i) {
    // Whoever is at full length has been jerked, or is about to be. What gravity and centripetal
    // terms, some 100 m/s^2, may add until the step ends.
    const double over = now.cable[i].length - p.cable_length[i];
    CHECK(now.cable[i].stretch_rate < 100.0 * h || over <= contact_tolerance);
    // A cable that waits for the next step meanwhile stretches a little.
    CHECK(over < 1e-5);
    if (p.cable_restitution == 0.0 && jerked[i] && flight.stepper.taut()[i].is)
      CHECK_CLOSE(now.cable[i].stretch_rate, 0.0, 1e-5);
  }
  double mass = p.payload_mass;
  for (const double m : p.vehicle_mass) mass += m;
  const Vector expected =
      before - Vector{0.0, 0.0, mass * p.gravity * h * static_cast<double>(steps)};
  CHECK_CLOSE(norm(momentum(p, flight.x) - expected), 0.0, 1e-11);
  // Impulses of some 10 N s at 1e-7 m; the steps are so small that they add nothing.
  CHECK_CLOSE(mechanical_energy(plant, flight.x) + events.energy_lost, energy, 1e-4);
}

/// Where nothing happens a step is one Runge-Kutta step.
void quiet_steps_are_tried_once(Random& random) {
  Parameters<double> p = random_parameters(random, 1);
  p.attachment[0] = {};
  Flight<double> flight(p, random_state(random, p, 0.0), {{0.0, 0.0, 1e3}});
  flight.advance(1e-3, 10);
  CHECK(flight.tries.count == 10);
}

/// Cables about zero tension neither crawl nor blow up.
void idling_cables_cost_little(Random& random, std::size_t n, double restitution, double excess) {
  Parameters<double> p = random_parameters(random, n);
  p.cable_restitution = restitution;
  const Point start = random_state(random, p, 0.0);
  // Everything falls freely; `excess` is what the vehicles' thrust adds, N, up or down.
  std::vector<Vector> force(n);
  for (Vector& f : force) f.z = random(-excess, excess);
  Flight<double> flight(p, start, force);
  const long steps = 2000;
  flight.advance(1e-3, steps);
  // One try a step, 22 an event: one every eleventh step is no crawling.
  CHECK(flight.tries.count < 3 * steps);
  Instant<double> now(n);
  flight.stepper.dynamics().lay_cables(flight.x, now);
  for (std::size_t i = 0; i < n; ++i) CHECK(now.cable[i].length < p.cable_length[i] + 1e-6);
}

/// Of worlds whose cables stay taut, under constant forces.
void halving_the_step_divides_errors_by_sixteen(Random& random) {
  double coarse = 0.0, fine = 0.0;
  int kept = 0;
  for (int world = 0; world < 60; ++world) {
    const std::size_t n = 1 + static_cast<std::size_t>(world % 6);
    Parameters<double> p = random_parameters(random, n);
    add_drag(random, p);
    const Point start = random_state(random, p, 0.5);
    std::vector<Vector> force(n);
    for (std::size_t i = 0; i < n; ++i)
      force[i] = {random(-1.0, 1.0), random(-1.0, 1.0), 9.8 * p.vehicle_mass[i] + 20.0};
    bool taut = true;
    const auto after = [&](long division) {
      Flight<double> flight(p, start, force);
      for (long k = 0; k < 20 * division; ++k) {
        flight.advance(0.01 / static_cast<double>(division));
        for (const auto& cable : flight.stepper.taut()) taut = taut && cable.is;
      }
      return numbers_of(flight.x);
    };
    const auto a = after(1), b = after(2), c = after(4);
    if (!taut) continue;
    ++kept;
    for (std::size_t k = 0; k < a.size(); ++k) {
      coarse += std::fabs(a[k] - b[k]);
      fine += std::fabs(b[k] - c[k]);
    }
  }
  CHECK(kept >= 20);
  // The order, to a quarter: the next one shows a little.
  CHECK_CLOSE(std::log2(coarse / fine), 4.0, 0.25);
}

}  // namespace

int main() {
  Random random(11);
  for (std::size_t k = 0; k < 24; ++k)
    momentum_and_energy_are_kept_through_impacts(random, 1 + k % 6,
                                                 0.5 * static_cast<double>(k % 3));
  for (int k = 0; k < 100; ++k) two_bodies_jerk_as_in_closed_form(random);
  for (int k = 0; k < 10; ++k) a_bob_over_the_top_flies_a_parabola(random);
  no_impact_slips_through_the_tolerance(random);
  for (std::size_t k = 0; k < 1000; ++k)
    chains_of_taut_and_slack_cables_share_a_jerk(random, 1 + k % 8);
  quiet_steps_are_tried_once(random);
  for (std::size_t n = 1; n <= 6; ++n)
    for (const double e : {0.0, 0.5, 1.0})
      for (const double excess : {0.0, 1e-9, 1e-3, 1.0})
        idling_cables_cost_little(random, n, e, excess);
  halving_the_step_divides_errors_by_sixteen(random);
  return verdict();
}
