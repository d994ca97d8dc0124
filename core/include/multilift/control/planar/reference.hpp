// Where vehicles and load shall be while the bar's centre of mass takes a given way.
//
// The bar's place is a flat output: with the bar level and both cables parallel, its acceleration
// says how the cables lean, and with jerk and snap how fast they turn. Vehicles' positions and the
// forces that this takes follow without solving a differential equation:
//
//     n = p_ddot + g e_z,   d = n / |n|,   xi_i = p + a_i + l_i d
//     T_i = m3 |n| (1/2 -+ l3 n_y / (l0 n_z)),   u_i = m_i xi_i_ddot + T_i d - 1/2 m3 g e_z
//
// The two tensions differ by the moment that the bar's low centre of mass asks for. Air and swing
// damping are left to the feedback.
#pragma once

#include "multilift/model/planar/energy.hpp"
#include "multilift/plan/path.hpp"

namespace multilift::planar {

/// The bar's way relative to where it hangs at the goal, m.
using Path = plan::Path<2>;

/// How far a law's view of a reference is off the present, s.
struct Ages {
  double lead{0.0};      // of the forces that the way takes
  double measured{0.0};  // of what it measures
};

template <Real R>
class Reference {
 public:
  /// `assumed` is the plant as whoever plans believes it to be; `path` has at least one piece.
  Reference(const Plant<R>& assumed, const std::array<Vec2<R>, 2>& goal, const Path& path,
            const Ages& ages)
      : assumed_(assumed), goal_(goal), path_(path), ages_(ages) {}

  /// What a law is given: forces ahead of time, for actuators that lag, and places as old as what
  /// it measures.
  void for_law(double time, Target<R>& target) const {
    at(time + ages_.lead, target);
    const auto ahead = target.feedforward;
    at(time - ages_.measured, target);
    target.feedforward = ahead;
  }

  MULTILIFT_NOINLINE void at(double time, Target<R>& target) const {
    const auto way = path_.at(time);
    const auto derivative = [&](std::size_t k) { return Vec2<R>{R(way[0][k]), R(way[1][k])}; };
    const Plant<R>& p = assumed_;
    const R one(1.0), two(2.0), half(0.5);
    const Vec2<R> up{R(0.0), one};
    const Vec2<R> velocity = derivative(1), acceleration = derivative(2), jerk = derivative(3);
    const Vec2<R> n = acceleration + p.gravity * up;
    const R size = sqrt(dot(n, n));
    const R inverse = one / size;
    // Divided, not scaled: straight up is exactly that, and a target at rest is the goal to the
    // last bit.
    const Vec2<R> d{n.y / size, n.z / size};
    const R growth = dot(d, jerk);  // of |n|
    const Vec2<R> d_dot = inverse * (jerk - growth * d);
    const Vec2<R> snap = derivative(4);
    const Vec2<R> d_ddot =
        inverse * (snap - dot(d, snap) * d - two * growth * d_dot) - dot(d_dot, d_dot) * d;
    const R aside = p.bar_half_thickness * n.y / (p.bar_length * n.z);
    for (std::size_t i = 0; i < 2; ++i) {
      const R& length = p.cable_length[i];
      const R share = i == 0 ? half - aside : half + aside;
      target.vehicle[i] = goal_[i] + derivative(0) + length * (d - up);
      target.vehicle_velocity[i] = velocity + length * d_dot;
      target.feedforward[i] = p.vehicle_mass[i] * (acceleration + length * d_ddot) +
                              (share * p.bar_mass) * n - p.half_bar_weight * up;
    }
    const R both_lengths = p.cable_length[0] + p.cable_length[1];
    target.swing = {both_lengths * Vec2<R>{-d.y, one - d.z}, -both_lengths * d_dot};
  }

 private:
  Plant<R> assumed_;
  std::array<Vec2<R>, 2> goal_;
  Path path_;
  Ages ages_;
};

}  // namespace multilift::planar
