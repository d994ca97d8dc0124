// The load below vehicles that take a given way, as a pendulum: the way that the load then takes.
//
// With d the unit vector from load to vehicles and x their way,
//
//     d_ddot = (x_ddot + g e_z - r d) / l - c d_dot,   r = d . (x_ddot + g e_z) + l |d_dot|^2
//
// and the load's place is x - l d. The last coordinate is up.
//
// Where vehicles add -kappa times the horizontal part of d_dot to a positioning acceleration, the
// load's energy 1/2 l |d_dot|^2 + g (1 - d_z) changes by d_dot . positioning - kappa |part|^2: the
// second part takes swing away at all times, and its own integral, -kappa times how far d leans,
// vanishes with the swing. This is planning in two parts, positioning and antiswing, as cranes use
// it; nothing is iterated but the swing's own equation.
#pragma once

#include "multilift/plan/move.hpp"
#include "multilift/plan/shaper.hpp"

namespace multilift::plan {

/// What hangs below the vehicles.
struct Pendulum {
  double length;        // m
  double gravity;       // m/s^2
  double damping{0.0};  // c, of the swing's rate, 1/s
};

/// A load's lean and its rate: the unit vector towards the vehicles.
template <std::size_t D>
struct Lean {
  std::array<double, D> d{}, d_dot{};

