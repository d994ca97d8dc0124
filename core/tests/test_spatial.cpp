// Laws of the spatial equations of motion: mechanics derived another way, symmetry, reduction.
#include <algorithm>

#include "check.hpp"
#include "multilift/model/spatial/energy.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Vector = Vec3<double>;
using Point = State<double, PointMass<double>>;
using Rigid = Dynamics<double, IdealVehicles<double>, RigidCables<double>>;

/// One instant of a plant whose cables are all taken for taut, whatever their tensions.
struct Snapshot {
  Parameters<double> p;
  Point x;
  std::vector<Vector> force;
  Surroundings<double> outside;
  Instant<double> now;
  Point rate;

  Snapshot(const Parameters<double>& parameters, const Point& state,
           const std::vector<Vector>& vehicle_force, const Surroundings<double>& around)
      : p(parameters),
        x(state),
        force(vehicle_force),
        outside(around),
        now(p.size()),
        rate(p.size()) {
    const Rigid dynamics(Plant<double>(p),
                         IdealVehicles<double>(IdealVehicles<double>::Parameters(p.size())), {});
    dynamics.evaluate(x, force, outside, Masks<double>(p.size(), {true}), now);
    dynamics.rate(x, force, now, rate);
  }
};

Surroundings<double> random_surroundings(Random& random, std::size_t n) {
  Surroundings<double> outside(n);
  for (Vector& push : outside.vehicle_push) push = random_vector(random, 10.0);
  outside.payload_push = random_vector(random, 10.0);
  outside.payload_push_torque = random_vector(random, 2.0);
  outside.wind = random_vector(random, 3.0);
  return outside;
}

std::vector<Vector> random_forces(Random& random, std::size_t n) {
  std::vector<Vector> force(n);
  for (Vector& f : force) f = random_vector(random, 20.0);
  return force;
}

Snapshot random_snapshot(Random& random, std::size_t n) {
  Parameters<double> p = random_parameters(random, n);
  add_drag(random, p);
  return {p, random_state(random, p, 2.0), random_forces(random, n),
          random_surroundings(random, n)};
}

/// Solves a x = b by elimination with pivots; a by rows.
std::vector<double> solve(std::vector<std::vector<double>> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i)
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double f = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= f * a[k][j];
      b[i] -= f * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

/// All bodies' accelerations, world frame, with the cables' lengths squared as constraints and
/// Lagrange's multipliers: 6 + 4 n equations solved at once.
void newton_euler_and_lagrange_agree(const Snapshot& s) {
  const std::size_t n = s.p.size(), size = 6 + 4 * n;
  std::vector<std::vector<double>> a(size, std::vector<double>(size));
  std::vector<double> b(size);
  const Rotation<double> turn = rotation(s.x.payload.attitude);
  const Vector omega = turn.to_world(s.x.payload.rate);
  const auto fill = [&](std::size_t row, const Vector& v) {
    b[row] += v.x, b[row + 1] += v.y, b[row + 2] += v.z;
  };
  // Translation and turning of the payload, in W.
  const Vector air = s.x.payload.velocity - s.outside.wind;
  for (std::size_t k = 0; k < 3; ++k) a[k][k] = s.p.payload_mass;
  fill(0, s.outside.payload_push - scale(s.p.payload_drag, air) -
              s.p.payload_drag_quadratic * norm(air) * air -
              Vector{0.0, 0.0, s.p.payload_mass * s.p.gravity});
  // J in W: the sum of its moments times the axes' outer products.
  const Vector axis[3] = {turn.x, turn.y, turn.z};
  const double moment[3] = {s.p.payload_inertia.x, s.p.payload_inertia.y, s.p.payload_inertia.z};
  Vector spin{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double e[3] = {axis[k].x, axis[k].y, axis[k].z};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) a[3 + i][3 + j] += moment[k] * e[i] * e[j];
    spin += (moment[k] * dot(axis[k], omega)) * axis[k];
  }
  fill(3, turn.to_world(s.outside.payload_push_torque -
                        scale(s.p.payload_spin_damping, s.x.payload.rate)) -
              cross(omega, spin));
  for (std::size_t i = 0; i < n; ++i) {
    const auto& v = s.x.vehicle[i];
    const std::size_t row = 6 + 3 * i, last = 6 + 3 * n + i;
    for (std::size_t k = 0; k < 3; ++k) a[row + k][row + k] = s.p.vehicle_mass[i];
    fill(row, s.force[i] + s.outside.vehicle_push[i] -
                  scale(s.p.vehicle_drag[i], v.velocity - s.outside.wind) -
                  Vector{0.0, 0.0, s.p.vehicle_mass[i] * s.p.gravity});
    // d^2/dt^2 of half the squared length e'e: e'(a_i - a - alpha x r) + |e_dot|^2 - e'(w x (w x
    // r)).
    const Vector r = turn.to_world(s.p.attachment[i]);
    const Vector e = v.position - s.x.payload.position - r;
    const Vector e_dot = v.velocity - s.x.payload.velocity - cross(omega, r);
    const Vector re = cross(r, e);
    const double row_of[9] = {-e.x, -e.y, -e.z, -re.x, -re.y, -re.z, e.x, e.y, e.z};
    for (std::size_t k = 0; k < 9; ++k) {
      const std::size_t column = k < 6 ? k : row + k - 6;
      a[last][column] = a[column][last] = row_of[k];
    }
    b[last] = dot(e, cross(omega, cross(omega, r))) - dot(e_dot, e_dot);
  }
  const auto z = solve(a, b);
  const auto same = [&](std::size_t k, const Vector& found, double tolerance) {
    CHECK_CLOSE(norm(found - Vector{z[k], z[k + 1], z[k + 2]}), 0.0, tolerance);
  };
  // Both solve systems of condition up to some 1e4, of numbers up to 1e3.
  const double tolerance = 1e-8;
  same(0, s.rate.payload.velocity, tolerance);
  same(3, turn.to_world(s.rate.payload.rate), tolerance);
  for (std::size_t i = 0; i < n; ++i) {
    same(6 + 3 * i, s.rate.vehicle[i].velocity, tolerance);
    // The multiplier is minus tension per length.
    CHECK_CLOSE(s.now.motion.tension[i], z[6 + 3 * n + i] * s.now.cable[i].length, tolerance);
  }
}

