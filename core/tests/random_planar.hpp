// Random planar worlds as flat numbers, and the core's structs made of them over any scalar.
#pragma once

#include <array>
#include <cstdint>

#include "multilift/multilift.hpp"

namespace multilift::planar {

template <std::size_t N>
using Numbers = std::array<double, N>;

/// Uniform numbers, the same in every run.
class Random {
 public:
  explicit Random(std::uint32_t seed) : seed_(seed) {}

  double operator()(double low, double high) {
    return low + (high - low) * 0x1p-32 * static_cast<double>(philox<double>(seed_, 0, next_++).w0);
  }
  template <std::size_t N>
  Numbers<N> several(double low, double high) {
    Numbers<N> x;
    for (double& number : x) number = (*this)(low, high);
    return x;
  }

 private:
  std::uint32_t seed_;
  std::uint32_t next_{0};
};

/// A plant, a state and loads. A bar without inertia has no equation for its turning where both
/// cables point at its centre; these worlds keep away from there.
struct World {
  Numbers<16> plant;
  Numbers<10> state;
  Numbers<11> loads;
};

inline World random_world(Random& random) {
  Parameters<double> p;
  for (std::size_t i = 0; i < 2; ++i) {
    p.vehicle_mass[i] = random(0.5, 5.0);
    p.cable_length[i] = random(0.5, 3.0);
    p.vehicle_drag[i] = {random(0.0, 2.0), random(0.0, 2.0)};
  }
  p.bar_mass = random(0.2, 5.0);
  p.bar_length = random(0.5, 3.0);
  p.bar_half_thickness = random(0.0, 0.1) * p.bar_length;
  p.bar_inertia = random(0.0, 1.0) < 0.5 ? 0.0 : random(0.001, 1.0);
  p.gravity = random(0.0, 20.0);
  p.swing_damping = random.several<3>(0.0, 0.5);

  World world;
  double* next = world.plant.data();
  Parameters<double>::visit(p, [&](const Field&, const auto& member) {
    for_each_scalar(member, [&](const double& x) { *next++ = x; });
  });
  world.state = random.several<10>(-3.0, 3.0);
  for (std::size_t k = 2; k < 5; ++k) world.state[k] *= 0.2;  // the angles
  world.loads = random.several<11>(-10.0, 10.0);
  return world;
}

/// A random world that moves slowly and hangs nearly upright under Earth's gravity.
inline World gentle_world(Random& random) {
  World world = random_world(random);
  world.plant[8] = 9.8;  // gravity
  for (double& x : world.state) x *= 0.1;
  return world;
}

template <Real R, std::size_t N>
std::array<R, N> over(const Numbers<N>& x) {
  std::array<R, N> result;
  for (std::size_t k = 0; k < N; ++k) result[k] = R(x[k]);
  return result;
}

template <Real R>
Plant<R> plant_of(const std::array<R, 16>& x) {
  return Plant<R>(unpack<Parameters<R>>(x.data()));
}

template <Real R>
std::array<Vec2<R>, 2> pair_of(const R* x) {
  return {Vec2<R>{x[0], x[1]}, Vec2<R>{x[2], x[3]}};
}

template <Real R>
State<R> state_of(const std::array<R, 10>& x) {
  return {{x[0], x[1]}, {x[2], x[3], x[4]}, {x[5], x[6]}, {x[7], x[8], x[9]}};
}

template <Real R>
std::array<R, 10> flat(const State<R>& s) {
  return s.flat();
}

template <Real R>
Loads<R> loads_of(const std::array<R, 11>& x) {
  return {pair_of(&x[0]), pair_of(&x[4]), {x[8], x[9]}, x[10]};
}

/// Everything that motion() finds.
template <Real R>
std::array<R, 11> flat(const Motion<R>& m) {
  return {m.bar_acceleration.y, m.bar_acceleration.z, m.theta_ddot[0],   m.theta_ddot[1],
          m.theta_ddot[2],      m.tension[0],         m.tension[1],      m.cable_force[0].y,
          m.cable_force[0].z,   m.cable_force[1].y,   m.cable_force[1].z};
}

template <Real R>
Motion<R> motion_of(const std::array<R, 16>& plant, const std::array<R, 10>& state,
                    const std::array<R, 11>& loads) {
  const Plant<R> p = plant_of(plant);
  const State<R> s = state_of(state);
  return motion(p, s, pose_of(p, s), loads_of(loads));
}

/// Where the vehicles of a hovering formation are.
template <Real R>
std::array<Vec2<R>, 2> hover(const Plant<R>& p) {
  return pose_of(p, State<R>{}).vehicle;
}

/// A law that holds hover, over any scalar.
template <Real R>
EnergyCoupled<R> law_of(const Numbers<25>& gains, const Plant<R>& p, double period) {
  const auto numbers = over<R>(gains);
  return {unpack<typename EnergyCoupled<R>::Gains>(numbers.data()), p, hover(p), period};
}

}  // namespace multilift::planar
