// One planar run: plant, law, actuators and sensors stepped together at a fixed step.
#pragma once

#include <utility>

#include "multilift/sim/planar/audit.hpp"
#include "multilift/sim/planar/columns.hpp"
#include "multilift/sim/planar/loads.hpp"
#include "multilift/sim/status.hpp"

namespace multilift::planar {

struct Timing {
  double step{0.001};     // of the integrator, s
  long steps{0};          // how many
  long control_steps{1};  // integration steps in a control period
  long record_steps{1};   // integration steps between two records

  double control_period() const { return step * static_cast<double>(control_steps); }
};

template <Real R>
struct Outcome {
  Status status{Status::finished};
  int culprit{-1};  // index of the cable that went slack or the angle that reached its limit
  double end_time{0.0};
  State<R> state;
  Metrics<R> metrics;
  Audit<R> audit;
};

/// Why a run cannot go on from here, and which cable or angle is to blame.
template <Real R>
MULTILIFT_INLINE std::pair<Status, int> judge(const State<R>& state, const Motion<R>& motion) {
  constexpr double bound = 1e6;  // m, m/s, rad/s, N: far outside any flight
  bool bounded = true;
  const auto include = [&](const R& x) {
    const double size = std::fabs(value(x));
    bounded &= size <= bound;  // false for NaN too
  };
  include(state.bar.y);
  include(state.bar.z);
  include(state.bar_velocity.y);
  include(state.bar_velocity.z);
  for (const R& x : state.theta_dot) include(x);
  for (const R& x : motion.tension) include(x);
  if (!bounded) return {Status::diverged, -1};
  for (int k = 0; k < 3; ++k)
    if (std::fabs(value(state.theta[static_cast<std::size_t>(k)])) >= std::numbers::pi / 2)
      return {Status::swing_limit, k};
  for (int i = 0; i < 2; ++i)
    if (value(motion.tension[static_cast<std::size_t>(i)]) < 0.0) return {Status::slack, i};
  return {Status::finished, -1};
}

/// Runs from `state` to the end of the timing or to the first broken assumption. `record` is
/// called with a Sample every record_steps and at the end. Nothing is allocated on the way.
template <bool with_audit, Real R, class Law, class Actuators, class Sensors, class Record>
Outcome<R> rollout(const Plant<R>& plant, State<R> state, const std::array<Vec2<R>, 2>& goal,
                   Law& law, Actuators& actuators, Sensors& sensors,
                   const std::vector<Push>& pushes, const Timing& timing, Record&& record) {
  const double h = timing.step;
  const StorageGains<R> gains = law.storage_gains();
  std::array<Vec2<R>, 2> d_hat = law.d_hat();
  Command<R> commanded{};
  Pose<R> pose = pose_of(plant, state);
  Outcome<R> outcome{Status::finished, -1, 0.0, state, {plant, pose.vehicle, goal}, {}};
  if constexpr (with_audit)
    outcome.audit.begin(storage_function(plant, gains, state, pose, goal, d_hat));

  for (long k = 0;; ++k) {
    const double time = h * static_cast<double>(k);
    sensors.observe(k, state, pose);
    if (k % timing.control_steps == 0) {
      const std::array<Vec2<R>, 2> next_d_hat = law.d_hat();
      if constexpr (with_audit)
        outcome.audit.add_adaptation(estimation_energy(plant, gains, next_d_hat) -
                                     estimation_energy(plant, gains, d_hat));
      d_hat = next_d_hat;
      Measurement<R> measured = sensors.read(k, state, pose);
      measured.time = time;
      measured.saturated = actuators.saturated();
      commanded = law.step(measured);
      actuators.command(k, commanded);
    }
    actuators.begin_step(k);

    // What holds at this instant.
    const Loads<R> loads = loads_at(time, Stage::start, actuators.at_start(), pushes);
    const Motion<R> now = motion(plant, state, pose, loads);
    const bool last = k == timing.steps;
    std::tie(outcome.status, outcome.culprit) = judge(state, now);
    outcome.end_time = time;
    outcome.state = state;
    const bool over = last || outcome.status != Status::finished;
    Powers<R> powers;
    R storage(0.0);
    if constexpr (with_audit) {
      powers = powers_of(plant, gains, state, pose, loads, now, goal, d_hat);
      storage = storage_function(plant, gains, state, pose, goal, d_hat);
      if (outcome.status != Status::diverged) outcome.audit.compare(storage);
    }
    const Instant<R> instant{time, state, pose, now, commanded, actuators.at_start(), storage};
    if (outcome.status != Status::diverged) outcome.metrics.update(instant, over ? 0.0 : h);
    if (over || k % timing.record_steps == 0)
      record(Sample<R>{instant, plant, d_hat, powers, mechanical_energy(plant, state, pose)});
    if (over) return outcome;

    // What leads to the next one.
    Powers<R> work = R(h / 6.0) * powers;
    state = rk4_step(state, now.rate(state), h, [&](Stage stage, const State<R>& x) {
      const bool middle = stage == Stage::middle;
      const Loads<R> stage_loads =
          loads_at(time + (middle ? 0.5 * h : h), stage,
                   middle ? actuators.at_middle() : actuators.at_end(), pushes);
      const Pose<R> stage_pose = pose_of(plant, x);
      const Motion<R> stage_motion = motion(plant, x, stage_pose, stage_loads);
      if constexpr (with_audit)
        work = work + R(middle ? h / 3.0 : h / 6.0) * powers_of(plant, gains, x, stage_pose,
                                                                stage_loads, stage_motion, goal,
                                                                d_hat);
      return stage_motion.rate(x);
    });
    if constexpr (with_audit) outcome.audit.add(work);
    pose = pose_of(plant, state);
  }
}

}  // namespace multilift::planar
