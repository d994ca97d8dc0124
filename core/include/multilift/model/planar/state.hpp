// The state of the planar plant and the geometry that follows from it.
//
// World axes y (right) and z (up). The state is the five coordinates left free once the cables'
// ends are the bar's ends: the bar's centre of mass and the three angles. The paper's seven
// redundant coordinates q = [y1 z1 y2 z2 theta1 theta2 theta3] follow from them, so the closure
// c(q) = 0 cannot drift. Signs are the paper's: a positive theta1 carries the lower end of cable 1
// towards +y, a positive theta2 that of cable 2 towards -y, a positive theta3 lifts the bar's
// end 2.
#pragma once

#include <array>
#include <cstddef>

#include "multilift/math/sincos.hpp"
#include "multilift/math/vec2.hpp"
#include "multilift/model/planar/parameters.hpp"
#include "multilift/scalar/both.hpp"

namespace multilift::planar {

/// Rate of change of a State: velocities and accelerations in the same places.
template <Real R>
struct StateRate {
  Vec2<R> bar_velocity;
  std::array<R, 3> theta_dot;
  Vec2<R> bar_acceleration;
  std::array<R, 3> theta_ddot;

  friend StateRate operator+(const StateRate& a, const StateRate& b) {
    StateRate sum{a.bar_velocity + b.bar_velocity, {}, a.bar_acceleration + b.bar_acceleration, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      sum.theta_dot[k] = a.theta_dot[k] + b.theta_dot[k];
      sum.theta_ddot[k] = a.theta_ddot[k] + b.theta_ddot[k];
    }
    return sum;
  }
  friend StateRate operator*(const R& h, const StateRate& a) {
    StateRate scaled{h * a.bar_velocity, {}, h * a.bar_acceleration, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      scaled.theta_dot[k] = h * a.theta_dot[k];
      scaled.theta_ddot[k] = h * a.theta_ddot[k];
    }
    return scaled;
  }
};

template <Real R>
struct State {
  Vec2<R> bar;                                         // centre of mass, m
  std::array<R, 3> theta{R(0.0), R(0.0), R(0.0)};      // rad
  Vec2<R> bar_velocity;                                // m/s
  std::array<R, 3> theta_dot{R(0.0), R(0.0), R(0.0)};  // rad/s

  /// The state after a time h at the given rate.
  State moved(const StateRate<R>& rate, const R& h) const {
    State next{bar + h * rate.bar_velocity, theta, bar_velocity + h * rate.bar_acceleration,
               theta_dot};
    for (std::size_t k = 0; k < 3; ++k) {
      next.theta[k] = theta[k] + h * rate.theta_dot[k];
      next.theta_dot[k] = theta_dot[k] + h * rate.theta_ddot[k];
    }
    return next;
  }

  /// [bar y, bar z, theta1..3] and their rates, as results carry them.
  std::array<R, 10> flat() const {
    return {bar.y,          bar.z,          theta[0],     theta[1],     theta[2],
            bar_velocity.y, bar_velocity.z, theta_dot[0], theta_dot[1], theta_dot[2]};
  }

