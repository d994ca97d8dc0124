// One planar run: plant, law, actuators and sensors stepped together at a fixed step.
#pragma once

#include <tuple>
#include <utility>

#include "multilift/sim/planar/audit.hpp"
#include "multilift/sim/planar/columns.hpp"
#include "multilift/sim/planar/loads.hpp"
#include "multilift/sim/status.hpp"
#include "multilift/sim/timing.hpp"

namespace multilift::planar {

/// How one world ended. S is double, or dual numbers where derivatives are wanted.
template <Real S>
struct Outcome {
  Status status{Status::finished};
  int culprit{-1};  // index of the cable that went slack or the angle that reached its limit
  double end_time{0.0};
  State<S> state;
  Metrics<S> metrics;
  Audit<S> audit;
};

template <Real R>
using Outcomes = std::array<Outcome<lane_scalar_t<R>>, static_cast<std::size_t>(lanes_of<R>)>;

/// Why worlds cannot go on from here.
template <Real R>
struct Verdict {
  mask_t<R> diverged;
  std::array<mask_t<R>, 3> beyond_limit;  // by angle
  std::array<mask_t<R>, 2> slack;         // by cable

  mask_t<R> any_cause() const {
    return diverged | beyond_limit[0] | beyond_limit[1] | beyond_limit[2] | slack[0] | slack[1];
  }

  /// World k's status and which cable or angle is to blame.
  std::pair<Status, int> world(int k) const {
    if (lane(diverged, k)) return {Status::diverged, -1};
    for (int i = 0; i < 3; ++i)
      if (lane(beyond_limit[static_cast<std::size_t>(i)], k)) return {Status::swing_limit, i};
    for (int i = 0; i < 2; ++i)
      if (lane(slack[static_cast<std::size_t>(i)], k)) return {Status::slack, i};
    return {Status::finished, -1};
  }
};

template <Real R>
MULTILIFT_INLINE Verdict<R> judge(const State<R>& state, const Motion<R>& motion) {
  const R bound(1e6);  // m, m/s, rad/s, N: far outside any flight
  const R quarter_turn(std::numbers::pi / 2);
  Verdict<R> verdict;
  // A comparison with NaN is false, so that `bounded` is false for it too.
  mask_t<R> bounded = abs(state.bar.y) <= bound;
  const auto include = [&](const R& x) { bounded = bounded & (abs(x) <= bound); };
  include(state.bar.z);
  include(state.bar_velocity.y);
  include(state.bar_velocity.z);
  for (const R& x : state.theta_dot) include(x);
  for (const R& x : motion.tension) include(x);
  verdict.diverged = !bounded;
  for (std::size_t k = 0; k < 3; ++k) verdict.beyond_limit[k] = quarter_turn <= abs(state.theta[k]);
  for (std::size_t i = 0; i < 2; ++i) verdict.slack[i] = motion.tension[i] < R(0.0);
  return verdict;
}

/// Runs from `state` to the end of the timing; each world of a batch only to its first broken
/// assumption. `record` is called with a Sample and the worlds still alive every record_steps, and
/// once more with every world that ends. Nothing is allocated on the way.
template <bool with_audit, Real R, class Law, class Actuators, class Sensors, class Record>
Outcomes<R> rollout(const Plant<R>& plant, State<R> state, const std::array<Vec2<R>, 2>& goal,
                    Law& law, Actuators& actuators, Sensors& sensors,
                    const std::vector<Push<R>>& pushes, const Timing& timing, Record&& record) {
  const double h = timing.step;
  const StorageGains<R> gains = law.storage_gains();
  std::array<Vec2<R>, 2> d_hat = law.d_hat();
  Command<R> commanded{};
  Pose<R> pose = pose_of(plant, state);
  Metrics<R> metrics(plant, pose.vehicle, goal);
  Audit<R> audit;
  Outcomes<R> outcomes;
  mask_t<R> alive = R(0.0) < R(1.0);
  if constexpr (with_audit) audit.begin(storage_function(plant, gains, state, pose, goal, d_hat));

  for (long k = 0;; ++k) {
    const double time = h * static_cast<double>(k);
    sensors.observe(k, state, pose);
    if (k % timing.control_steps == 0) {
      const std::array<Vec2<R>, 2> next_d_hat = law.d_hat();
      if constexpr (with_audit)
        audit.add_adaptation(estimation_energy(plant, gains, next_d_hat) -
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
    Powers<R> powers;
    R storage(0.0);
    if constexpr (with_audit) {
      powers = powers_of(plant, gains, state, pose, loads, now, goal, d_hat);
      storage = storage_function(plant, gains, state, pose, goal, d_hat);
    }
    const Instant<R> instant{time, state, pose, now, commanded, actuators.at_start(), storage};
    const auto sample = [&] {
      return Sample<R>{instant, plant, d_hat, powers, mechanical_energy(plant, state, pose)};
    };
    const Verdict<R> verdict = judge(state, now);
    const bool last = k == timing.steps;
    const mask_t<R> ending =
        alive & (verdict.any_cause() | mask_t<R>(R(0.0) < R(last ? 1.0 : 0.0)));
    if (any(ending)) {
      record(sample(), ending);
      for (int i = 0; i < lanes_of<R>; ++i) {
        if (!lane(ending, i)) continue;
        auto& outcome = outcomes[static_cast<std::size_t>(i)];
        std::tie(outcome.status, outcome.culprit) = verdict.world(i);
        outcome.end_time = time;
        outcome.state = state.world(i);
        // A state without meaning belongs neither to the metrics nor to the audit.
        Metrics<R> final_metrics = metrics;
        Audit<R> final_audit = audit;
        if (outcome.status != Status::diverged) {
          final_metrics.update(instant, 0.0);
          if constexpr (with_audit) final_audit.compare(storage);
        }
        if (outcome.status != Status::finished) final_metrics.cut_short();
        outcome.metrics = final_metrics.world(i);
        outcome.audit = final_audit.world(i);
      }
      alive = alive & !ending;
      if (!any(alive)) return outcomes;
    }
    if constexpr (with_audit) audit.compare(storage);
    metrics.update(instant, h);
    if (k % timing.record_steps == 0) record(sample(), alive);

    // What leads to the next one.
    Powers<R> work = R(h / 6.0) * powers;
    const auto rate_at = [&](Stage stage, const State<R>& x) MULTILIFT_INLINE_LAMBDA {
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
    };
    // One world runs faster with a copy of this code for each stage; worlds side by side, whose
    // code is longer, with one copy for all.
    if constexpr (lanes_of<R> == 1)
      state = rk4_step(state, now.rate(state), h, rate_at);
    else
      state = rk4_step(state, now.rate(state), h,
                       [&](Stage stage, const State<R>& x) { return rate_at(stage, x); });
    if constexpr (with_audit) audit.add(work);
    pose = pose_of(plant, state);
  }
}

}  // namespace multilift::planar
