// Moves of vehicles with a swinging load below, planned in one go: shaped, or in two parts.
#pragma once

#include "multilift/plan/sway.hpp"

namespace multilift::plan {

/// Joins the end of a path smoothly to its goal, in half a swing.
template <std::size_t D>
void come_to_rest(Path<D>& path, const Goal<D>& goal, const Pendulum& pendulum) {
  const double duration = std::numbers::pi * std::sqrt(pendulum.length / pendulum.gravity);
  Goal<D> later = goal;
  for (std::size_t c = 0; c < D; ++c) later.position[c] += path.end * goal.velocity[c];
  Path<D> ending = timed_move<D>(path.at(std::nextafter(path.end, 0.0)), later, duration);
  for (Piece<D>& piece : ending.pieces) {
    piece.start += path.end;
    path.pieces.push_back(piece);
  }
  path.end += ending.end;
}

/// A move from rest to rest, split by a shaper. The vehicles keep to the limits, since the copies'
/// weights add up to one.
template <std::size_t D>
Path<D> shaped_move(const std::array<double, D>& from, const std::array<double, D>& to,
                    const Limits& limits, const std::vector<Impulse>& impulses,
                    const Pendulum& pendulum, Follow follow) {
  Motion<D> start{};
  for (std::size_t c = 0; c < D; ++c) start[c][0] = from[c];
  const Path<D> way = fastest_move<D>(start, {to, {}}, limits);
  Lean<D> lean = Lean<D>::hanging();
  std::array<double, 3> peaks{};
  Path<D> path = swayed<D>(pendulum, 0.0, lean, way.end + impulses.back().time, follow, peaks,
                           [&](double time) { return shaped<D>(impulses, way, time); });
  // The swing that is left, of higher order in the move's size, is brought to rest.
  come_to_rest<D>(path, {to, {}}, pendulum);
  return path;
}

/// A vehicle's place and velocity and how the load below it swings.
template <std::size_t D>
struct Carried {
  std::array<double, D> position, velocity;
  Lean<D> lean;
};

/// A move in two parts from any state of swing: the vehicles' acceleration is that of a polynomial
/// move plus the part that takes swing away, by `ratio` of the critical damping. Where both
/// together exceed the vehicles' limits (of speed, acceleration and jerk), the polynomial move is
/// made slower, a few times at most. Empty where the swing alone exceeds them.
template <std::size_t D>
Path<D> antiswing_move(const Carried<D>& from, const Goal<D>& goal, const Limits& limits,
                       double ratio, const Pendulum& pendulum, Follow follow) {
  constexpr int passes = 6;
  constexpr double left_over = 0.005;  // of the swing when the plan's last piece takes over
  const double frequency = std::sqrt(pendulum.gravity / pendulum.length);
  const double kappa = 2.0 * ratio * frequency * pendulum.length;
  const double settling = -std::log(left_over) / (ratio * frequency);
  Motion<D> start{};
  for (std::size_t c = 0; c < D; ++c)
    start[c] = {from.position[c], from.velocity[c] + (c + 1 < D ? kappa * from.lean.d[c] : 0.0),
                0.0, 0.0, 0.0};
  Limits within = limits;
  for (int pass = 0; pass < passes; ++pass) {
    const Path<D> way = fastest_move(start, goal, within);
    if (way.pieces.empty()) return {};
    const double arrival = std::isfinite(way.end) ? way.end : way.pieces.back().start;
    std::array<double, 3> peaks{};
    Lean<D> lean = from.lean;
    Path<D> path = swayed<D>(pendulum, kappa, lean, arrival + settling, follow, peaks,
                             [&](double time) { return way.at(time); });
    double slower = 1.0;
    for (std::size_t k = 0; k < peaks.size(); ++k)
      slower = std::max(slower, std::pow(peaks[k] / limits[k], 1.0 / static_cast<double>(k + 1)));
    if (slower > 1.0 + 1e-6) {
      slower *= 1.02;
      double factor = 1.0;
      for (double& limit : within) limit /= factor *= slower;
      continue;
    }
    come_to_rest(path, goal, pendulum);
    return path;
  }
  return {};
}

}  // namespace multilift::plan
