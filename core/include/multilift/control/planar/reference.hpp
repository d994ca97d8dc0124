// Where vehicles and load shall be while the bar's centre of mass takes a given way.
//
// The bar's place is a flat output: with the bar level and both cables parallel, its acceleration
// says how the cables lean, and with jerk and snap how fast they turn. Vehicles' positions and the
// forces that this takes follow without solving a differential equation:
//
//     n = p_ddot + g e_z,   d = n / |n|,   xi_i = p + a_i + l_i d
//     T_i = m3 |n| (1/2 -+ l3 n_y / (l0 n_z)),   u_i = m_i xi_i_ddot + T_i d - 1/2 m3 g e_z
//
// The two tensions differ by the moment that the bar's low centre of mass asks for.
//
// Where damping is counted, a turning cable pushes on the bar across itself, by c_i = d_theta_i/l_i
// times its direction's rate. The cables then follow n like a lag of first order,
//
//     d_dot = (n - (d . n) d) / (eps |n|),   eps = (c_1 + c_2) / (m3 |n|)
//
// of some milliseconds. Its solution is expanded to first order, d along n - eps n_dot, which takes
// one more derivative of the way; what is left is of the order of eps^2. Without damping all of it
// is left to the feedback.
#pragma once

#include "multilift/model/planar/energy.hpp"
#include "multilift/plan/path.hpp"

namespace multilift::planar {

/// The bar's way relative to where it hangs at the goal, m.
using Path = plan::Path<2>;

/// How a law looks at a reference.
struct View {
  double lead{0.0};      // how far ahead it sees the forces that the way takes, s
  double measured{0.0};  // how old what it measures is, s
  bool damping{false};   // whether the way counts drag and swing damping
};

template <Real R>
class Reference {
 public:
  /// `assumed` is the plant as whoever plans believes it to be; `path` has at least one piece.
  Reference(const Plant<R>& assumed, const std::array<Vec2<R>, 2>& goal, const Path& path,
            const View& view)
      : assumed_(assumed), goal_(goal), path_(path), view_(view) {}

  /// What a law is given: forces ahead of time, for actuators that lag, and places as old as what
  /// it measures.
  void for_law(double time, Target<R>& target) const {
    at(time + view_.lead, target);
    const auto ahead = target.feedforward;
    at(time - view_.measured, target);
    target.feedforward = ahead;
  }

  MULTILIFT_NOINLINE void at(double time, Target<R>& target) const {
    if (view_.damping)
      fill<true>(path_.at<6>(time), target);
    else
      fill<false>(path_.at(time), target);
  }

 private:
  /// A vector and its first two time derivatives.
  struct Moving {
    Vec2<R> value, rate, second;
  };

  /// n - eps n_dot, with eps falling as |n| grows.
  Moving lagging(const Moving& n, const Vec2<R>& third) const {
    const Plant<R>& p = assumed_;
    const R size = sqrt(dot(n.value, n.value));
    const R growth = dot(n.value, n.rate) / (size * size);  // of |n|, per |n|
    const R bend = (dot(n.rate, n.rate) + dot(n.value, n.second)) / (size * size) - growth * growth;
    const R eps = (p.couple_rate[0] + p.couple_rate[1]) * p.inverse_bar_mass / size;
    const R eps_rate = -eps * growth;
    const R eps_second = eps * (R(2.0) * growth * growth - bend);
    return {n.value - eps * n.rate, n.rate - eps * n.second - eps_rate * n.rate,
            n.second - eps * third - R(2.0) * eps_rate * n.second - eps_second * n.rate};
  }

  template <bool damping, std::size_t N>
  void fill(const std::array<std::array<double, N>, 2>& way, Target<R>& target) const {
    const auto derivative = [&](std::size_t k) { return Vec2<R>{R(way[0][k]), R(way[1][k])}; };
    const Plant<R>& p = assumed_;
    const R one(1.0), two(2.0), half(0.5);
    const Vec2<R> up{R(0.0), one};
    const Vec2<R> velocity = derivative(1), acceleration = derivative(2);
    const Vec2<R> n = acceleration + p.gravity * up;
    Moving along{n, derivative(3), derivative(4)};
    if constexpr (damping) along = lagging(along, derivative(5));
    const auto& [cable, jerk, snap] = along;
    const R size = sqrt(dot(cable, cable));
    const R inverse = one / size;
    // Divided, not scaled: straight up is exactly that, and a target at rest is the goal to the
    // last bit.
    const Vec2<R> d{cable.y / size, cable.z / size};
    const R growth = dot(d, jerk);  // of |cable|
    const Vec2<R> d_dot = inverse * (jerk - growth * d);
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
      if constexpr (damping) {
        // What the bar's moment asks of this cable upwards, along the cable and across it.
        const R rise = share * p.bar_mass * n.z - p.couple_rate[i] * d_dot.z;
        const Vec2<R> pull = (rise / d.z) * d + p.couple_rate[i] * d_dot;
        target.feedforward[i] +=
            pull - (share * p.bar_mass) * n + scale(p.vehicle_drag[i], target.vehicle_velocity[i]);
      }
    }
    const R both_lengths = p.cable_length[0] + p.cable_length[1];
    target.swing = {both_lengths * Vec2<R>{-d.y, one - d.z}, -both_lengths * d_dot};
  }

  Plant<R> assumed_;
  std::array<Vec2<R>, 2> goal_;
  Path path_;
  View view_;
};

}  // namespace multilift::planar
