// The result of a planar run in numbers, gathered while it runs. This is their one definition.
#pragma once

#include <numbers>

#include "multilift/control/planar/measurement.hpp"
#include "multilift/math/atan.hpp"
#include "multilift/model/planar/energy.hpp"

namespace multilift::planar {

/// Thresholds of the settling times.
inline constexpr double swing_band = std::numbers::pi / 180.0;  // 1 degree, rad
inline constexpr double position_band = 0.02;                   // m
// A swing of about half a degree turns as fast where cables are as long as the paper's.
inline constexpr double rest_band = std::numbers::pi / 180.0;  // 1 degree a second, rad/s
/// A vehicle moves along an axis if its goal is farther than this from its start.
inline constexpr double least_travel = 1e-6;  // m

/// One sampling instant, as metrics and records see it.
template <Real R>
struct Instant {
  double time;
  const State<R>& state;
  const Pose<R>& pose;
  const Motion<R>& motion;
  const Command<R>& commanded;  // u as the law gave it, N
  const Command<R>& applied;    // u as it acts, N
  const R& storage;             // (49), J
};

template <Real R>
class Metrics {
 public:
  Metrics(const Plant<R>& p, const std::array<Vec2<R>, 2>& start,
          const std::array<Vec2<R>, 2>& goal)
      : share_{p.gravity_share(0), p.gravity_share(1)}, goal_(goal) {
    // The start is worked out from the bar's, so that no travel may read as a rounding.
    const R zero(0.0), one(1.0), least(least_travel);
    const auto sign = [&](const R& x) {
      return select(least < x, one, select(x < -least, -one, zero));
    };
    for (std::size_t i = 0; i < 2; ++i)
      towards_[i] = {sign(goal[i].y - start[i].y), sign(goal[i].z - start[i].z)};
  }

  /// At every integration step, the first and the last included; `step` is the time until the next
  /// one, 0 at the last.
  MULTILIFT_INLINE void update(const Instant<R>& now, double step) {
    const R time(now.time);
    R swing_sum(0.0);
    for (std::size_t k = 0; k < 3; ++k) {
      peak_swing_[k] = max(peak_swing_[k], abs(now.state.theta[k]));
      last_turning_ = select(R(rest_band) < abs(now.state.theta_dot[k]), time, last_turning_);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      const R size = abs(now.state.theta[k]);
      swing_sum += size;
      last_swing_ = select(R(swing_band) < size, time, last_swing_);
    }
    last_deflection_ = select(R(swing_band) < abs(now.state.theta[2]), time, last_deflection_);
    // Trapezoidal rule: each instant counts half a step to either side.
    swing_integral_ += R(0.5 * (previous_step_ + step)) * swing_sum;
    previous_step_ = step;

    for (std::size_t i = 0; i < 2; ++i) {
      const Vec2<R> error = now.pose.vehicle[i] - goal_[i];
      last_far_ = select(R(position_band * position_band) < dot(error, error), time, last_far_);
      overshoot_ = max(overshoot_, max(towards_[i].y * error.y, towards_[i].z * error.z));
      effort_ += R(step) * dot(now.commanded[i], now.commanded[i]);
      const Vec2<R> thrust{now.applied[i].y, now.applied[i].z + share_[i]};
      peak_thrust_squared_ = max(peak_thrust_squared_, dot(thrust, thrust));
      // tan(phi) = side / up; divided only where it grows, as a division costs as much as the rest.
      const R side = abs(thrust.y);
      const R up = max(thrust.z, R(0.0));
      if (const auto grows = peak_slope_ * up < side; any(grows))
        peak_slope_ = select(grows, side / up, peak_slope_);
      min_tension_ = min(min_tension_, now.motion.tension[i]);
    }
    least_storage_ = min(least_storage_, now.storage);
    storage_rise_ = max(storage_rise_, now.storage - least_storage_);
    last_time_ = now.time;
  }

  /// The run ended before its time: nothing can be said to have settled.
  void cut_short() { complete_ = false; }