  static Lean hanging() {
    Lean lean;
    lean.d[D - 1] = 1.0;
    return lean;
  }
};

namespace detail {

/// Time from knot to knot of what is integrated, s.
inline constexpr double knot = 0.04;

template <std::size_t D>
double dot(const std::array<double, D>& a, const std::array<double, D>& b) {
  double sum = 0.0;
  for (std::size_t c = 0; c < D; ++c) sum += a[c] * b[c];
  return sum;
}

/// Vehicles and lean together: x from the positioning way by -kappa integral of d's lean.
template <std::size_t D>
struct Swaying {
  std::array<double, D> offset{};  // of x from the positioning way
  Lean<D> lean;
};

/// All that the load's derivatives up to jerk need.
template <std::size_t D>
struct Rates {
  Motion<D> vehicle;  // up to jerk
  std::array<double, D> d_ddot, d_third;
};

template <std::size_t D>
Rates<D> rates(const Pendulum& pendulum, double kappa, const Motion<D>& way, const Swaying<D>& at) {
  const auto& [d, d_dot] = at.lean;
  const double l = pendulum.length;
  Rates<D> result;
  const auto part = [](std::size_t c) { return c + 1 < D ? 1.0 : 0.0; };
  std::array<double, D> pull, pull_rate;
  for (std::size_t c = 0; c < D; ++c) {
    auto& x = result.vehicle[c];
    x[0] = way[c][0] + at.offset[c];
    x[1] = way[c][1] - kappa * part(c) * d[c];
    x[2] = way[c][2] - kappa * part(c) * d_dot[c];
    pull[c] = x[2] + (1.0 - part(c)) * pendulum.gravity;
  }
  const double r = dot(d, pull) + l * dot(d_dot, d_dot);
  for (std::size_t c = 0; c < D; ++c)
    result.d_ddot[c] = (pull[c] - r * d[c]) / l - pendulum.damping * d_dot[c];
  for (std::size_t c = 0; c < D; ++c) {
    auto& x = result.vehicle[c];
    x[3] = way[c][3] - kappa * part(c) * result.d_ddot[c];
    x[4] = 0.0;
    pull_rate[c] = x[3];
  }
  const double r_dot = dot(d_dot, pull) + dot(d, pull_rate) + 2.0 * l * dot(d_dot, result.d_ddot);
  for (std::size_t c = 0; c < D; ++c)
    result.d_third[c] =
        (pull_rate[c] - r_dot * d[c] - r * d_dot[c]) / l - pendulum.damping * result.d_ddot[c];
  return result;
}

/// One Runge-Kutta step of order 4; `way_at` gives the positioning way.
template <std::size_t D, class WayAt>
Swaying<D> sway(const Pendulum& pendulum, double kappa, const Swaying<D>& from, double time,
                double h, WayAt&& way_at) {
  struct Slope {
    std::array<double, D> offset, d, d_dot;
  };
  const auto slope = [&](const Motion<D>& way, const Swaying<D>& at) {
    Slope k;
    k.d = at.lean.d_dot;
    k.d_dot = rates<D>(pendulum, kappa, way, at).d_ddot;
    for (std::size_t c = 0; c < D; ++c) k.offset[c] = c + 1 < D ? -kappa * at.lean.d[c] : 0.0;
    return k;
  };
  const auto moved = [&](const Slope& k, double by) {
    Swaying<D> next = from;
    for (std::size_t c = 0; c < D; ++c) {
      next.offset[c] += by * k.offset[c];
      next.lean.d[c] += by * k.d[c];
      next.lean.d_dot[c] += by * k.d_dot[c];
    }
    return next;
  };
  const Motion<D> middle = way_at(time + 0.5 * h);
  const Slope a = slope(way_at(time), from);
  const Slope b = slope(middle, moved(a, 0.5 * h));
  const Slope e = slope(middle, moved(b, 0.5 * h));
  const Slope f = slope(way_at(time + h), moved(e, h));
  Swaying<D> next = from;
  for (std::size_t c = 0; c < D; ++c) {
    const auto mean = [&](auto member) {
      return h / 6.0 * (member(a) + 2.0 * (member(b) + member(e)) + member(f));
    };
    next.offset[c] += mean([&](const Slope& k) { return k.offset[c]; });
    next.lean.d[c] += mean([&](const Slope& k) { return k.d[c]; });
    next.lean.d_dot[c] += mean([&](const Slope& k) { return k.d_dot[c]; });
  }
  // The unit vector stays one.
  const double size = norm(next.lean.d);
  for (double& x : next.lean.d) x /= size;
  return next;
}

/// The load's place and derivatives up to jerk, below the vehicles' height less the cable's length.
template <std::size_t D>
Motion<D> load_of(const Pendulum& pendulum, const Rates<D>& now, const Lean<D>& lean) {
  Motion<D> load;
  for (std::size_t c = 0; c < D; ++c) {
    const double l = pendulum.length, up = c + 1 < D ? 0.0 : 1.0;
    const Derivatives& x = now.vehicle[c];
    load[c] = {x[0] - l * (lean.d[c] - up), x[1] - l * lean.d_dot[c], x[2] - l * now.d_ddot[c],
               x[3] - l * now.d_third[c], 0.0};
  }
  return load;
}

}  // namespace detail

/// Whose way a plan gives.
enum class Follow { load, vehicles };

/// The way of load or vehicles while the vehicles' positioning is `way_at` up to a time, from a
/// lean; `peaks` gathers the vehicles' greatest speed, acceleration and jerk at the knots, and
/// `lean` becomes the last one.
template <std::size_t D, class WayAt>
Path<D> swayed(const Pendulum& pendulum, double kappa, Lean<D>& lean, double duration,
               Follow follow, std::array<double, 3>& peaks, WayAt&& way_at) {
  Path<D> path;
  const auto knots = static_cast<std::size_t>(std::ceil(duration / detail::knot));
  const double h = duration / static_cast<double>(knots);
  detail::Swaying<D> state{{}, lean};
  Motion<D> before{};
  for (std::size_t k = 0; k <= knots; ++k) {
    const double time = h * static_cast<double>(k);
    const auto now = detail::rates<D>(pendulum, kappa, way_at(time), state);
    for (std::size_t order = 1; order <= peaks.size(); ++order) {
      double square = 0.0;
      for (const Derivatives& x : now.vehicle) square += x[order] * x[order];
      peaks[order - 1] = std::max(peaks[order - 1], std::sqrt(square));
    }
    const Motion<D> here =
        follow == Follow::load ? detail::load_of<D>(pendulum, now, state.lean) : now.vehicle;
    if (k > 0) {
      Piece<D> piece{time - h, {}};
      for (std::size_t c = 0; c < D; ++c)
        piece.coordinate[c] = in_time(join<4>(before[c], here[c], h), h);
      path.pieces.push_back(piece);
    }
    before = here;
    if (k < knots) state = detail::sway<D>(pendulum, kappa, state, time, h, way_at);
  }
  path.end = duration;
  lean = state.lean;
  return path;
}

}  // namespace multilift::plan
