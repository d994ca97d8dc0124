// The storage function of the spatial laws: its powers make up its rate, term by term closed, and
// for two vehicles in a plane plant, laws and storage function are the planar ones.
#include "check.hpp"
#include "multilift/control/spatial/pd.hpp"
#include "multilift/model/spatial/energy.hpp"
#include "multilift/model/spatial/quadrotor.hpp"
#include "random_spatial.hpp"

using namespace multilift;
using namespace multilift::spatial;
namespace flat = multilift::planar;

namespace {

using Vector = Vec3<double>;

Vector some(Random& random) { return {random(0.2, 2.0), random(0.2, 2.0), random(0.2, 2.0)}; }

StorageGains<double> random_gains(Random& random, std::size_t n) {
  StorageGains<double> gains(n);
  gains.k_lambda = random(0.1, 1.0);
  for (std::size_t i = 0; i < n; ++i)
    gains.k_p[i] = some(random), gains.k_d[i] = some(random), gains.inverse_gamma[i] = some(random);
  return gains;
}

Formation<double> random_formation(Random& random, const Parameters<double>& p) {
  Formation<double> formation(p.size());
  Vector rest{0.0, 0.0, p.payload_mass * p.gravity};
  for (std::size_t i = 0; i < p.size(); ++i) {
    formation.offset[i] = random_vector(random, 2.0);
    formation.cable_force[i] = i + 1 < p.size() ? random_vector(random, 5.0) : rest;
    rest -= formation.cable_force[i];
  }
  formation.complete();
  return formation;
}

/// d/dt V along the motion, by central differences of the storage function along the plant's rate
/// and the reference's way, is the sum of the powers; d_hat rests.
template <class Vehicles, class Cables>
void powers_make_up_the_rate(Random& random, std::size_t n) {
  using V = typename Vehicles::State;
  Parameters<double> p = random_parameters(random, n);
  add_drag(random, p);
  typename Vehicles::Parameters craft(n);
  std::vector<typename Vehicles::Input> input(n);
  State<double, V> x = random_state<V>(random, p, 2.0, Cables::rigid ? 1.0 : 1.01);
  if constexpr (requires(V v) { v.rotor_speed; }) {
    for (std::size_t i = 0; i < n; ++i) {
      craft.inertia[i] = {0.01, 0.02, 0.03};
      craft.arm_length[i] = 0.2, craft.thrust_coefficient[i] = 1e-5;
      craft.torque_ratio[i] = 0.02, craft.rotor_speed_max[i] = 1000.0;
      craft.rotor_time_constant[i] = 0.02, craft.rotor_drag[i] = 1e-4;
      x.vehicle[i].attitude = random_attitude(random, 1.0);
      x.vehicle[i].rate = random_vector(random, 3.0);
      for (double& speed : x.vehicle[i].rotor_speed) speed = random(0.0, 1000.0);
      for (double& speed : input[i]) speed = random(0.0, 1000.0);
    }
  } else {
    for (Vector& f : input) f = random_vector(random, 20.0);
  }
  Ground<double> ground;
  ground.height = random(-1.5, -0.5);  // some feet below it
  ground.sink = 0.05;
  const Dynamics<double, Vehicles, Cables> dynamics(Plant<double>(p), Vehicles(craft), ground);
  Surroundings<double> outside(n);
  for (Vector& push : outside.vehicle_push) push = random_vector(random, 10.0);
  outside.payload_push = random_vector(random, 10.0);
  outside.payload_push_torque = random_vector(random, 2.0);
  outside.wind = random_vector(random, 3.0);
  Instant<double> now(n);
  dynamics.evaluate(x, input, outside, Masks<double>(n, {true}), now);
  State<double, V> rate(n);
  dynamics.rate(x, input, now, rate);

  Path path;
  path.pieces.push_back({0.0, {}});
  for (auto& polynomial : path.pieces[0].coordinate)
    for (double& c : polynomial) c = random(-0.5, 0.5);
  path.end = 10.0;
  const Reference<double> reference(random_vector(random, 2.0), random(-3.0, 3.0), path,
                                    random_formation(random, p));
  const StorageGains<double> gains = random_gains(random, n);
  const Coupling<double> coupling(p, gains);
  std::vector<Vector> d_hat(n);
  for (Vector& d : d_hat) d = some(random);
  const double time = 0.7;
  const Plant<double> plant(p);
  const auto storage_after = [&](double h) {
    State<double, V> moved = x;
    zip([h](double& number, const double& dot) { number += h * dot; }, moved, rate);
    Target<double> target(n);
    reference.at(time + h, target);
    return storage_function(plant, gains, coupling, moved, target, d_hat);
  };
  const double h = 1e-5;
  const double slope = (8.0 * (storage_after(h) - storage_after(-h)) -
                        (storage_after(2.0 * h) - storage_after(-2.0 * h))) /
                       (12.0 * h);
  Target<double> target(n);
  reference.at(time, target);
  const Powers<double> w = powers_of(plant, gains, coupling, x, now, outside, target, d_hat);
  // Differences of numbers of up to 1e3 J to 1e-16, over 1e-5 s.
  const double size = 1.0 + std::fabs(storage_after(0.0)) + std::fabs(slope);
  CHECK_CLOSE(w.total(), slope, 1e-9 * size);
  CHECK(w.dissipation <= 0.0);
}

/// A planar world and the same in space: y and z are the planar ones, x is across.
struct Both3d {
  flat::Plant<double> planar;
  flat::State<double> start;
  Parameters<double> p;
  State<double, PointMass<double>> x;
};

Vector up(const Vec2<double>& v) { return {0.0, v.y, v.z}; }

Both3d both_of(Random& random, double inertia) {
  const flat::World world = flat::random_world(random);
  flat::Parameters<double> q = flat::plant_of(world.plant);
  q.bar_inertia = inertia;
  q.swing_damping = {0.0, 0.0, inertia > 0.0 ? 0.3 : 0.0};
  const flat::Plant<double> planar(q);
  flat::State<double> start = flat::state_of(world.state);
  const auto pose = flat::pose_of(planar, start);
  Parameters<double> p(2);
  p.gravity = q.gravity;
  p.payload_mass = q.bar_mass;
  p.payload_inertia = {inertia, 0.2, 0.3};
  p.payload_spin_damping = {q.swing_damping[2], 0.1, 0.1};
  State<double, PointMass<double>> x(2);
  const double half = 0.5 * start.theta[2];
  x.payload = {up(start.bar),
               {std::cos(half), std::sin(half), 0.0, 0.0},
               up(start.bar_velocity),
               {start.theta_dot[2], 0.0, 0.0}};
  for (std::size_t i = 0; i < 2; ++i) {
    p.vehicle_mass[i] = q.vehicle_mass[i];
    p.vehicle_drag[i] = Vector{0.4, q.vehicle_drag[i].y, q.vehicle_drag[i].z};
    p.cable_length[i] = q.cable_length[i];
    p.attachment[i] = {0.0, (i == 0 ? -0.5 : 0.5) * q.bar_length, q.bar_half_thickness};
    x.vehicle[i] = {up(pose.vehicle[i]), up(pose.vehicle_velocity[i])};
  }
  return {planar, start, p, x};
}

struct Rates {
  flat::Motion<double> planar;
  Instant<double> now{2};
  State<double, PointMass<double>> rate{2};
  flat::Loads<double> loads;
  Surroundings<double> outside{2};
};

Rates rates_of(Random& random, const Both3d& b) {
  Rates r;
  const auto pose = flat::pose_of(b.planar, b.start);
  r.loads = flat::loads_of(random.several<11>(-10.0, 10.0));
  std::vector<Vector> force(2);
  for (std::size_t i = 0; i < 2; ++i) {
    // Planar loads hold each vehicle's own and half of the bar's weight besides u.
    force[i] = up(r.loads.u[i]);
    force[i].z += b.planar.gravity_share(i);
    r.outside.vehicle_push[i] = up(r.loads.vehicle_push[i]);
  }
  r.outside.payload_push = up(r.loads.bar_push);
  r.outside.payload_push_torque = {r.loads.bar_torque, 0.0, 0.0};
  r.planar = flat::motion(b.planar, b.start, pose, r.loads);
  const Dynamics<double, IdealVehicles<double>, RigidCables<double>> dynamics(
      Plant<double>(b.p), IdealVehicles<double>(IdealVehicles<double>::Parameters(2)), {});
  dynamics.evaluate(b.x, force, r.outside, Masks<double>(2, {true}), r.now);
  dynamics.rate(b.x, force, r.now, r.rate);
  return r;
}

void two_vehicles_in_a_plane_are_the_planar_model(Random& random) {
  const Both3d b = both_of(random, random(0.01, 1.0));
  const Rates r = rates_of(random, b);
  double size = 1.0;
  for (const double x : flat::flat(r.planar)) size = std::fmax(size, std::fabs(x));
  // Two systems of equations for one motion, of condition some 1e3.
  const double tolerance = 1e-11 * size;
  CHECK_CLOSE(norm(r.rate.payload.velocity - up(r.planar.bar_acceleration)), 0.0, tolerance);
  CHECK_CLOSE(norm(r.rate.payload.rate - Vector{r.planar.theta_ddot[2], 0.0, 0.0}), 0.0, tolerance);
  for (std::size_t i = 0; i < 2; ++i)
    CHECK_CLOSE(r.now.motion.tension[i], r.planar.tension[i], tolerance);
}

/// The paper's bar has no inertia; a lighter and lighter one approaches it in proportion.
void a_bar_of_little_inertia_approaches_one_of_none(Random& random, std::array<double, 2>& apart) {
  Random same = random;
  for (std::size_t k = 0; k < 2; ++k) {
    Random draws = same;
    const Both3d none = both_of(draws, 0.0);
    Both3d little = none;
    little.p.payload_inertia.x = k == 0 ? 1e-5 : 1e-6;
    little.p.payload_spin_damping = {};
    const Rates r = rates_of(draws, little);
    // How near both cables are to pointing at the centre, where a bar without inertia has no
    // equation: worlds there are left aside.
    double lever = 0.0;
    for (std::size_t i = 0; i < 2; ++i)
      lever += little.p.vehicle_mass[i] * square(r.now.cable[i].moment.x);
    if (lever > 0.1) apart[k] += norm(r.rate.payload.velocity - up(r.planar.bar_acceleration));
    random = draws;
  }
}

/// Law, storage function and powers of n = 2 in the plane are the paper's as the planar core has
/// them.
void laws_and_storage_reduce_to_the_planar_ones(Random& random) {
  const Both3d b = both_of(random, random(0.01, 1.0));
  const Rates r = rates_of(random, b);
  const auto numbers = random.several<25>(0.2, 1.0);
  using PlanarLaw = flat::EnergyCoupled<double>;
  auto planar_gains = unpack<PlanarLaw::Gains>(numbers.data());
  planar_gains.feedback.k_i = {};
  const std::array<Vec2<double>, 2> goal = flat::hover(b.planar);
  const double period = 0.02;
  PlanarLaw planar_law(planar_gains, b.planar, goal, period);

  typename EnergyCoupled<double>::Gains gains(2);
  gains.k_lambda = planar_gains.k_lambda;
  const Vector across{0.7, 0.0, 0.0};  // gains across the plane do not matter
  Formation<double> formation(2);
  for (std::size_t i = 0; i < 2; ++i) {
    gains.feedback.k_p[i] = across + up(planar_gains.feedback.k_p[i]);
    gains.feedback.k_d[i] = across + up(planar_gains.feedback.k_d[i]);
    gains.feedback.gamma[i] = across + up(planar_gains.feedback.gamma[i]);
    gains.feedback.d_hat_start[i] = across + up(planar_gains.feedback.d_hat_start[i]);
    formation.offset[i] = up(goal[i]);
    formation.cable_force[i] = {0.0, 0.0, 0.5 * b.p.payload_mass * b.p.gravity};
  }
  formation.complete();
  EnergyCoupled<double> law(gains, b.p, period);
  Target<double> target(2);
  Reference<double>({}, 0.0, {}, formation).at(0.0, target);

  const auto pose = flat::pose_of(b.planar, b.start);
  flat::Measurement<double> seen;
  seen.vehicle = pose.vehicle, seen.vehicle_velocity = pose.vehicle_velocity;
  seen.theta = b.start.theta, seen.angle = pose.angle, seen.theta_dot = b.start.theta_dot;
  Measurement<double> measured(2);
  for (std::size_t i = 0; i < 2; ++i) {
    measured.vehicle[i] = b.x.vehicle[i].position;
    measured.vehicle_velocity[i] = b.x.vehicle[i].velocity;
  }
  measured.payload = b.x.payload;
  // Twice, so that the estimate has moved once.
  for (int turn = 0; turn < 2; ++turn) {
    const flat::Storage<double> of_plane(b.planar, planar_law.storage_gains(), goal);
    const auto shared = of_plane.formation(b.planar, b.start, pose, nullptr);
    const double planar_storage = of_plane.motion_energy(b.planar, b.start, pose, shared) +
                                  of_plane.estimation_energy(b.planar, planar_law.d_hat());
    const Plant<double> plant(b.p);
    auto storage_gains = law.storage_gains();
    const Coupling<double> coupling(plant, storage_gains);
    auto d_hat = law.drag_estimate();
    // The estimate across the plane is right, so that it has no energy.
    for (std::size_t i = 0; i < 2; ++i) d_hat[i].x = b.p.vehicle_drag[i].x;
    const double size = 1.0 + std::fabs(planar_storage);
    CHECK_CLOSE(storage_function(plant, storage_gains, coupling, b.x, target, d_hat),
                planar_storage, 1e-12 * size);
    const auto w = powers_of(plant, storage_gains, coupling, b.x, r.now, r.outside, target, d_hat);
    const auto planar_w = of_plane.powers(b.planar, b.start, pose, shared, r.loads, r.planar,
                                          planar_law.d_hat(), nullptr);
    const double power = 1.0 + std::fabs(planar_w.push) + std::fabs(planar_w.internal) +
                         std::fabs(planar_w.dissipation) + std::fabs(planar_w.actuation);
    CHECK_CLOSE(w.dissipation + w.payload_drag, planar_w.dissipation, 1e-11 * power);
    CHECK_CLOSE(w.push, planar_w.push, 1e-11 * power);
    CHECK_CLOSE(w.actuation, planar_w.actuation, 1e-11 * power);
    CHECK_CLOSE(w.adaptation, planar_w.adaptation, 1e-11 * power);
    CHECK_CLOSE(w.internal, planar_w.internal, 1e-9 * power);

    const auto u = planar_law.step(seen);
    std::vector<Vector> force(2);
    law.step(measured, target, force);
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector expected = up(u[i]) + Vector{0.0, 0.0, b.planar.gravity_share(i)};
      CHECK_CLOSE(norm(force[i] - expected), 0.0, 1e-12 * (1.0 + norm(expected)));
    }
  }
}

}  // namespace

int main() {
  Random random(23);
  for (std::size_t k = 0; k < 500; ++k) {
    const std::size_t n = 1 + k % 6;
    powers_make_up_the_rate<IdealVehicles<double>, RigidCables<double>>(random, n);
    powers_make_up_the_rate<IdealVehicles<double>, ElasticCables<double>>(random, n);
    powers_make_up_the_rate<Quadrotors<double>, RigidCables<double>>(random, n);
  }
  std::array<double, 2> apart{};
  for (int k = 0; k < 1000; ++k) {
    two_vehicles_in_a_plane_are_the_planar_model(random);
    a_bar_of_little_inertia_approaches_one_of_none(random, apart);
    laws_and_storage_reduce_to_the_planar_ones(random);
  }
  CHECK_CLOSE(apart[0] / apart[1], 10.0, 0.5);
  return verdict();
}
