// The quadrotor: rotors' forces and torques, mixing, and its attitude loop against linear models.
#include "check.hpp"
#include "multilift/control/spatial/autopilot.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;

namespace {

using Vector = Vec3<double>;
using Kind = Quadrotors<double>;
using Speeds = std::array<double, rotors>;

constexpr double pi = std::numbers::pi;

Kind::Parameters craft_of(double frame_angle) {
  Kind::Parameters c(1);
  c.inertia[0] = {0.015, 0.017, 0.025};
  c.arm_length[0] = 0.225;
  c.frame_angle[0] = frame_angle;
  c.thrust_coefficient[0] = 8.5e-6;
  c.torque_ratio[0] = 0.016;
  c.rotor_speed_max[0] = 1000.0;
  c.rotor_time_constant[0] = 0.02;
  return c;
}

/// Torque on a resting craft, N m, from its angular acceleration.
Vector torque_of(const Kind::Parameters& c, const Speeds& speed) {
  const Kind kind(c);
  Craft<double> x, rate;
  x.rotor_speed = speed;
  kind.turn(0, x, speed, rate);
  return scale(c.inertia[0], rate.rate);
}

/// Where rotor k stands in B, from what the frame is called rather than from its angle: + has
/// rotors in front, left, behind, right; X front left, behind left, behind right, front right.
Vector place(bool plus, std::size_t k, double arm) {
  static constexpr double on_plus[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  static constexpr double on_x[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  const double part = plus ? arm : arm / std::numbers::sqrt2;
  const auto& xy = plus ? on_plus[k] : on_x[k];
  return {part * xy[0], part * xy[1], 0.0};
}

void each_rotor_pushes_where_it_stands(bool plus) {
  const auto c = craft_of(plus ? 0.0 : pi / 4.0);
  for (std::size_t k = 0; k < rotors; ++k) {
    Speeds speed{};
    speed[k] = 600.0;
    const double thrust = c.thrust_coefficient[0] * square(speed[k]);
    Vector expected = cross(place(plus, k, c.arm_length[0]), Vector{0.0, 0.0, thrust});
    // The first rotor turns clockwise seen from above, its reaction on the body counterclockwise.
    expected.z = (k % 2 == 0 ? 1.0 : -1.0) * c.torque_ratio[0] * thrust;
    CHECK_CLOSE(norm(torque_of(c, speed) - expected), 0.0, 1e-15);
  }
}

/// Thrust along the turned z, and drag against what crosses the rotor axis only.
void forces_follow_the_attitude(Random& random) {
  auto c = craft_of(pi / 4.0);
  c.rotor_drag[0] = 1e-4;
  Craft<double> x;
  x.attitude = random_attitude(random, 2.0);
  double thrust = 0.0, speeds = 0.0;
  for (double& speed : x.rotor_speed) {
    speed = random(0.0, 1000.0);
    thrust += c.thrust_coefficient[0] * square(speed);
    speeds += speed;
  }
  const Vector air = random_vector(random, 5.0), up = rotation(x.attitude).z;
  const Vector force = Kind(c).force(0, x, x.rotor_speed, air);
  const Vector across = air - dot(up, air) * up;
  CHECK_CLOSE(norm(force - (thrust * up - (c.rotor_drag[0] * speeds) * across)), 0.0, 1e-13);
}

/// A free craft with its rotors at rest: angular momentum in W and energy stay, as Euler's
/// equations have it, and an axisymmetric one precesses in closed form.
void a_free_craft_turns_as_euler_says(Random& random, bool symmetric) {
  auto c = craft_of(0.0);
  const double j = c.inertia[0].x;
  if (symmetric) c.inertia[0] = {j, j, 1.6 * j};
  const Kind kind(c);
  Craft<double> x;
  x.attitude = random_attitude(random, 2.0);
  x.rate = random_vector(random, 5.0);
  const Craft<double> start = x;
  const Vector spin = rotation(x.attitude).to_world(scale(c.inertia[0], x.rate));
  const double twice_energy = dot(x.rate, scale(c.inertia[0], x.rate)), h = 1e-3;
  const long steps = 2000;
  const auto moved = [](const Craft<double>& a, double by, const Craft<double>& k) {
    Craft<double> b = a, rate = k;
    zip([by](double& out, const double& dot) { out += by * dot; }, b, rate);
    return b;
  };
  for (long k = 0; k < steps; ++k) {
    Craft<double> k1{}, k2{}, k3{}, k4{};
    kind.turn(0, x, {}, k1);
    kind.turn(0, moved(x, 0.5 * h, k1), {}, k2);
    kind.turn(0, moved(x, 0.5 * h, k2), {}, k3);
    kind.turn(0, moved(x, h, k3), {}, k4);
    x = moved(moved(moved(moved(x, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
    x.attitude = normalised(x.attitude);
  }
  // Fourth order: (8/s 1e-3 s)^4 / 120 of the momentum per second, for 2 s.
  CHECK_CLOSE(norm(rotation(x.attitude).to_world(scale(c.inertia[0], x.rate)) - spin), 0.0,
              1e-9 * norm(spin));
  CHECK_CLOSE(dot(x.rate, scale(c.inertia[0], x.rate)), twice_energy, 1e-9 * twice_energy);
  if (!symmetric) return;
  const double turned = 0.6 * start.rate.z * h * static_cast<double>(steps);
  const double cosine = std::cos(turned), sine = std::sin(turned);
  // (J_z - J) / J = 0.6: omega_xy turns about z at 0.6 omega_z, clockwise about it since
  // omega_x' = -0.6 omega_z omega_y is a turn the other way: x' = -w y, y' = w x.
  CHECK_CLOSE(x.rate.x, cosine * start.rate.x - sine * start.rate.y, 1e-8);
  CHECK_CLOSE(x.rate.y, sine * start.rate.x + cosine * start.rate.y, 1e-8);
}

AutopilotParameters<double> gains() { return AutopilotParameters<double>(1); }

/// In the range where nothing saturates, what is asked for is what the rotors do: thrust and
/// torques, these in shares of the greatest thrust: each rotor's share moves by sqrt(1/2) on an X
/// frame.
void mixing_inverts_the_rotors(Random& random, bool plus) {
  const double angle = plus ? 0.0 : pi / 4.0;
  const auto c = craft_of(angle);
  auto p = gains();
  p.rate_i[0] = p.rate_d[0] = {};
  p.rate_p[0] = {1.0, 1.0, 1.0};
  p.attitude_gain[0] = {1.0, 1.0, 1.0};
  // The whole chain from a rate error at the wanted attitude: torque = -rate.
  Craft<double> x;
  x.rate = random_vector(random, 0.05);
  Autopilot<double> autopilot(p, c, 1e-3);
  const double thrust = random(0.3, 0.7);
  const Speeds speed = autopilot.step(0, x, {Quaternion<double>{}, thrust});
  CHECK(!autopilot.saturated(0));
  double sum = 0.0;
  for (const double s : speed) sum += square(s / c.rotor_speed_max[0]);
  CHECK_CLOSE(sum, 4.0 * thrust, 1e-12);
  const double greatest = c.thrust_coefficient[0] * square(c.rotor_speed_max[0]);
  const Vector torque = torque_of(c, speed);
  // Roll and pitch: two pairs of arms at l/sqrt2 each moved by x/sqrt2, or one pair at l moved by
  // x.
  const double arm = 2.0 * c.arm_length[0] * greatest;
  CHECK_CLOSE(torque.x, -arm * x.rate.x, 1e-12);
  CHECK_CLOSE(torque.y, -arm * x.rate.y, 1e-12);
  CHECK_CLOSE(torque.z, -4.0 * c.torque_ratio[0] * greatest * x.rate.z, 1e-12);
}

/// Whatever is asked for, rotors stay in their range, tilt torques keep their direction, and roll
/// and pitch come whole unless twice their greatest share exceeds the range.
void saturated_mixing_keeps_tilt_first(Random& random) {
  const auto c = craft_of(pi / 4.0);
  auto p = gains();
  p.rate_i[0] = p.rate_d[0] = {};
  p.rate_p[0] = {1.0, 1.0, 1.0};
  Craft<double> x;
  x.rate = random_vector(random, 2.0);
  Autopilot<double> autopilot(p, c, 1e-3);
  const Speeds speed = autopilot.step(0, x, {Quaternion<double>{}, random(0.0, 1.0)});
  for (const double s : speed) CHECK(0.0 <= s && s <= c.rotor_speed_max[0]);
  const double greatest = c.thrust_coefficient[0] * square(c.rotor_speed_max[0]);
  const double arm = 2.0 * c.arm_length[0] * greatest;
  const Vector torque = (1.0 / arm) * torque_of(c, speed);
  const double share = (std::fabs(x.rate.x) + std::fabs(x.rate.y)) / std::numbers::sqrt2;
  const double kept = std::fmin(1.0, 0.5 / share);
  CHECK_CLOSE(torque.x, -kept * x.rate.x, 1e-12);
  CHECK_CLOSE(torque.y, -kept * x.rate.y, 1e-12);
  CHECK(torque.z * -x.rate.z >= -1e-12);
}

/// A craft under its autopilot, its position left aside.
std::vector<Craft<double>> turn_under_autopilot(const Kind::Parameters& c,
                                                const AutopilotParameters<double>& p,
                                                Craft<double> x, const Quaternion<double>& wanted,
                                                double h, long steps) {
  const Kind kind(c);
  Autopilot<double> autopilot(p, c, h);
  std::vector<Craft<double>> way{x};
  const auto moved = [](const Craft<double>& a, double by, const Craft<double>& k) {
    Craft<double> b = a, rate = k;
    zip([by](double& out, const double& dot) { out += by * dot; }, b, rate);
    return b;
  };
  for (long k = 0; k < steps; ++k) {
    const Speeds input = autopilot.step(0, x, {wanted, 0.4});
    Craft<double> k1{}, k2{};
    kind.turn(0, x, input, k1);
    kind.turn(0, moved(x, 0.5 * h, k1), input, k2);
    x = moved(x, h, k2);
    x.attitude = normalised(x.attitude);
    way.push_back(x);
  }
  return way;
}

/// Small steps of the attitude's setpoint follow the loop's linear model: about each axis, angle a,
/// rate w, and rotor lag l with the same time constant T in the thrust's linearisation,
///
///     a' = w,  J w' = G l,  T l' = P (A (a_set - a) - w) - l,
///
/// G the torque per unit of normalised torque. Integral and derivative gains are 0 here.
void small_steps_follow_the_linear_loop(int axis) {
  const auto c = craft_of(pi / 4.0);
  auto p = gains();
  p.rate_i[0] = p.rate_d[0] = {};
  const double angle = 1e-4, h = 1e-4;
  const long steps = 10000;
  Craft<double> x;
  x.rotor_speed.fill(std::sqrt(0.4) * c.rotor_speed_max[0]);
  const double half = 0.5 * angle;
  const Quaternion<double> wanted = normalised(Quaternion<double>{
      1.0, axis == 0 ? half : 0.0, axis == 1 ? half : 0.0, axis == 2 ? half : 0.0});
  const auto way = turn_under_autopilot(c, p, x, wanted, h, steps);
  const double greatest = c.thrust_coefficient[0] * square(c.rotor_speed_max[0]);
  const double inertia[3] = {c.inertia[0].x, c.inertia[0].y, c.inertia[0].z};
  const double gain[3] = {p.attitude_gain[0].x, p.attitude_gain[0].y, p.attitude_gain[0].z};
  const double rate_gain[3] = {p.rate_p[0].x, p.rate_p[0].y, p.rate_p[0].z};
  const double lever = axis < 2 ? 2.0 * c.arm_length[0] : 4.0 * c.torque_ratio[0];
  const double per = lever * greatest / inertia[axis], lag = c.rotor_time_constant[0];
  double a = 0.0, w = 0.0, l = 0.0, apart = 0.0, peak = 0.0;
  for (long k = 0; k < steps; ++k) {
    const auto& q = way[static_cast<std::size_t>(k)].attitude;
    const double found = 2.0 * (axis == 0 ? q.x : axis == 1 ? q.y : q.z);
    apart = std::fmax(apart, std::fabs(found - a));
    peak = std::fmax(peak, a);
    // Semi-implicit in ten parts, far finer than the loop.
    const double command = rate_gain[axis] * (gain[axis] * (angle - a) - w);
    for (int part = 0; part < 10; ++part) {
      const double d = 0.1 * h;
      l += d * (command - l) / lag;
      w += d * per * l;
      a += d * w;
    }
  }
  // Nonlinear parts go with the angle: 1e-4 of it. The reference's ten parts cost h / 20 / lag.
  CHECK_CLOSE(apart / angle, 0.0, 2e-3);
  CHECK(peak > 0.5 * angle);
  CHECK_CLOSE(a, angle, 0.15 * angle);
}

/// Where Routh's criterion puts the border, J T s^3 + J s^2 + G P s + G P A with 1 = T A: the loop
/// dies away on the one side and grows on the other.
void the_loop_is_stable_where_routh_says() {
  const auto c = craft_of(pi / 4.0);
  for (const double part : {0.7, 1.4}) {
    auto p = gains();
    p.rate_i[0] = p.rate_d[0] = {};
    const double a = part / c.rotor_time_constant[0];
    p.attitude_gain[0] = {a, a, a};
    p.rate_limit[0] = {1e3, 1e3, 1e3};
    Craft<double> x;
    x.rotor_speed.fill(std::sqrt(0.4) * c.rotor_speed_max[0]);
    const auto wanted = normalised(Quaternion<double>{1.0, 5e-7, 0.0, 0.0});
    const auto way = turn_under_autopilot(c, p, x, wanted, 1e-4, 20000);
    double early = 0.0, late = 0.0;
    for (std::size_t k = 0; k < 20000; ++k) {
      double& peak = k < 5000 ? early : late;
      if (k < 5000 || k >= 15000) peak = std::fmax(peak, std::fabs(way[k].rate.x));
    }
    CHECK(part < 1.0 ? late < 0.5 * early : late > 2.0 * early);
  }
}

/// Large turns end at the wanted attitude, a thrust's direction first, whatever the start, upside
/// down included.
void large_turns_end_where_they_should(Random& random) {
  const auto c = craft_of(pi / 4.0);
  Craft<double> x;
  x.attitude =
      normalised(Quaternion<double>{random(-1, 1), random(-1, 1), random(-1, 1), random(-1, 1)});
  x.rotor_speed.fill(std::sqrt(0.4) * c.rotor_speed_max[0]);
  const Vector force{random(-1.0, 1.0), random(-1.0, 1.0), random(0.5, 1.0)};
  const double yaw = random(-pi, pi);
  const SinCos<double> half{std::sin(0.5 * yaw), std::cos(0.5 * yaw)};
  const auto wanted = attitude_along(force, norm(force), half);
  const Rotation<double> r = rotation(wanted);
  CHECK_CLOSE(norm(r.z - (1.0 / norm(force)) * force), 0.0, 1e-14);
  const auto way = turn_under_autopilot(c, gains(), x, wanted, 1e-3, 15000);
  const Rotation<double> end = rotation(way.back().attitude);
  // The integral's slow part is what is left.
  CHECK_CLOSE(norm(end.z - r.z), 0.0, 2e-3);
  CHECK_CLOSE(norm(end.x - r.x), 0.0, 2e-2);
}

}  // namespace

int main() {
  Random random(17);
  for (const bool plus : {true, false}) {
    each_rotor_pushes_where_it_stands(plus);
    for (int k = 0; k < 100; ++k) mixing_inverts_the_rotors(random, plus);
  }
  for (int k = 0; k < 100; ++k) forces_follow_the_attitude(random);
  for (int k = 0; k < 10; ++k) a_free_craft_turns_as_euler_says(random, k % 2 == 0);
  for (int k = 0; k < 1000; ++k) saturated_mixing_keeps_tilt_first(random);
  for (int axis = 0; axis < 3; ++axis) small_steps_follow_the_linear_loop(axis);
  the_loop_is_stable_where_routh_says();
  for (int k = 0; k < 20; ++k) large_turns_end_where_they_should(random);
  return verdict();
}
