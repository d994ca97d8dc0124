// One planar run: plant, law, actuators and sensors stepped together at a fixed step.
#pragma once

#include <tuple>
#include <utility>

#include "multilift/control/planar/reference.hpp"
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

/// What happens rarely: records, and the outcomes of the worlds that end now. Returns which worlds
/// go on. One call that is given copies, so that in the loop, which it would otherwise reach into,
/// everything may stay in registers.
template <bool with_audit, Real R, class Record>
MULTILIFT_NOINLINE mask_t<R> record_and_end(Record& record, bool due, Outcomes<R>& outcomes,
                                            mask_t<R> alive, mask_t<R> ending, Verdict<R> verdict,
                                            const Plant<R>& plant, double time, State<R> state,
                                            Pose<R> pose, Motion<R> now, Command<R> commanded,
                                            Command<R> applied, R storage,
                                            std::array<Vec2<R>, 2> d_hat, Powers<R> powers,
                                            Metrics<R> metrics, Audit<R> audit) {
  const Instant<R> instant{time, state, pose, now, commanded, applied, storage};
  const R energy = mechanical_energy(plant, state, pose, swing_of(plant, state, pose));
  record(Sample<R>{instant, plant, d_hat, powers, energy}, due ? alive : ending);
  if (!any(ending)) return alive;
  const Metrics<R> metrics_before = metrics;
  const Audit<R> audit_before = audit;
  metrics.update(instant, 0.0);
  if constexpr (with_audit) audit.compare(storage);
  for (int i = 0; i < lanes_of<R>; ++i) {
    if (!lane(ending, i)) continue;
    auto& outcome = outcomes[static_cast<std::size_t>(i)];
    std::tie(outcome.status, outcome.culprit) = verdict.world(i);
    outcome.end_time = time;
    outcome.state = state.world(i);
    // A state without meaning belongs neither to the metrics nor to the audit.
    const bool diverged = outcome.status == Status::diverged;
    outcome.metrics = (diverged ? metrics_before : metrics).world(i);
    outcome.audit = (diverged ? audit_before : audit).world(i);
    if (outcome.status != Status::finished) outcome.metrics.cut_short();
  }
  return alive & !ending;
}

/// Runs from `state` to the end of the timing; each world of a batch only to its first broken
/// assumption. `record` is called with a Sample and the worlds still alive every record_steps, and
/// once more with every world that ends. `reference` is null where the goal rests. Nothing is
/// allocated on the way.
template <bool with_audit, Real R, class Law, class Actuators, class Sensors, class Record>
Outcomes<R> rollout(const Plant<R>& plant, State<R> state, const std::array<Vec2<R>, 2>& goal,
                    Law& law, Actuators& actuators, Sensors& sensors,
                    const std::vector<Push<R>>& pushes, const Timing& timing, Record&& record,
                    const Reference<R>* reference = nullptr) {
  const double h = timing.step;
  const auto storage_function = storage_of(plant, law.storage_gains(), goal);
  std::array<Vec2<R>, 2> d_hat = law.d_hat();
  R estimation = storage_function.estimation_energy(plant, d_hat);
  Command<R> commanded{};
  Target<R> moving, for_law;
  const auto target_at = [&](double time) -> const Target<R>* {
    if (reference == nullptr) return nullptr;
    reference->at(time, moving);
    return &moving;
  };
  Metrics<R> metrics(plant, pose_of(plant, state).vehicle, goal);
  Audit<R> audit;
  Outcomes<R> outcomes;
  mask_t<R> alive = R(0.0) < R(1.0);

  for (long k = 0;; ++k) {
    const double time = h * static_cast<double>(k);
    Pose<R> pose = pose_of(plant, state);
    sensors.observe(k, state, pose);
    const Target<R>* target = target_at(time);
    if (k % timing.control_steps == 0) {
      d_hat = law.d_hat();
      if constexpr (with_audit) {
        R next = storage_function.estimation_energy(plant, d_hat);
        audit.add_adaptation(next - estimation);
        estimation = next;
      }
      Measurement<R> measured = sensors.read(k, state, pose);
      measured.time = time;
      if (reference != nullptr) {
        reference->for_law(time, for_law);
        measured.target = &for_law;
      }
      measured.saturated = actuators.saturated();
      commanded = law.step(measured);
      actuators.command(k, commanded);
    }
    actuators.begin_step(k);

    // What holds at this instant.
    Loads<R> loads = loads_at(time, Stage::start, actuators.at_start(), pushes);
    Motion<R> now = motion(plant, state, pose, loads);
    Powers<R> powers;
    R storage(0.0);
    if constexpr (with_audit) {
      const auto formation = storage_function.formation(plant, state, pose, target);
      powers = storage_function.powers(plant, state, pose, formation, loads, now, d_hat, target);
      storage = storage_function.motion_energy(plant, state, pose, formation) + estimation;
      if (k == 0) audit.begin(storage);
    }
    Verdict<R> verdict = judge(state, now);
    mask_t<R> last = R(0.0) < R(k == timing.steps ? 1.0 : 0.0);
    mask_t<R> ending = alive & (verdict.any_cause() | last);
    const bool due = k % timing.record_steps == 0;
    if (due || any(ending)) {
      alive = record_and_end<with_audit, R>(record, due, outcomes, alive, ending, verdict, plant,
                                            time, state, pose, now, commanded, actuators.at_start(),
                                            storage, d_hat, powers, metrics, audit);
      if (!any(alive)) return outcomes;
    }
    if constexpr (with_audit) audit.compare(storage);
    metrics.update({time, state, pose, now, commanded, actuators.at_start(), storage}, h);

    // What leads to the next one.
    Powers<R> work = powers;
    const auto rate_at = [&](Stage stage, const State<R>& x) MULTILIFT_INLINE_LAMBDA {
      const bool middle = stage == Stage::middle;
      Loads<R> stage_loads = loads_at(time + (middle ? 0.5 * h : h), stage,
                                      middle ? actuators.at_middle() : actuators.at_end(), pushes);
      Pose<R> stage_pose = pose_of(plant, x);
      Motion<R> stage_motion = motion(plant, x, stage_pose, stage_loads);
      if constexpr (with_audit) {
        const Target<R>* then_target = target_at(time + (middle ? 0.5 * h : h));
        const auto formation = storage_function.formation(plant, x, stage_pose, then_target);
        Powers<R> then = storage_function.powers(plant, x, stage_pose, formation, stage_loads,
                                                 stage_motion, d_hat, then_target);
        work = work + R(middle ? 2.0 : 1.0) * then;
      }
      return stage_motion.rate(x);
    };
    state = rk4_step(state, now.rate(state), h, rate_at);
    if constexpr (with_audit) audit.add(R(h / 6.0) * work);
  }
}

}  // namespace multilift::planar
