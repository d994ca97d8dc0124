// Floor and wind.
#include "check.hpp"
#include "multilift/model/spatial/energy.hpp"
#include "multilift/sim/spatial/weather.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Vector = Vec3<double>;
using Point = State<double, PointMass<double>>;

/// A platform standing upright, its vehicles beside it, all on the floor, cables slack.
struct Standing {
  Parameters<double> p;
  Ground<double> ground;
  Point x;

  Standing(Random& random, std::size_t n) : p(random_parameters(random, n)), x(n) {
    ground.height = random(-1.0, 1.0);
    ground.sink = random(0.0005, 0.01);
    ground.friction = random(0.2, 1.0);
    x.payload.position = {0.0, 0.0, ground.height + ground.payload_clearance - ground.sink};
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      const Vector out{std::cos(angle), std::sin(angle), 0.0};
      p.attachment[i] = 0.5 * out;
      p.cable_length[i] = 1.0;
      x.vehicle[i].position = {out.x, out.y,
                               ground.height + ground.vehicle_clearance - ground.sink};
    }
  }
};

/// As deep as said, and without creeping, for 5 s.
void what_stands_stands_still(Random& random, std::size_t n) {
  const Standing s(random, n);
  Flight<double> flight(s.p, s.x, std::vector<Vector>(n), s.ground);
  flight.advance(1e-3, 5000);
  const auto before = numbers_of(s.x), after = numbers_of(flight.x);
  // Roundings of weights of some 50 N in springs of some 1e4 N/m.
  for (std::size_t k = 0; k < before.size(); ++k) CHECK_CLOSE(after[k], before[k], 1e-12);
}

/// Released above its place a body settles at the said depth, critically damped: it does not rise
/// again.
void what_is_put_down_sinks_as_said(Random& random) {
  const Standing s(random, 3);
  Flight<double> flight(s.p, s.x, std::vector<Vector>(3), s.ground);
  for (auto& v : flight.x.vehicle) v.position.z += 0.5 * s.ground.sink;
  flight.x.payload.position.z += 0.5 * s.ground.sink;
  double lowest = 1e9;
  for (int k = 0; k < 1500; ++k) {
    flight.advance(1e-3);
    const double z = flight.x.payload.position.z;
    CHECK(z <= lowest + 1e-12);
    lowest = z;
  }
  const double depth = s.ground.height + s.ground.payload_clearance - flight.x.payload.position.z;
  CHECK_CLOSE(depth, s.ground.sink, 1e-6 * s.ground.sink);
}

/// Friction opposes the slip inside the cone, and a sliding body stops where v^2 = 2 mu g s says.
void friction_is_coulombs(Random& random) {
  Ground<double> ground;
  ground.friction = random(0.2, 1.0);
  const double weight = random(1.0, 50.0), g = 9.8;
  for (int k = 0; k < 100; ++k) {
    const Vector point{0.0, 0.0, random(-0.01, 0.01)}, v = random_vector(random, 2.0);
    const Vector f = contact_force(ground, weight, g, point, v);
    CHECK(f.z >= 0.0);
    CHECK(point.z < 0.0 || (f.x == 0.0 && f.y == 0.0 && f.z == 0.0));
    CHECK(std::hypot(f.x, f.y) <= ground.friction * f.z * (1.0 + 1e-15));
    CHECK(f.x * v.x + f.y * v.y <= 0.0);
    // Across the slip there is none.
    CHECK_CLOSE(f.x * v.y - f.y * v.x, 0.0, 1e-12 * (1.0 + f.z));
  }
  Standing s(random, 1);
  const double speed = random(0.5, 2.0);
  s.x.vehicle[0].velocity.y = speed;
  s.p.cable_length[0] = 100.0;
  Flight<double> flight(s.p, s.x, {Vector{}}, s.ground);
  flight.advance(1e-3, 3000 + std::lround(1000.0 * speed / (s.ground.friction * g)));
  const double deceleration = s.ground.friction * g;
  // Below friction_speed it glides on a little: sqrt(v^2 + v0^2) makes the way at most
  // v0 (v + v0) / (mu g) longer.
  const double way = 0.5 * square(speed) / deceleration;
  CHECK_CLOSE(flight.x.vehicle[0].position.y - s.x.vehicle[0].position.y, way,
              friction_speed * (speed + friction_speed) / deceleration);
}

