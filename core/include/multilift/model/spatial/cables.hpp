// The cables: how they lie, what they pull, and what they do when they are jerked taut.
//
// A taut rigid cable keeps its length, so its tension is affine in the payload's acceleration.
// Inserted into the payload's Newton and Euler equations, one symmetric positive definite 6x6
// system remains, assembled by one pass over the cables, whatever their number. The same system
// gives the impulses of cables that are pulled taut. A slack cable leaves the sums.
#pragma once

#include "multilift/math/spd6.hpp"
#include "multilift/model/spatial/parameters.hpp"
#include "multilift/model/spatial/state.hpp"

namespace multilift::spatial {

/// How fast the equations draw a rigid cable's length back to its rest length, 1/s: what round-off
/// and step error let drift dies away at this rate, critically damped.
inline constexpr double length_correction = 40.0;

/// One cable at one instant.
template <Real R>
struct Cable {
  Vec3<R> direction;  // d: unit vector from the payload's attachment to the vehicle, W
  Vec3<R> moment;     // r x d in L: the torque on the payload per tension, m
  R length;           // m
  R stretch_rate;     // d/dt length, m/s
  R bend;             // what the length's second rate has besides accelerations, m/s^2
};

/// Of every vehicle what concerns its cable; `turn` is the payload's attitude.
template <Real R>
MULTILIFT_INLINE Cable<R> cable_at(const Vec3<R>& attachment, const RigidBody<R>& payload,
                                   const Rotation<R>& turn, const Vec3<R>& vehicle_position,
                                   const Vec3<R>& vehicle_velocity) {
  const Vec3<R> along = vehicle_position - payload.position - turn.to_world(attachment);
  const Vec3<R> arm_rate = cross(payload.rate, attachment);  // L
  const Vec3<R> apart = vehicle_velocity - payload.velocity - turn.to_world(arm_rate);
  const R squared = dot(along, along);
  const R inverse = R(1.0) / sqrt(squared);
  const R length = squared * inverse;
  const Vec3<R> d = inverse * along;
  const Vec3<R> d_L = turn.to_body(d);
  const R stretch_rate = dot(d, apart);
  const R centripetal = (dot(apart, apart) - stretch_rate * stretch_rate) * inverse;
  return {d, cross(attachment, d_L), length, stretch_rate,
          centripetal - dot(d_L, cross(payload.rate, arm_rate))};
}

/// What acts on the bodies besides the cables: gravity, rotors, drag, ground, pushes.
template <Real R>
struct Loads {
  std::vector<Vec3<R>> vehicle;  // W, N
  Vec3<R> payload;               // W, N
  Vec3<R> payload_torque;        // L, N m

  explicit Loads(std::size_t n) : vehicle(n) {}
};

template <Real R>
struct Motion {
  Vec3<R> payload_acceleration;          // W, m/s^2
  Vec3<R> payload_angular_acceleration;  // L, rad/s^2
  std::vector<R> tension;                // N

  explicit Motion(std::size_t n) : tension(n) {}
};

/// Payload accelerations (or velocity jumps) and tensions (or impulses) from those that would be
/// there if the payload stayed as it is: T_i = pull_i - m_i (d_i . first + moment_i . second).
/// `pull` becomes the tensions; cables outside `taut` have none.
template <Real R>
MULTILIFT_INLINE Pair6<R> solve_cables(const Plant<R>& p, const std::vector<Cable<R>>& cables,
                                       const Masks<R>& taut, Vec3<R> force, Vec3<R> torque,
                                       std::vector<R>& pull) {
  const R zero(0.0);
  Symmetric6<R> m;
  m.a.xx = m.a.yy = m.a.zz = p.payload_mass;
  m.c.xx = p.turning_inertia.x;
  m.c.yy = p.turning_inertia.y;
  m.c.zz = p.turning_inertia.z;
  for (std::size_t i = 0; i < cables.size(); ++i) {
    const auto& [d, moment, length, rate, bend] = cables[i];
    const R mass = select(taut[i].is, p.vehicle_mass[i], zero);
    pull[i] = select(taut[i].is, pull[i], zero);
    m.a.add_outer(mass, d);
    m.b.add_outer(mass, d, moment);
    m.c.add_outer(mass, moment);
    force += pull[i] * d;
    torque += pull[i] * moment;
  }
  const Pair6<R> x = solve_spd(m, force, torque);
  for (std::size_t i = 0; i < cables.size(); ++i) {
    const R mass = select(taut[i].is, p.vehicle_mass[i], zero);
    pull[i] -= mass * (dot(cables[i].direction, x.first) + dot(cables[i].moment, x.second));
  }
  return x;
}

/// The torque that keeps a free body turning as it does, in its frame: -omega x J omega.
template <Real R>
MULTILIFT_INLINE Vec3<R> gyroscopic_torque(const Vec3<R>& inertia, const Vec3<R>& rate) {
  return -cross(rate, scale(inertia, rate));
}

/// Cables that keep their length while taut. Tensions may come out negative: cables only pull, and
/// who calls lets those go.
template <Real R>
struct RigidCables {
  static constexpr bool rigid = true;

  MULTILIFT_INLINE static void motion(const Plant<R>& p, const RigidBody<R>& payload,
                                      const std::vector<Cable<R>>& cables, const Loads<R>& loads,
                                      const Masks<R>& taut, Motion<R>& result) {
    const R beta(length_correction);
    for (std::size_t i = 0; i < cables.size(); ++i) {
      const Cable<R>& c = cables[i];
      const R correction = beta * (R(2.0) * c.stretch_rate + beta * (c.length - p.cable_length[i]));
      result.tension[i] =
          dot(c.direction, loads.vehicle[i]) + p.vehicle_mass[i] * (c.bend + correction);
    }
    const auto [a, alpha] = solve_cables(
        p, cables, taut, loads.payload,
        loads.payload_torque + gyroscopic_torque(p.payload_inertia, payload.rate), result.tension);
    result.payload_acceleration = a;
    result.payload_angular_acceleration = select<R>(p.turns, alpha, {});
  }
};

/// Kelvin-Voigt cables: spring and damper side by side, and no force where that would push.
template <Real R>
struct ElasticCables {
  static constexpr bool rigid = false;

  MULTILIFT_INLINE static void motion(const Plant<R>& p, const RigidBody<R>& payload,
                                      const std::vector<Cable<R>>& cables, const Loads<R>& loads,
                                      const Masks<R>& whole, Motion<R>& result) {
    const R zero(0.0);
    Vec3<R> force = loads.payload;
    Vec3<R> torque = loads.payload_torque + gyroscopic_torque(p.payload_inertia, payload.rate);
    for (std::size_t i = 0; i < cables.size(); ++i) {
      const Cable<R>& c = cables[i];
      const R stretch = c.length - p.cable_length[i];
      const R pull = p.cable_stiffness[i] * stretch + p.cable_damping[i] * c.stretch_rate;
      const R tension = select(whole[i].is & (zero < stretch), max(pull, zero), zero);
      result.tension[i] = tension;
      force += tension * c.direction;
      torque += tension * c.moment;
    }
    result.payload_acceleration = p.inverse_payload_mass * force;
    const Vec3<R>& j = p.turning_inertia;
    result.payload_angular_acceleration =
        select<R>(p.turns, {torque.x / j.x, torque.y / j.y, torque.z / j.z}, {});
  }
};

}  // namespace multilift::spatial
