// Worlds stepped from outside: forces in, held for one control period, the state out.
//
// Plant, integrator, actuators, sensors, pushes and endings are those of rollout.hpp; the law is
// the caller's. A world that ends stays as it was then, whatever its neighbours do. Worlds side by
// side may have begun at different control instants: actuators and sensors go by one clock for all,
// from which each world's own steps differ by whole control periods.
#pragma once

#include "multilift/sim/planar/actuators.hpp"
#include "multilift/sim/planar/rollout.hpp"
#include "multilift/sim/planar/sensors.hpp"

namespace multilift::planar {

template <Real R, class Actuators, class Sensors>
class Stepping {
 public:
  /// All worlds at their starts, at time 0. The tensions are those of no command.
  Stepping(const Plant<R>& plant, const State<R>& start, std::vector<Push<R>> pushes,
           Actuators actuators, Sensors sensors)
      : plant_(plant),
        actuators_(std::move(actuators)),
        sensors_(std::move(sensors)),
        pushes_(std::move(pushes)),
        state_(start),
        pose_(pose_of(plant, start)) {
    if constexpr (Actuators::ideal) actuators_.command(0, {});
    held_ = actuators_.at_start();
    tension_ = held_motion(R(0.0), Stage::start, held_).tension;
    sensors_.observe(clock_, steps_, state_, pose_);
    measured_ = sensors_.read(clock_, state_, pose_);
    ending_.fill(Status::finished);
    culprit_.fill(-1);
  }

  /// Puts back those worlds of `mask` as they are in `other`, their parameters being equal.
  void keep(const Stepping& other, const mask_t<R>& mask) {
    const auto take = [&](R& mine, const R& its) { mine = select(mask, its, mine); };
    clock_ = other.clock_;
    actuators_.keep(other.actuators_, mask, clock_);
    sensors_.keep(other.sensors_, mask, clock_);
    state_ = select_state<R>(mask, other.state_, state_);
    pose_ = pose_of(plant_, state_);
    measured_.visit_scalars(other.measured_, take);
    take(steps_, other.steps_);
    for (std::size_t i = 0; i < 2; ++i) {
      take(tension_[i], other.tension_[i]);
      take(held_[i].y, other.held_[i].y);
      take(held_[i].z, other.held_[i].z);
      measured_.saturated[i] = mask & other.measured_.saturated[i];
    }
    for (int k = 0; k < lanes_of<R>; ++k) {
      if (!lane(mask, k)) continue;
      const auto i = static_cast<std::size_t>(k);
      ending_[i] = other.ending_[i];
      culprit_[i] = other.culprit_[i];
    }
    running_ = (mask & other.running_) | ((!mask) & running_);
    // Those that begin take their first sample by this clock. Another one of the others, where that
    // is due, is the same again.
    sensors_.observe(clock_, steps_, state_, pose_);
    const Measurement<R> first = sensors_.read(clock_, state_, pose_);
    measured_.visit_scalars(first, [&](R& mine, const R& its) { mine = select(mask, mine, its); });
  }