/// Dropped and thrown bodies never end up with more energy than they had, whatever their slip.
void the_floor_creates_no_energy(Random& random, std::size_t n) {
  Standing s(random, n);
  s.ground.sink = 0.001;
  Flight<double> flight(s.p, s.x, std::vector<Vector>(n), s.ground);
  const double fall = random(0.0, 1.0);
  flight.x.payload.position.z += fall;
  flight.x.payload.velocity = random_vector(random, 0.5);
  flight.x.payload.rate = random_vector(random, 1.0);
  for (auto& v : flight.x.vehicle) {
    v.position.z += fall;
    v.velocity = random_vector(random, 0.5);
  }
  const Plant<double> plant(s.p);
  const auto sideways = [&] {
    double sum = 0.0;
    for (const auto& v : flight.x.vehicle)
      sum = std::fmax(sum, std::hypot(v.velocity.x, v.velocity.y));
    return sum;
  };
  const auto energy = [&] {
    double sum = mechanical_energy(plant, flight.x);
    const auto add_spring = [&](double weight, double foot) {
      sum += 0.5 * weight * square(std::fmax(0.0, s.ground.height - foot)) / s.ground.sink;
    };
    const Rotation<double> turn = rotation(flight.x.payload.attitude);
    for (std::size_t i = 0; i < n; ++i) {
      add_spring(s.p.vehicle_mass[i] * s.p.gravity,
                 flight.x.vehicle[i].position.z - s.ground.vehicle_clearance);
      const Vector foot = s.p.attachment[i] - Vector{0.0, 0.0, s.ground.payload_clearance};
      add_spring(s.p.payload_mass * s.p.gravity / static_cast<double>(n),
                 flight.x.payload.position.z + turn.to_world(foot).z);
    }
    return sum;
  };
  double least = energy(), most_sideways = sideways();
  for (int k = 0; k < 2000; ++k) {
    const double impacts = flight.stepper.events().impacts;
    flight.advance(1e-3);
    // The step in which a body touches down sees the floor from its next stage on: of its energy of
    // up to 50 J it makes an error of the damper's order, rate times step, 0.2, to the fourth.
    CHECK(energy() <= least + 0.1);
    least = std::fmin(least, energy());
    if (n > 1) continue;
    // A vehicle on a slack cable is slowed sideways, never pushed, nor turned round.
    if (!flight.stepper.taut()[0].is && flight.stepper.events().impacts == impacts)
      CHECK(sideways() <= most_sideways + 1e-12);
    most_sideways = sideways();
  }
}

struct Statistics {
  double variance{0.0}, lag{0.0};  // and the correlation a time apart
};

/// Gusts at two speeds of the mean wind: variances and correlation times as MIL-F-8785C has them
/// for low altitudes, found from many short runs at their start and end.
void gusts_are_drydens(double mean, double height) {
  WindParameters<double> p;
  p.mean = {0.0, mean, 0.0};  // the wind's own axes: along +y, across -x
  p.gust_speed = 10.0;
  p.altitude = height;
  const double feet = height / 0.3048, shape = 0.177 + 0.000823 * feet;
  const double up = 0.1 * p.gust_speed, side = up / std::pow(shape, 0.4);
  const double scale = 0.3048 * feet / std::pow(shape, 1.2);
  const std::array<double, 3> sigma{side, side, up}, length{scale, scale, height};
  constexpr int runs = 4000;
  constexpr long steps = 50;
  std::array<Statistics, 3> first{}, last{};
  const double step = length[2] / mean / 50.0;  // a run lasts for the shortest correlation time
  for (std::uint64_t run = 0; run < runs; ++run) {
    Wind<double> wind(p, step, {run});
    const Vector start = wind.at(0) - p.mean;
    Vector end = start;
    for (long k = 1; k <= steps; ++k) end = wind.at(k) - p.mean;
    const std::array<double, 3> a{start.y, start.x, start.z}, b{end.y, end.x, end.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis].variance += a[axis] * a[axis] / runs;
      last[axis].variance += b[axis] * b[axis] / runs;
      last[axis].lag += a[axis] * b[axis] / runs;
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double variance = square(sigma[axis]);
    // Estimates from 4000 runs have a standard deviation of sqrt(2/4000) = 2.2 %; four of them.
    CHECK_CLOSE(first[axis].variance / variance, 1.0, 0.09);
    CHECK_CLOSE(last[axis].variance / variance, 1.0, 0.09);
    // The spectra's inverse transforms: exp(-s) along, (1 - s/2) exp(-s) across and up, s = V t /
    // L.
    const double s = mean * step * steps / length[axis];
    const double correlation = axis == 0 ? std::exp(-s) : (1.0 - 0.5 * s) * std::exp(-s);
    CHECK_CLOSE(last[axis].lag / variance, correlation, 0.08);
  }
}

void calm_has_no_gusts_and_a_seed_says_all() {
  WindParameters<double> p;
  p.mean = {1.0, 2.0, 0.5};
  Wind<double> calm(p, 1e-3, {1});
  for (long k = 0; k < 10; ++k) CHECK(norm(calm.at(k) - p.mean) == 0.0);
  p.gust_speed = 5.0;
  Wind<double> a(p, 1e-3, {1}), b(p, 1e-3, {1}), c(p, 1e-3, {2});
  bool unlike = false;
  for (long k = 0; k < 10; ++k) {
    const Vector x = a.at(k);
    CHECK(norm(x - b.at(k)) == 0.0);
    unlike = unlike || norm(x - c.at(k)) > 0.0;
  }
  CHECK(unlike);
}

}  // namespace

int main() {
  Random random(41);
  for (std::size_t n = 3; n <= 6; ++n) what_stands_stands_still(random, n);
  for (int k = 0; k < 10; ++k) {
    what_is_put_down_sinks_as_said(random);
    friction_is_coulombs(random);
  }
  for (std::size_t k = 0; k < 100; ++k)
    the_floor_creates_no_energy(random, k % 2 == 0 ? 1 : 3 + k % 4);
  gusts_are_drydens(2.0, 6.0);
  gusts_are_drydens(8.0, 30.0);
  calm_has_no_gusts_and_a_seed_says_all();
  return verdict();
}