/// Sums over all bodies of m a and of moments about the origin are those of outside forces, and
/// kinetic energy changes by their power: cables and gyroscopic terms do no work.
void outside_forces_alone_change_momentum_and_energy(const Snapshot& s) {
  const Rotation<double> turn = rotation(s.x.payload.attitude);
  const Vector& omega = s.x.payload.rate;
  const Vector spin = scale(s.p.payload_inertia, omega);
  const Vector& x = s.x.payload.position;
  const Vector& loads = s.now.loads.payload;
  Vector force = loads - s.p.payload_mass * s.rate.payload.velocity;
  Vector moment = cross(x, force) + turn.to_world(s.now.loads.payload_torque - cross(omega, spin) -
                                                  scale(s.p.payload_inertia, s.rate.payload.rate));
  double power =
      dot(force, s.x.payload.velocity) +
      dot(omega, s.now.loads.payload_torque - scale(s.p.payload_inertia, s.rate.payload.rate));
  for (std::size_t i = 0; i < s.p.size(); ++i) {
    const Vector f = s.now.loads.vehicle[i] - s.p.vehicle_mass[i] * s.rate.vehicle[i].velocity;
    force += f;
    moment += cross(s.x.vehicle[i].position, f);
    power += dot(f, s.x.vehicle[i].velocity);
  }
  // Sums of up to 25 numbers of some hundred.
  CHECK_CLOSE(norm(force), 0.0, 1e-10);
  CHECK_CLOSE(norm(moment), 0.0, 1e-10);
  CHECK_CLOSE(power, 0.0, 1e-9);
  CHECK_CLOSE(dot(omega, gyroscopic_torque(s.p.payload_inertia, omega)), 0.0, 1e-13);
  // The quaternion stays of unit length.
  const auto& q = s.x.payload.attitude;
  const auto& r = s.rate.payload.attitude;
  CHECK_CLOSE(q.w * r.w + q.x * r.x + q.y * r.y + q.z * r.z, 0.0, 1e-14);
}

/// A map of space that keeps the upward direction, and what it makes of a world: `turn` of vectors,
/// `axial` of rates and torques, in W; payload coordinates are mapped alike.
struct Symmetry {
  double cosine, sine, mirror;

  Vector vector(const Vector& v) const {
    const double y = mirror * v.y;
    return {cosine * v.x - sine * y, sine * v.x + cosine * y, v.z};
  }
  Vector axial(const Vector& v) const { return mirror * vector(v); }
};