  /// Holds u for a control period of the timing, or as far as each world goes. As in a rollout, a
  /// cable's slack counts at the start of each integration step, under the command that acts there.
  void advance(const Command<R>& u, const Timing& timing) {
    const double h = timing.step;
    const R all_steps(static_cast<double>(timing.steps));
    actuators_.command(clock_, u);
    const mask_t<R> moving = running_;
    for (long j = 0; j < timing.control_steps; ++j) {
      mask_t<R> going = running_ & (steps_ < all_steps);
      // What delays and lags hold moves on to the period's end, so that company does not matter.
      if constexpr (Actuators::ideal)
        if (!any(going)) break;
      if (j > 0) sensors_.observe(clock_, steps_, state_, pose_);
      actuators_.begin_step(clock_);
      const R time = R(h) * steps_;
      const Motion<R> now = held_motion(time, Stage::start, actuators_.at_start());
      end(going, judge(state_, now), now);
      going = going & running_;
      const State<R> next =
          rk4_step(state_, now.rate(state_), h, [&](Stage stage, const State<R>& x) {
            const bool middle = stage == Stage::middle;
            const R stage_time = time + R(middle ? 0.5 * h : h);
            return motion(plant_, x, pose_of(plant_, x),
                          loads_at(stage_time, stage,
                                   middle ? actuators_.at_middle() : actuators_.at_end(), pushes_))
                .rate(x);
          });
      state_ = select_state<R>(going, next, state_);
      steps_ += select(going, R(1.0), R(0.0));
      for (std::size_t i = 0; i < 2; ++i) {
        held_[i].y = select(going, actuators_.at_end()[i].y, held_[i].y);
        held_[i].z = select(going, actuators_.at_end()[i].z, held_[i].z);
      }
      pose_ = pose_of(plant_, state_);
      ++clock_;
    }
    // What the forces held until now have led to; of a slack the next command decides.
    const Motion<R> after = held_motion(R(h) * steps_, Stage::end, held_);
    Verdict<R> verdict = judge(state_, after);
    verdict.slack = {};
    const mask_t<R> last = moving & running_;
    for (std::size_t i = 0; i < 2; ++i) tension_[i] = select(last, after.tension[i], tension_[i]);
    end(last, verdict, after);
    running_ = running_ & (steps_ < all_steps);
    measure(moving);
  }

  const Pose<R>& pose() const { return pose_; }
  const State<R>& state() const { return state_; }
  const std::array<R, 2>& tension() const { return tension_; }  // N
  const R& steps() const { return steps_; }                     // integration steps taken
  const Measurement<R>& measured() const { return measured_; }  // what a law is told now
  const mask_t<R>& running() const { return running_; }

  /// How world k ended, unless it runs, and which cable or angle is to blame.
  std::pair<Status, int> ending(int k) const {
    const auto i = static_cast<std::size_t>(k);
    return {ending_[i], culprit_[i]};
  }

 private:
  static constexpr auto width = static_cast<std::size_t>(lanes_of<R>);

  MULTILIFT_INLINE Motion<R> held_motion(const R& time, Stage stage,
                                         const Command<R>& applied) const {
    return motion(plant_, state_, pose_, loads_at(time, stage, applied, pushes_));
  }

  MULTILIFT_INLINE void end(const mask_t<R>& whose, const Verdict<R>& verdict,
                            const Motion<R>& now) {
    const mask_t<R> ending = whose & verdict.any_cause();
    if (!any(ending)) return;
    for (int k = 0; k < lanes_of<R>; ++k) {
      if (!lane(ending, k)) continue;
      const auto i = static_cast<std::size_t>(k);
      std::tie(ending_[i], culprit_[i]) = verdict.world(k);
      for (std::size_t c = 0; c < 2; ++c) set_lane(tension_[c], k, lane(now.tension[c], k));
    }
    running_ = running_ & !ending;
  }

  /// What worlds of the mask are told at this control instant.
  void measure(const mask_t<R>& whose) {
    sensors_.observe(clock_, steps_, state_, pose_);
    const Measurement<R> now = sensors_.read(clock_, state_, pose_);
    measured_.visit_scalars(now, [&](R& mine, const R& its) { mine = select(whose, its, mine); });
    const auto saturated = actuators_.saturated();
    for (std::size_t i = 0; i < 2; ++i)
      measured_.saturated[i] = (whose & saturated[i]) | ((!whose) & measured_.saturated[i]);
  }

  Plant<R> plant_;
  Actuators actuators_;
  Sensors sensors_;
  std::vector<Push<R>> pushes_;
  State<R> state_;
  Pose<R> pose_;
  R steps_{0.0};
  Command<R> held_;  // the forces that acted last
  std::array<R, 2> tension_{R(0.0), R(0.0)};
  Measurement<R> measured_;
  long clock_{0};
  mask_t<R> running_ = R(0.0) < R(1.0);
  std::array<Status, width> ending_;
  std::array<int, width> culprit_;
};

}  // namespace multilift::planar
