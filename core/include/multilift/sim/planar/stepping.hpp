// Worlds stepped from outside: forces in, held for one control period, the state out.
//
// Plant, integrator, pushes and endings are those of rollout.hpp; the law is the caller's. A world
// that ends stays as it was then, whatever its neighbours do.
#pragma once

#include "multilift/sim/planar/actuators.hpp"
#include "multilift/sim/planar/rollout.hpp"

namespace multilift::planar {

template <Real R>
class Stepping {
 public:
  /// All worlds at their starts, at time 0. The tensions are those of no command.
  Stepping(const Plant<R>& plant, const Plant<R>& assumed, const State<R>& start,
           std::vector<Push<R>> pushes)
      : plant_(plant),
        actuators_(assumed, plant),
        pushes_(std::move(pushes)),
        state_(start),
        pose_(pose_of(plant, start)) {
    actuators_.command(0, {});
    tension_ = held_motion(R(0.0), Stage::start).tension;
    ending_.fill(Status::finished);
    culprit_.fill(-1);
  }

  /// Puts back those worlds of `mask` as they are in `other`, their parameters being equal.
  void keep(const Stepping& other, const mask_t<R>& mask) {
    state_ = select_state<R>(mask, other.state_, state_);
    pose_ = pose_of(plant_, state_);
    steps_ = select(mask, other.steps_, steps_);
    for (std::size_t i = 0; i < 2; ++i) tension_[i] = select(mask, other.tension_[i], tension_[i]);
    for (int k = 0; k < lanes_of<R>; ++k) {
      if (!lane(mask, k)) continue;
      const auto i = static_cast<std::size_t>(k);
      ending_[i] = other.ending_[i];
      culprit_[i] = other.culprit_[i];
    }
    running_ = (mask & other.running_) | ((!mask) & running_);
  }

  /// Holds u for a control period of the timing, or as far as each world goes. As in a rollout, a
  /// cable's slack counts at the start of each integration step, under the command that acts there.
  void advance(const Command<R>& u, const Timing& timing) {
    const double h = timing.step;
    const R all_steps(static_cast<double>(timing.steps));
    actuators_.command(0, u);
    const mask_t<R> moving = running_;
    for (long j = 0; j < timing.control_steps; ++j) {
      mask_t<R> going = running_ & (steps_ < all_steps);
      if (!any(going)) break;
      const R time = R(h) * steps_;
      const Motion<R> now = held_motion(time, Stage::start);
      end(going, judge(state_, now), now);
      going = going & running_;
      const State<R> next =
          rk4_step(state_, now.rate(state_), h, [&](Stage stage, const State<R>& x) {
            const R stage_time = time + R(stage == Stage::middle ? 0.5 * h : h);
            return motion(plant_, x, pose_of(plant_, x),
                          loads_at(stage_time, stage, actuators_.at_start(), pushes_))
                .rate(x);
          });
      state_ = select_state<R>(going, next, state_);
      steps_ += select(going, R(1.0), R(0.0));
      pose_ = pose_of(plant_, state_);
    }
    // What the forces held until now have led to; of a slack the next command decides.
    const Motion<R> after = held_motion(R(h) * steps_, Stage::end);
    Verdict<R> verdict = judge(state_, after);
    verdict.slack = {};
    const mask_t<R> last = moving & running_;
    for (std::size_t i = 0; i < 2; ++i) tension_[i] = select(last, after.tension[i], tension_[i]);
    end(last, verdict, after);
    running_ = running_ & (steps_ < all_steps);
  }

  const Pose<R>& pose() const { return pose_; }
  const State<R>& state() const { return state_; }
  const std::array<R, 2>& tension() const { return tension_; }  // N
  const R& steps() const { return steps_; }                     // integration steps taken
  const mask_t<R>& running() const { return running_; }

  /// How world k ended, unless it runs, and which cable or angle is to blame.
  std::pair<Status, int> ending(int k) const {
    const auto i = static_cast<std::size_t>(k);
    return {ending_[i], culprit_[i]};
  }

 private:
  static constexpr auto width = static_cast<std::size_t>(lanes_of<R>);

  MULTILIFT_INLINE Motion<R> held_motion(const R& time, Stage stage) const {
    return motion(plant_, state_, pose_, loads_at(time, stage, actuators_.at_start(), pushes_));
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

  Plant<R> plant_;
  IdealActuators<R> actuators_;
  std::vector<Push<R>> pushes_;
  State<R> state_;
  Pose<R> pose_;
  R steps_{0.0};
  std::array<R, 2> tension_{R(0.0), R(0.0)};
  mask_t<R> running_ = R(0.0) < R(1.0);
  std::array<Status, width> ending_;
  std::array<int, width> culprit_;
};

}  // namespace multilift::planar
