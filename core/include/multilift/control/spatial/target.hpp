// Where everything shall be: the payload's reference and the formation that hangs it there.
#pragma once

#include <array>
#include <vector>

#include "multilift/math/rotation.hpp"
#include "multilift/math/sincos.hpp"
#include "multilift/model/spatial/parameters.hpp"
#include "multilift/plan/path.hpp"

namespace multilift::spatial {

/// The payload's way as polynomials in time, piece by piece, relative to its goal: all zero is a
/// step to the goal. Worlds side by side share it.
using Path = plan::Path<4>;

/// How the vehicles stand about the payload at rest, in the payload's level frame.
template <Real R>
struct Formation {
  std::vector<Vec3<R>> offset;       // of each vehicle from the payload's centre of mass, m
  std::vector<Vec3<R>> cable_force;  // what each cable then asks of its vehicle, N; sums to m_L g
  Vec3<R> below;                     // rho: the payload from the vehicles' plain mean, m

  explicit Formation(std::size_t n) : offset(n), cable_force(n) {}

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"offset", "m", Range::any, "of each vehicle from the payload's centre, at rest"},
      self.offset);
    v(Field{"cable_force", "N", Range::any, "of each cable on its vehicle, at rest, reversed"},
      self.cable_force);
  }

  /// Works out `below` once offsets are known.
  void complete() {
    Vec3<R> sum{};
    for (const Vec3<R>& o : offset) sum += o;
    below = R(-1.0 / static_cast<double>(offset.size())) * sum;
  }
};

/// All of it at one instant.
template <Real R>
struct Target {
  Vec3<R> payload, payload_velocity, payload_acceleration;               // W
  Vec3<R> payload_jerk, payload_snap;                                    // W, m/s^3, m/s^4
  R yaw{0.0}, yaw_rate{0.0}, yaw_acceleration{0.0}, yaw_jerk{0.0};       // rad, ...
  SinCos<R> heading{R(0.0), R(1.0)};                                     // of the yaw
  std::vector<Vec3<R>> vehicle, vehicle_velocity, vehicle_acceleration;  // W
  std::vector<Vec3<R>> cable_force, cable_force_rate;                    // W, N, N/s
  Vec3<R> below, below_rate, below_acceleration;                         // W
  bool moves = true;  // whether any rate above may be other than zero

  explicit Target(std::size_t n)
      : vehicle(n),
        vehicle_velocity(n),
        vehicle_acceleration(n),
        cable_force(n),
        cable_force_rate(n) {}
};

template <Real R>
MULTILIFT_INLINE Vec3<R> turned(const SinCos<R>& heading, const Vec3<R>& v) {
  return {heading.cos * v.x - heading.sin * v.y, heading.sin * v.x + heading.cos * v.y, v.z};
}

/// Where everything shall be, as a function of time.
template <Real R>
class Reference {
 public:
  Reference(const Vec3<R>& goal, const R& goal_yaw, const Path& path, const Formation<R>& formation)
      : goal_(goal), goal_yaw_(goal_yaw), path_(path), formation_(formation) {}

  void at(double time, Target<R>& target) const {
    const R zero(0.0);
    target.moves = !stands();
    std::array<plan::Derivatives, 4> way{};
    if (target.moves) way = path_.at(time);
    const auto derivative = [&](std::size_t order) {
      return Vec3<R>{R(way[0][order]), R(way[1][order]), R(way[2][order])};
    };
    target.payload = goal_ + derivative(0);
    target.payload_velocity = derivative(1);
    target.payload_acceleration = derivative(2);
    target.payload_jerk = derivative(3);
    target.payload_snap = derivative(4);
    target.yaw = goal_yaw_ + R(way[3][0]);
    target.yaw_rate = R(way[3][1]);
    target.yaw_acceleration = R(way[3][2]);
    target.yaw_jerk = R(way[3][3]);
    target.heading = sincos(target.yaw);
    const auto spin = [&](const Vec3<R>& v) { return Vec3<R>{-v.y, v.x, zero}; };
    const R rate_squared = square(target.yaw_rate);
    const auto turning = [&](const Vec3<R>& v) {
      return target.yaw_acceleration * spin(v) - rate_squared * Vec3<R>{v.x, v.y, zero};
    };
    for (std::size_t i = 0; i < formation_.offset.size(); ++i) {
      const Vec3<R> offset = turned(target.heading, formation_.offset[i]);
      target.vehicle[i] = target.payload + offset;
      target.vehicle_velocity[i] = target.payload_velocity + target.yaw_rate * spin(offset);
      target.vehicle_acceleration[i] = target.payload_acceleration + turning(offset);
      target.cable_force[i] = turned(target.heading, formation_.cable_force[i]);
      target.cable_force_rate[i] = target.yaw_rate * spin(target.cable_force[i]);
    }
    target.below = turned(target.heading, formation_.below);
    target.below_rate = target.yaw_rate * spin(target.below);
    target.below_acceleration = turning(target.below);
  }

  /// Whether nothing ever moves.
  bool stands() const { return path_.pieces.empty(); }

 private:
  Vec3<R> goal_;
  R goal_yaw_;
  Path path_;
  Formation<R> formation_;
};

}  // namespace multilift::spatial
