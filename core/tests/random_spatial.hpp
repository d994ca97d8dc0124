// Random spatial worlds, and flights of the bare plant through the stepper.
#pragma once

#include <vector>

#include "multilift/sim/spatial/stepper.hpp"
#include "random_planar.hpp"

namespace multilift::spatial {

using planar::Random;

inline Vec3<double> random_vector(Random& random, double size) {
  return {random(-size, size), random(-size, size), random(-size, size)};
}

inline Quaternion<double> random_attitude(Random& random, double tilt) {
  return normalised(
      Quaternion<double>{1.0, random(-tilt, tilt), random(-tilt, tilt), random(-tilt, tilt)});
}

/// A rigid payload on n cables, without drag. Its moments of inertia are those of a body: the sum
/// of any two exceeds the third.
inline Parameters<double> random_parameters(Random& random, std::size_t n) {
  Parameters<double> p(n);
  p.payload_mass = random(0.5, 5.0);
  const double a = random(0.05, 0.5), b = random(0.05, 0.5), c = random(0.05, 0.5);
  p.payload_inertia = {b + c, c + a, a + b};
  for (std::size_t i = 0; i < n; ++i) {
    p.vehicle_mass[i] = random(0.5, 5.0);
    p.cable_length[i] = random(0.5, 3.0);
    p.attachment[i] = random_vector(random, 0.8);
  }
  return p;
}

inline void add_drag(Random& random, Parameters<double>& p) {
  const auto some = [&] { return Vec3<double>{random(0, 1), random(0, 1), random(0, 1)}; };
  p.payload_drag = some();
  p.payload_drag_quadratic = random(0.0, 0.5);
  p.payload_spin_damping = some();
  for (auto& drag : p.vehicle_drag) drag = some();
}

/// A moving state with every cable at `part` of its rest length. At full length it keeps it.
template <class V = PointMass<double>>
State<double, V> random_state(Random& random, const Parameters<double>& p, double speed,
                              double part = 1.0) {
  State<double, V> x(p.size());
  x.payload = {random_vector(random, 2.0), random_attitude(random, 0.5),
               random_vector(random, speed), random_vector(random, speed)};
  const Rotation<double> turn = rotation(x.payload.attitude);
  for (std::size_t i = 0; i < p.size(); ++i) {
    Vec3<double> d{random(-0.7, 0.7), random(-0.7, 0.7), 1.0};
    d = (1.0 / norm(d)) * d;
    x.vehicle[i].position =
        x.payload.position + turn.to_world(p.attachment[i]) + (part * p.cable_length[i]) * d;
    Vec3<double> v = random_vector(random, speed);
    if (part == 1.0) v -= dot(d, v) * d;
    x.vehicle[i].velocity =
        x.payload.velocity + turn.to_world(cross(x.payload.rate, p.attachment[i])) + v;
  }
  return x;
}

template <class R, class V>
std::vector<double> numbers_of(const State<R, V>& x, int lane_index = 0) {
  std::vector<double> all;
  State<R, V> copy = x;
  zip([&](const R& number) { all.push_back(value(lane(number, lane_index))); }, copy);
  return all;
}

/// Several worlds side by side.
template <class L, template <class> class V>
State<L, V<L>> side_by_side(const std::vector<State<double, V<double>>>& worlds) {
  State<L, V<L>> x(worlds[0].size());
  for (int k = 0; k < lanes_of<L>; ++k) {
    const auto numbers = numbers_of(worlds[static_cast<std::size_t>(k)]);
    auto next = numbers.begin();
    zip([&](L& number) { set_lane(number, k, *next++); }, x);
  }
  return x;
}
template <class L>
Parameters<L> side_by_side(const std::vector<Parameters<double>>& worlds) {
  std::vector<double> rows;
  for (const Parameters<double>& p : worlds)
    Parameters<double>::visit(p, [&](const Field&, const auto& member) {
      for_each_scalar(member, [&](const double& x) { rows.push_back(x); });
    });
  std::size_t column = 0;
  const Rows all{rows.data(), rows.size() / worlds.size(), lanes_of<L>};
  return unpack<Parameters<L>>(all, column, worlds[0].size());
}

/// A ledger that counts the Runge-Kutta steps tried.
struct Tries {
  long count{0};
  void restart() { ++count; }
  void add(const auto&...) {}
  void book() {}
  void before_jump(const auto&) {}
  void after_jump(const auto&) {}
};

/// The bare plant under constant forces of its vehicles, W, N.
template <class R, class C = RigidCables<R>>
class Flight {
 public:
  using D = Dynamics<R, IdealVehicles<R>, C>;
  using X = typename D::X;

  Flight(const Parameters<R>& p, const X& start, std::vector<Vec3<R>> force,
         const std::optional<Ground<R>>& ground = {})
      : x(start),
        stepper(D(Plant<R>(p), IdealVehicles<R>(typename IdealVehicles<R>::Parameters(p.size())),
                  ground),
                p.size()),
        outside(p.size()),
        force_(std::move(force)) {
    stepper.begin(x);
  }

  void advance(double h, long steps = 1) {
    for (long k = 0; k < steps; ++k) {
      observe();
      stepper.step(x, force_, h, [&](const R&, Stage) -> const auto& { return outside; }, tries);
    }
  }
  const Instant<R>& observe() { return stepper.observe(x, force_, outside); }

  X x;
  Stepper<R, D> stepper;
  Surroundings<R> outside;
  Tries tries;

 private:
  std::vector<Vec3<R>> force_;
};

/// Total momentum, kg m/s.
template <class V>
Vec3<double> momentum(const Parameters<double>& p, const State<double, V>& x) {
  Vec3<double> sum = p.payload_mass * x.payload.velocity;
  for (std::size_t i = 0; i < p.size(); ++i) sum += p.vehicle_mass[i] * x.vehicle[i].velocity;
  return sum;
}

/// Total angular momentum about the world's origin, kg m^2/s.
template <class V>
Vec3<double> angular_momentum(const Parameters<double>& p, const State<double, V>& x) {
  Vec3<double> sum =
      p.payload_mass * cross(x.payload.position, x.payload.velocity) +
      rotation(x.payload.attitude).to_world(scale(p.payload_inertia, x.payload.rate));
  for (std::size_t i = 0; i < p.size(); ++i)
    sum += p.vehicle_mass[i] * cross(x.vehicle[i].position, x.vehicle[i].velocity);
  return sum;
}

}  // namespace multilift::spatial
