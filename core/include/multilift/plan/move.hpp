// The shortest polynomial move to a goal, at rest or moving evenly, within limits.
//
// Four derivatives match at both ends, so that vehicles that carry the moved load start and stop
// without a jump of their acceleration. From rest to rest the duration has a closed form. From any
// other state one piece is tried over a fixed series of durations; where none keeps to the limits,
// the move first comes to rest, wherever that is, and goes on from there.
#pragma once

#include <algorithm>
#include <numbers>
#include <optional>

#include "multilift/plan/limits.hpp"

namespace multilift::plan {

/// Where to come to rest, or what to catch up with.
template <std::size_t D>
struct Goal {
  std::array<double, D> position;    // now, m
  std::array<double, D> velocity{};  // m/s

  Motion<D> at(double time) const {
    Motion<D> motion{};
    for (std::size_t c = 0; c < D; ++c)
      motion[c] = {position[c] + time * velocity[c], velocity[c], 0.0, 0.0, 0.0};
    return motion;
  }
};

/// Greatest derivatives, orders 1 to 4, of the move from 0 to 1 in unit time, at rest at both ends:
/// s^5 (126 - 420 s + 540 s^2 - 315 s^3 + 70 s^4). With w = s (1 - s) its rate is 630 w^4, and the
/// extremes lie at roots of quadratics: 315/128, 2520 (3/14)^3 / sqrt 7, 315/4 and, at
/// (1 - 2 s)^2 = (15 - 2 sqrt 30) / 35, the last one.
inline constexpr std::array<double, 4> rest_to_rest_peak = {2.4609375, 9.3719763, 78.75,
                                                            622.5327356};

/// The same of the move with the least greatest snap: its sign changes at the extremes of the
/// Chebyshev polynomial of order 4, at (1 - cos(k pi / 4)) / 2, its size is 384.
inline constexpr std::array<double, 4> least_snap_peak = {2.3431457506, 8.2354980119, 79.5290039757,
                                                          384.0};

/// The shortest time from rest to rest over a distance, s, for a move with these greatest
/// derivatives.
inline double rest_to_rest_duration(double distance, const Limits& limits,
                                    const std::array<double, 4>& peaks = rest_to_rest_peak) {
  double duration = 0.0;
  for (std::size_t k = 0; k < limits.size(); ++k)
    duration = std::max(
        duration, std::pow(peaks[k] * distance / limits[k], 1.0 / static_cast<double>(k + 1)));
  return duration;
}

/// A move from rest to rest with the least greatest snap there is in a given time.
template <std::size_t D>
Path<D> least_snap_move(const std::array<double, D>& from, const std::array<double, D>& to,
                        double duration) {
  Path<D> path;
  std::array<double, 4> unit{};  // of the move from 0 to 1 in unit time: place to jerk
  double before = 0.0, snap = least_snap_peak[3];
  for (int k = 1; k <= 4; ++k, snap = -snap) {
    const double until = 0.5 * (1.0 - std::cos(0.25 * std::numbers::pi * k)), h = until - before;
    const Polynomial way{unit[0], unit[1], unit[2] / 2.0, unit[3] / 6.0, snap / 24.0};
    Piece<D> piece{before * duration, {}};
    for (std::size_t c = 0; c < D; ++c) {
      piece.coordinate[c] = in_time(way, duration);
      for (double& x : piece.coordinate[c]) x *= to[c] - from[c];
      piece.coordinate[c][0] += from[c];
    }
    path.pieces.push_back(piece);
    const Derivatives then = evaluate(way, h);
    std::copy(then.begin(), then.begin() + 4, unit.begin());
    before = until;
  }
  path.end = duration;
  return path;
}

namespace detail {

template <std::size_t D>
double norm(const std::array<double, D>& x) {
  double square = 0.0;
  for (double each : x) square += each * each;
  return std::sqrt(square);
}

template <std::size_t D>
std::array<double, D> difference(const Motion<D>& a, const Motion<D>& b, std::size_t order) {
  std::array<double, D> x;
  for (std::size_t c = 0; c < D; ++c) x[c] = a[c][order] - b[c][order];
  return x;
}

template <std::size_t D>
Coordinates<D> join_all(const Motion<D>& from, const Motion<D>& to, double duration,
                        bool free_end) {
  Coordinates<D> way;
  for (std::size_t c = 0; c < D; ++c) way[c] = join<5>(from[c], to[c], duration, free_end);
  return way;
}

/// Durations that are tried: each this many times the one before.
inline constexpr double ratio = 1.12;
inline constexpr int tries = 48;
inline constexpr int halvings = 4;

template <std::size_t D>
struct Timed {
  double duration;
  Coordinates<D> way;  // in t/T
};

/// The first duration of the series, and a little better, at which one piece keeps to the limits;
/// or `remaining`, if that is above 0 and will do.
template <std::size_t D>
std::optional<Timed<D>> shortest(const Motion<D>& from, const Goal<D>& goal, const Limits& limits,
                                 bool free_end, double remaining) {
  // No way is shorter: by the mean value theorem.
  double least = 1e-3;
  for (std::size_t k = 1; k < limits.size(); ++k)
    least = std::max(least, norm(difference(from, goal.at(0.0), k)) / limits[k]);
  if (!free_end) {
    const double closing = limits[0] + norm(goal.velocity);
    least = std::max(least, norm(difference(from, goal.at(0.0), 0)) / closing);
  }
  const auto attempt = [&](double duration) {
    return join_all<D>(from, goal.at(duration), duration, free_end);
  };
  if (remaining > 0.0) {
    const Coordinates<D> way = attempt(remaining);
    if (keeps<D>(way, remaining, limits)) return Timed<D>{remaining, way};
  }
  double duration = least, before = 0.0;
  for (int k = 0; k < tries; ++k, before = duration, duration *= ratio) {
    Timed<D> found{duration, attempt(duration)};
    if (!keeps<D>(found.way, duration, limits)) continue;
    double low = before;
    for (int i = 0; i < halvings && low > 0.0; ++i) {
      const double middle = 0.5 * (low + found.duration);
      const Coordinates<D> way = attempt(middle);
      if (keeps<D>(way, middle, limits))
        found = {middle, way};
      else
        low = middle;
    }
    return found;
  }
  return std::nullopt;
}

template <std::size_t D>
bool rests(const Motion<D>& motion) {
  for (const Derivatives& x : motion)
    for (std::size_t k = 1; k < x.size(); ++k)
      if (x[k] != 0.0) return false;
  return true;
}

template <std::size_t D>
void append(Path<D>& path, const Timed<D>& found) {
  Piece<D> piece{path.end, {}};
  for (std::size_t c = 0; c < D; ++c) piece.coordinate[c] = in_time(found.way[c], found.duration);
  path.pieces.push_back(piece);
  path.end += found.duration;
}

}  // namespace detail

/// Stays with a goal that moves, for good.
template <std::size_t D>
void keep_up(Path<D>& path, const Goal<D>& goal) {
  const Motion<D> here = goal.at(path.end);
  if (detail::rests(here)) return;
  Piece<D> piece{path.end, {}};
  for (std::size_t c = 0; c < D; ++c) piece.coordinate[c] = {here[c][0], here[c][1]};
  path.pieces.push_back(piece);
  path.end = std::numeric_limits<double>::infinity();
}

/// One piece in a given time, whatever it takes.
template <std::size_t D>
Path<D> timed_move(const Motion<D>& from, const Goal<D>& goal, double duration) {
  Path<D> path;
  detail::append<D>(path,
                    {duration, detail::join_all<D>(from, goal.at(duration), duration, false)});
  keep_up(path, goal);
  return path;
}

/// A move from a state to a goal within limits, from time 0 on. Empty where the state itself cannot
/// be left within the limits: it exceeds one, or is bound to. Where the state is on a way that was
/// planned before, `remaining` is what is left of its time, s: then it goes on.
template <std::size_t D>
Path<D> fastest_move(const Motion<D>& from, const Goal<D>& goal, const Limits& limits,
                     double remaining = 0.0) {
  if (detail::rests(from) && detail::rests(goal.at(0.0))) {
    const double distance = detail::norm(detail::difference(goal.at(0.0), from, 0));
    // Too short to tell from standing still is as short as anything.
    return timed_move(from, goal, std::max(rest_to_rest_duration(distance, limits), 1e-3));
  }
  Path<D> path;
  if (const auto direct = detail::shortest(from, goal, limits, false, remaining)) {
    detail::append(path, *direct);
    keep_up(path, goal);
    return path;
  }
  const auto stop = detail::shortest(from, Goal<D>{}, limits, true, 0.0);
  if (!stop) return path;
  detail::append(path, *stop);
  Motion<D> rest = path.at(path.end);
  if (detail::rests(goal.at(0.0))) {
    const double distance = detail::norm(detail::difference(goal.at(0.0), rest, 0));
    const double duration = std::max(rest_to_rest_duration(distance, limits), 1e-3);
    detail::append<D>(path, {duration, detail::join_all<D>(rest, goal.at(0.0), duration, false)});
    return path;
  }
  Goal<D> later = goal;
  for (std::size_t c = 0; c < D; ++c) later.position[c] += path.end * goal.velocity[c];
  const auto catching = detail::shortest(rest, later, limits, false, 0.0);
  if (!catching) return {};
  detail::append(path, *catching);
  keep_up(path, goal);
  return path;
}

}  // namespace multilift::plan
