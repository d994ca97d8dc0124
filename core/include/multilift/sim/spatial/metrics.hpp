// The result of a spatial run in numbers, gathered while it runs. This is their one definition.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "multilift/control/spatial/target.hpp"
#include "multilift/math/arc.hpp"
#include "multilift/model/spatial/dynamics.hpp"
#include "multilift/sim/spatial/clearance.hpp"
#include "multilift/sim/spatial/stepper.hpp"

namespace multilift::spatial {

/// Thresholds of the settling times.
inline constexpr double swing_band = std::numbers::pi / 180.0;  // 1 degree, rad
inline constexpr double position_band = 0.02;                   // m

/// The arcsine of lanes or numbers in [0, 1], outside the hot loop.
template <Real R>
R arcsine(const R& x) {
  return atan2(x, sqrt(max(R(1.0) - x * x, R(0.0))));
}

/// One sampling instant, as metrics and records see it.
template <Real R, class V>
struct Sample {
  double time;
  const Plant<R>& plant;
  const State<R, V>& x;
  const Instant<R>& now;
  const Target<R>& target;
  const Masks<R>& taut;
  const std::vector<Vec3<R>>& commanded;  // force as the law gave it, W, N
  const std::vector<Vec3<R>>& d_hat;
  R storage;
};

/// How far cable i has turned from its direction at rest: 2 sin of half the angle, squared.
template <Real R, class V>
MULTILIFT_INLINE R swing_of(const Sample<R, V>& s, const std::vector<Vec3<R>>& rest_direction,
                            std::size_t i) {
  const Vec3<R> turn = s.now.cable[i].direction - turned(s.target.heading, rest_direction[i]);
  return dot(turn, turn);
}

/// The cables' directions at rest, level frame; up where none is asked of one.
template <Real R>
std::vector<Vec3<R>> rest_directions(const Formation<R>& formation) {
  std::vector<Vec3<R>> directions;
  for (const Vec3<R>& force : formation.cable_force) {
    const R size = norm(force);
    const R zero(0.0);
    directions.push_back(
        select<R>(zero < size, (R(1.0) / max(size, R(1e-12))) * force, {zero, zero, R(1.0)}));
  }
  return directions;
}

template <Real R>
class Metrics {
 public:
  Metrics() = default;
  explicit Metrics(std::vector<Vec3<R>> rest_direction)
      : rest_direction_(std::move(rest_direction)) {}

  /// At every integration step, the first and the last included; `step` is the time until the next
  /// one, 0 at the last.
  template <class V>
  MULTILIFT_INLINE void update(const Sample<R, V>& s, double step) {
    const R zero(0.0), time(s.time), weight(0.5 * (previous_step_ + step));
    const auto& [plant, x, now, target] = std::tie(s.plant, s.x, s.now, s.target);
    R swing(0.0);
    mask_t<R> any_slack = zero < zero;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3<R> error = x.vehicle[i].position - target.vehicle[i];
      last_far_ = select(R(square(position_band)) < dot(error, error), time, last_far_);
      const Vec3<R>& f = s.commanded[i];
      effort_ += R(step) * dot(f, f);
      const Vec3<R>& thrust = now.thrust[i];
      peak_thrust_squared_ = max(peak_thrust_squared_, dot(thrust, thrust));
      const R level = thrust.x * thrust.x + thrust.y * thrust.y;
      const R up = max(thrust.z, zero);
      // tan^2 of the tilt; divided only where it grows.
      if (const auto grows = peak_slope_squared_ * up * up < level; any(grows))
        peak_slope_squared_ = select(grows, level / (up * up), peak_slope_squared_);
      const mask_t<R> taut = zero < now.motion.tension[i];
      any_slack = any_slack | !taut;
      swing = max(swing, select(taut, swing_of(s, rest_direction_, i), zero));
      min_tension_ = min(min_tension_, now.motion.tension[i]);
      max_tension_ = max(max_tension_, now.motion.tension[i]);
      residual_ = max(residual_,
                      select(s.taut[i].is, abs(now.cable[i].length - plant.cable_length[i]), zero));
    }
    peak_swing_squared_ = max(peak_swing_squared_, swing);
    constexpr double band = swing_band * swing_band;  // chord and arc differ by 1e-5 of it
    last_swing_ = select(R(band) < swing, time, last_swing_);
    slack_time_ += select(any_slack, weight, zero);

    const Vec3<R> off = x.payload.position - target.payload;
    const R off_squared = dot(off, off);
    last_payload_far_ = select(R(square(position_band)) < off_squared, time, last_payload_far_);
    payload_error_squared_ = max(payload_error_squared_, off_squared);
    payload_error_integral_ += weight * off_squared;
    // Of the payload's upright axis and heading.
    tilt_cosine_ = min(tilt_cosine_, now.payload_turn.z.z);
    const Vec3<R>& ahead = now.payload_turn.x;
    const R across = target.heading.cos * ahead.y - target.heading.sin * ahead.x;
    yaw_sine_ = max(yaw_sine_, abs(across));
    least_storage_ = min(least_storage_, s.storage);
    storage_rise_ = max(storage_rise_, s.storage - least_storage_);
    previous_step_ = step;
    last_time_ = s.time;
  }

  void keep_clearance(const Clearance<R>& found) {
    clearance_.vehicles = min(clearance_.vehicles, found.vehicles);
    clearance_.cables = min(clearance_.cables, found.cables);
  }
  void keep_events(const CableEvents<R>& events) { events_ = events; }