/// The world seen through a symmetry of W alone; a mirrored payload's own y is mirrored as well.
void symmetries_carry_motions_to_motions(Random& random, const Snapshot& s) {
  const double angle = random(-3.0, 3.0);
  const std::size_t n = s.p.size();
  for (const double mirror : {1.0, -1.0}) {
    const Symmetry map{std::cos(angle), std::sin(angle), mirror};
    const Symmetry body{1.0, 0.0, mirror};
    Parameters<double> p = s.p;
    Point x = s.x;
    auto force = s.force;
    Surroundings<double> outside = s.outside;
    // Drag along the world's axes looks the same from all sides only if it is.
    const auto level = [](Vector& d) { d.y = d.x; };
    Snapshot original = s;
    level(original.p.payload_drag);
    for (Vector& d : original.p.vehicle_drag) level(d);
    original = Snapshot(original.p, s.x, s.force, s.outside);
    p = original.p;
    for (Vector& r : p.attachment) r = body.vector(r);
    const auto& q = s.x.payload.attitude;
    const Quaternion<double> mirrored{q.w, mirror * q.x, q.y, mirror * q.z};
    x.payload.attitude =
        Quaternion<double>{std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle)} * mirrored;
    x.payload.position = map.vector(x.payload.position);
    x.payload.velocity = map.vector(x.payload.velocity);
    x.payload.rate = body.axial(x.payload.rate);
    for (std::size_t i = 0; i < n; ++i) {
      x.vehicle[i].position = map.vector(x.vehicle[i].position);
      x.vehicle[i].velocity = map.vector(x.vehicle[i].velocity);
      force[i] = map.vector(force[i]);
      outside.vehicle_push[i] = map.vector(outside.vehicle_push[i]);
    }
    outside.payload_push = map.vector(outside.payload_push);
    outside.payload_push_torque = body.axial(outside.payload_push_torque);
    outside.wind = map.vector(outside.wind);
    const Snapshot seen(p, x, force, outside);
    // Roundings of accelerations of some hundreds in a system of condition 1e4.
    const double tolerance = 1e-9;
    CHECK_CLOSE(norm(seen.rate.payload.velocity - map.vector(original.rate.payload.velocity)), 0.0,
                tolerance);
    CHECK_CLOSE(norm(seen.rate.payload.rate - body.axial(original.rate.payload.rate)), 0.0,
                tolerance);
    for (std::size_t i = 0; i < n; ++i) {
      CHECK_CLOSE(
          norm(seen.rate.vehicle[i].velocity - map.vector(original.rate.vehicle[i].velocity)), 0.0,
          tolerance);
      CHECK_CLOSE(seen.now.motion.tension[i], original.now.motion.tension[i], tolerance);
    }
  }
}

void relabelled_vehicles_move_alike(const Snapshot& s) {
  Snapshot other = s;
  const auto turn_round = [](auto& list) {
    std::rotate(list.begin(), list.begin() + 1, list.end());
  };
  turn_round(other.p.vehicle_mass), turn_round(other.p.vehicle_drag);
  turn_round(other.p.cable_length), turn_round(other.p.attachment);
  turn_round(other.x.vehicle), turn_round(other.force), turn_round(other.outside.vehicle_push);
  other = Snapshot(other.p, other.x, other.force, other.outside);
  const std::size_t n = s.p.size();
  CHECK_CLOSE(norm(other.rate.payload.velocity - s.rate.payload.velocity), 0.0, 1e-9);
  CHECK_CLOSE(norm(other.rate.payload.rate - s.rate.payload.rate), 0.0, 1e-9);
  for (std::size_t i = 0; i < n; ++i)
    CHECK_CLOSE(other.now.motion.tension[i], s.now.motion.tension[(i + 1) % n], 1e-9);
}

/// Without arms the payload's inertia is nobody's business; as arms shrink the motion of the point
/// is approached in proportion. All-zero inertia says that it is one.
void short_arms_approach_a_point(const Snapshot& s, std::array<double, 2>& apart) {
  const auto with_arms = [&](double part, bool point) {
    Parameters<double> p = s.p;
    Point x = s.x;
    const Rotation<double> turn = rotation(x.payload.attitude);
    if (point) p.payload_inertia = {};
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vector shift = (part - 1.0) * p.attachment[i];
      p.attachment[i] = part * p.attachment[i];
      x.vehicle[i].position += turn.to_world(shift);
      x.vehicle[i].velocity += turn.to_world(cross(x.payload.rate, shift));
    }
    return Snapshot(p, x, s.force, s.outside);
  };
  const Vector point = with_arms(0.0, true).rate.payload.velocity;
  CHECK_CLOSE(norm(with_arms(0.0, false).rate.payload.velocity - point), 0.0, 1e-10);
  CHECK_CLOSE(norm(with_arms(0.0, true).rate.payload.rate), 0.0, 0.0);
  apart[0] += norm(with_arms(1e-3, false).rate.payload.velocity - point);
  apart[1] += norm(with_arms(1e-4, false).rate.payload.velocity - point);
}

}  // namespace

int main() {
  Random random(3);
  std::array<double, 2> apart{};  // of a tenth and a hundredth of a percent of the arms
  for (std::size_t k = 0; k < 2000; ++k) {
    const Snapshot s = random_snapshot(random, 1 + k % 8);
    newton_euler_and_lagrange_agree(s);
    outside_forces_alone_change_momentum_and_energy(s);
    symmetries_carry_motions_to_motions(random, s);
    relabelled_vehicles_move_alike(s);
    short_arms_approach_a_point(s, apart);
  }
  CHECK_CLOSE(apart[1] / apart[0], 0.1, 0.002);
  return verdict();
}