  /// World k's state on its own.
  State<lane_scalar_t<R>> world(int k) const {
    State<lane_scalar_t<R>> one{{lane(bar.y, k), lane(bar.z, k)},
                                {},
                                {lane(bar_velocity.y, k), lane(bar_velocity.z, k)},
                                {}};
    for (std::size_t i = 0; i < 3; ++i) {
      one.theta[i] = lane(theta[i], k);
      one.theta_dot[i] = lane(theta_dot[i], k);
    }
    return one;
  }
};

/// World by world one of two states.
template <Real R>
MULTILIFT_INLINE State<R> select_state(const mask_t<R>& mask, const State<R>& a,
                                       const State<R>& b) {
  State<R> chosen{{select(mask, a.bar.y, b.bar.y), select(mask, a.bar.z, b.bar.z)},
                  {},
                  {select(mask, a.bar_velocity.y, b.bar_velocity.y),
                   select(mask, a.bar_velocity.z, b.bar_velocity.z)},
                  {}};
  for (std::size_t k = 0; k < 3; ++k) {
    chosen.theta[k] = select(mask, a.theta[k], b.theta[k]);
    chosen.theta_dot[k] = select(mask, a.theta_dot[k], b.theta_dot[k]);
  }
  return chosen;
}

/// Positions, velocities and directions that the equations share at one state.
template <Real R>
struct Pose {
  std::array<SinCos<R>, 3> angle;
  // Of each cable: the unit vector from the bar's end to the vehicle, the motion of the bar's end
  // per cable length and unit of theta, and the arm from the bar's centre of mass to its end, m.
  std::array<Vec2<R>, 2> direction;
  std::array<Vec2<R>, 2> tangent;
  std::array<Vec2<R>, 2> arm;
  std::array<Vec2<R>, 2> vehicle;           // xi_1, xi_2, m
  std::array<Vec2<R>, 2> vehicle_velocity;  // m/s
};

template <Real R>
MULTILIFT_INLINE Pose<R> pose_of(const Plant<R>& p, const State<R>& state) {
  auto [s3, c3] = sincos(state.theta[2]);
  Vec2<R> along_bar = p.half_bar_length * Vec2<R>{c3, s3};
  Vec2<R> up_to_line = p.bar_half_thickness * Vec2<R>{-s3, c3};

  using B = Both<R>;
  auto [s, c] = sincos(both(state.theta[0], state.theta[1]));
  // Both cables' turning, counted from y towards z.
  B spin = alternate(both(state.theta_dot[0], state.theta_dot[1]));
  Vec2<B> direction{-alternate(s), c}, tangent{alternate(c), s};
  Vec2<B> arm{both(up_to_line.y - along_bar.y, up_to_line.y + along_bar.y),
              both(up_to_line.z - along_bar.z, up_to_line.z + along_bar.z)};
  Vec2<B> cable = both(p.cable_length) * direction;
  Vec2<B> vehicle = both(state.bar) + arm + cable;
  Vec2<B> vehicle_velocity = both(state.bar_velocity) +
                             both(state.theta_dot[2]) * perpendicular(arm) +
                             spin * perpendicular(cable);
  return {{SinCos<R>{s[0], c[0]}, SinCos<R>{s[1], c[1]}, SinCos<R>{s3, c3}},
          each<R>(direction),
          each<R>(tangent),
          each<R>(arm),
          each<R>(vehicle),
          each<R>(vehicle_velocity)};
}

/// The paper's seven redundant coordinates, or their rates: [y1 z1 y2 z2 theta1 theta2 theta3].
template <Real R>
using Seven = std::array<R, 7>;

template <Real R>
Seven<R> join_seven(const std::array<Vec2<R>, 2>& vehicle, const std::array<R, 3>& theta) {
  return {vehicle[0].y, vehicle[0].z, vehicle[1].y, vehicle[1].z, theta[0], theta[1], theta[2]};
}

/// What the closure leaves open at q, m: the bar as the cables' ends place it, less the bar itself.
template <Real R>
Vec2<R> closure(const Plant<R>& p, const Seven<R>& q) {
  const auto [s1, c1] = sincos(q[4]);
  const auto [s2, c2] = sincos(q[5]);
  const auto [s3, c3] = sincos(q[6]);
  const R l1 = p.cable_length[0], l2 = p.cable_length[1];
  return {q[2] - l2 * s2 - q[0] - l1 * s1 - p.bar_length * c3,
          q[3] - l2 * c2 - q[1] + l1 * c1 - p.bar_length * s3};
}

/// The state whose seven coordinates are q and rates q_dot, both taken to satisfy the closure.
template <Real R>
State<R> state_from_seven(const Plant<R>& p, const Seven<R>& q, const Seven<R>& q_dot) {
  State<R> relative;  // the same angles with the bar at the origin
  for (std::size_t k = 0; k < 3; ++k) {
    relative.theta[k] = q[4 + k];
    relative.theta_dot[k] = q_dot[4 + k];
  }
  const Pose<R> pose = pose_of(p, relative);
  State<R> state = relative;
  const R half(0.5);
  state.bar = half * (Vec2<R>{q[0], q[1]} + Vec2<R>{q[2], q[3]}) -
              half * (pose.vehicle[0] + pose.vehicle[1]);
  state.bar_velocity = half * (Vec2<R>{q_dot[0], q_dot[1]} + Vec2<R>{q_dot[2], q_dot[3]}) -
                       half * (pose.vehicle_velocity[0] + pose.vehicle_velocity[1]);
  return state;
}

}  // namespace multilift::planar