  /// The run ended early in worlds of `mask`: nothing can be said to have settled there.
  void cut_short(int k) { complete_[static_cast<std::size_t>(k)] = false; }

  /// Calls v(Field, number) for each metric of world k.
  template <class F>
  void report(int k, F&& v) const {
    const double degree = std::numbers::pi / 180.0;
    using One = lane_scalar_t<R>;  // this world's own number
    const auto of = [k](const R& x) -> One { return lane(x, k); };
    const auto settled = [&](const R& last) {
      return complete_[static_cast<std::size_t>(k)] && of(last) < One(last_time_)
                 ? of(last)
                 : One(std::numeric_limits<double>::quiet_NaN());
    };
    const auto chord = [&](const R& squared) {
      return One(2.0) * arcsin(min(One(1.0), One(0.5) * sqrt(of(squared)))) / One(degree);
    };
    v(Field{"peak_swing", "deg", Range::any,
            "greatest angle of a taut cable from its direction at rest"},
      chord(peak_swing_squared_));
    v(Field{"swing_settling_time", "s", Range::any,
            "last time a taut cable is more than 1 degree from its direction at rest; empty if "
            "still "
            "at the end or if the run ended early"},
      settled(last_swing_));
    v(Field{"position_settling_time", "s", Range::any,
            "last time a vehicle is farther than 0.02 m from its target; empty likewise"},
      settled(last_far_));
    v(Field{"combined_settling", "s", Range::any,
            "last time a vehicle is farther than 0.02 m from its target or a taut cable more than "
            "1 degree from its direction at rest; empty likewise"},
      settled(max(last_swing_, last_far_)));
    v(Field{"payload_settling_time", "s", Range::any,
            "last time the payload is farther than 0.02 m from its target; empty likewise"},
      settled(last_payload_far_));
    v(Field{"payload_error_max", "m", Range::any,
            "greatest distance of the payload from its target"},
      sqrt(of(payload_error_squared_)));
    v(Field{"payload_error_rms", "m", Range::any, "its root mean square"},
      sqrt(of(payload_error_integral_) / One(std::fmax(last_time_, 1e-12))));
    v(Field{"payload_tilt_max", "deg", Range::any,
            "greatest angle of the payload's z from upright"},
      arccos(min(One(1.0), max(One(-1.0), of(tilt_cosine_)))) / One(degree));
    v(Field{"payload_yaw_error_max", "deg", Range::any, "greatest error of the payload's heading"},
      arcsin(min(One(1.0), of(yaw_sine_))) / One(degree));
    v(Field{"control_effort", "N^2 s", Range::any, "integral of the commanded forces squared"},
      of(effort_));
    v(Field{"peak_thrust", "N", Range::any, "greatest thrust of a vehicle"},
      sqrt(of(peak_thrust_squared_)));
    v(Field{"peak_tilt", "deg", Range::any, "greatest angle of a vehicle's thrust from upright"},
      arctan(sqrt(of(peak_slope_squared_))) / One(degree));
    v(Field{"min_tension", "N", Range::any, "least tension of a cable"}, of(min_tension_));
    v(Field{"max_tension", "N", Range::any, "greatest tension of a cable"}, of(max_tension_));
    v(Field{"slack_time", "s", Range::any, "for how long some cable was slack"}, of(slack_time_));
    v(Field{"impacts", "", Range::any, "how many times a rigid cable was pulled taut"},
      of(events_.impacts));
    v(Field{"impact_energy", "J", Range::any, "lost in these"}, of(events_.energy_lost));
    v(Field{"hardest_impulse", "N s", Range::any, "of one cable in one of these"},
      of(events_.hardest_impulse));
    v(Field{"vehicle_distance_min", "m", Range::any, "least distance of two vehicles"},
      of(clearance_.vehicles));
    v(Field{"cable_distance_min", "m", Range::any,
            "least distance of a vehicle from another's cable"},
      of(clearance_.cables));
    v(Field{"cable_residual", "m", Range::any, "greatest error of a taut cable's length"},
      of(residual_));
    v(Field{"storage_rise", "J", Range::any,
            "greatest rise of the storage function above its least value so far"},
      of(storage_rise_));
  }

 private:
  static constexpr std::array<bool, static_cast<std::size_t>(lanes_of<R>)> all_true() {
    std::array<bool, static_cast<std::size_t>(lanes_of<R>)> x{};
    x.fill(true);
    return x;
  }

  std::vector<Vec3<R>> rest_direction_;  // of the cables, level frame
  R peak_swing_squared_{0.0}, last_swing_{0.0}, last_far_{0.0}, last_payload_far_{0.0};
  R payload_error_squared_{0.0}, payload_error_integral_{0.0}, tilt_cosine_{1.0}, yaw_sine_{0.0};
  R effort_{0.0}, peak_thrust_squared_{0.0}, peak_slope_squared_{0.0};
  R min_tension_{unlimited}, max_tension_{0.0}, slack_time_{0.0}, residual_{0.0};
  R least_storage_{unlimited}, storage_rise_{0.0};
  Clearance<R> clearance_;
  CableEvents<R> events_;
  double previous_step_{0.0}, last_time_{0.0};
  std::array<bool, static_cast<std::size_t>(lanes_of<R>)> complete_ = all_true();
};

}  // namespace multilift::spatial