  /// Calls v(Field, x) for each metric, x with its derivatives where R has them; a settling time is
  /// NaN where the run ended unsettled, and has none.
  template <class V>
  void visit(V&& v) const {
    const R degree(std::numbers::pi / 180.0);
    const char* peak_names[] = {"peak_swing_1", "peak_swing_2", "peak_swing_3"};
    const char* peak_docs[] = {"greatest |theta1|", "greatest |theta2|", "greatest |theta3|"};
    for (std::size_t k = 0; k < 3; ++k)
      v(Field{peak_names[k], "deg", Range::any, peak_docs[k]}, peak_swing_[k] / degree);
    v(Field{"swing_settling_time", "s", Range::any,
            "last time |theta1| or |theta2| exceeds 1 degree; 0 if never, empty if still at the "
            "end or if the run ended early"},
      R(settled(last_swing_)));
    v(Field{"position_settling_time", "s", Range::any,
            "last time a vehicle is farther than 0.02 m from its goal; empty if still at the end "
            "or if the run ended early"},
      R(settled(last_far_)));
    v(Field{"combined_settling", "s", Range::any,
            "last time a vehicle is farther than 0.02 m from its goal or any |theta| exceeds 1 "
            "degree; empty if still at the end or if the run ended early"},
      R(settled(max(max(last_swing_, last_deflection_), last_far_))));
    v(Field{"rest_settling_time", "s", Range::any,
            "last time an angle turns faster than 1 degree a second, at whatever angles the load "
            "then hangs; empty if still at the end or if the run ended early"},
      R(settled(last_turning_)));
    v(Field{"overshoot", "m", Range::any,
            "greatest travel past the goal, over vehicles and the axes along which they move"},
      overshoot_);
    v(Field{"swing_integral", "deg s", Range::any, "integral of |theta1| + |theta2|"},
      swing_integral_ / degree);
    v(Field{"control_effort", "N^2 s", Range::any, "integral of |u|^2, u as commanded"}, effort_);
    v(Field{"peak_thrust", "N", Range::any, "greatest thrust of a vehicle"},
      sqrt(peak_thrust_squared_));
    v(Field{"peak_tilt", "deg", Range::any, "greatest |phi| of a vehicle"},
      atan(peak_slope_) / degree);
    v(Field{"min_tension", "N", Range::any, "least tension of a cable"}, min_tension_);
    v(Field{"storage_rise", "J", Range::any,
            "greatest rise of the storage function (49) above its least value so far"},
      storage_rise_);
  }

  /// Calls v(Field, value) for each metric.
  template <class V>
  void report(V&& v) const {
    visit([&](const Field& field, const R& x) { v(field, value(x)); });
  }

  /// World k's metrics on their own.
  Metrics<lane_scalar_t<R>> world(int k) const {
    Metrics<lane_scalar_t<R>> one;
    const auto take = [k](auto& mine, const R& all) { mine = lane(all, k); };
    for (std::size_t i = 0; i < 3; ++i) take(one.peak_swing_[i], peak_swing_[i]);
    take(one.last_swing_, last_swing_);
    take(one.last_deflection_, last_deflection_);
    take(one.last_far_, last_far_);
    take(one.last_turning_, last_turning_);
    take(one.overshoot_, overshoot_);
    take(one.swing_integral_, swing_integral_);
    take(one.effort_, effort_);
    take(one.peak_thrust_squared_, peak_thrust_squared_);
    take(one.peak_slope_, peak_slope_);
    take(one.min_tension_, min_tension_);
    take(one.least_storage_, least_storage_);
    take(one.storage_rise_, storage_rise_);
    one.previous_step_ = previous_step_;
    one.last_time_ = last_time_;
    one.complete_ = complete_;
    return one;
  }

  Metrics() = default;

 private:
  template <Real>
  friend class Metrics;

  double settled(const R& last) const {
    return complete_ && value(last) < last_time_ ? value(last)
                                                 : std::numeric_limits<double>::quiet_NaN();
  }

  std::array<R, 2> share_{};
  std::array<Vec2<R>, 2> goal_;
  std::array<Vec2<R>, 2> towards_;  // the goal along each axis: +1, -1, or 0 for no travel
  std::array<R, 3> peak_swing_{R(0.0), R(0.0), R(0.0)};
  R last_swing_{0.0}, last_deflection_{0.0}, last_far_{0.0}, last_turning_{0.0}, overshoot_{0.0},
      swing_integral_{0.0}, effort_{0.0};
  R peak_thrust_squared_{0.0}, peak_slope_{0.0}, min_tension_{unlimited};
  R least_storage_{unlimited}, storage_rise_{0.0};
  double previous_step_{0.0}, last_time_{0.0};
  bool complete_{true};
};

}  // namespace multilift::planar
