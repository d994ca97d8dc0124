// One spatial run: plant, law, link, autopilots and motion capture stepped together at a fixed
// step.
#pragma once

#include <utility>

#include "multilift/control/spatial/laws.hpp"
#include "multilift/sim/spatial/audit.hpp"
#include "multilift/sim/spatial/columns.hpp"
#include "multilift/sim/spatial/world.hpp"
#include "multilift/sim/status.hpp"

namespace multilift::spatial {

template <Real R, class Vehicles, class Cables, class Actuation>
class Rollout {
 public:
  using W = World<R, Vehicles, Cables>;
  using S = typename W::S;
  using V = typename W::V;

  Rollout(const S& setup, Law<R>& law, Actuation actuation)
      : world_(setup),
        s_(world_.setup()),
        x_(world_.x()),
        law_(law),
        actuation_(std::move(actuation)),
        n_(setup.start.size()),
        audit_(setup.plant, law.storage_gains()),
        targets_{Target<R>(n_), Target<R>(n_), Target<R>(n_)},
        measured_(n_),
        saturated_(n_),
        metrics_(rest_directions(setup.formation)),
        capture_(motion_capture_of(setup)) {
    s_.reference.at(0.0, targets_[0]);
    targets_[1] = targets_[2] = targets_[0];
    command_ = first_command(setup, targets_[0]);
    transmission_.emplace(s_.link, s_.limits, s_.timing.step, s_.timing.control_steps, s_.seeds,
                          command_);
  }

  /// Runs to the end of the timing; each world of a batch only until it collides or diverges.
  /// record(sample, whose) is called every record_steps and once more at each world's end;
  /// finish(k, status, culprit, time, x, metrics, audit) once a world, culprits being vehicles.
  template <class Record, class Finish>
  void run(Record&& record, Finish&& finish) {
    const double h = s_.timing.step;
    mask_t<R> alive = R(0.0) < R(1.0);
    audit_.begin(x_, targets_[0], law_.drag_estimate());
    for (long k = 0;; ++k) {
      const double time = world_.time_of(k);
      if (k > 0 && !s_.reference.stands()) std::swap(targets_[0], targets_[2]);
      control(k, time);
      actuation_.drive(k, x_.vehicle, transmission_->receive(k), world_.input());
      world_.fail(k);
      const Instant<R>& now = world_.observe(k);

      const Sample<R, V> sample{time,
                                s_.plant,
                                x_,
                                now,
                                targets_[0],
                                world_.stepper().taut(),
                                command_.force,
                                law_.drag_estimate(),
                                audit_.storage(x_, targets_[0])};
      const mask_t<R> diverged = !world_.bounded(now);
      mask_t<R> collided = R(0.0) < R(0.0);
      if (k % distance_steps == 0) collided = keep_clear(now);
      const bool last = k == s_.timing.steps;
      const mask_t<R> ending =
          alive & (diverged | collided | mask_t<R>(R(0.0) < R(last ? 1.0 : 0.0)));
      if (any(ending)) {
        record(sample, ending);
        end(sample, ending, diverged, collided, finish);
        alive = alive & !ending;
        if (!any(alive)) return;
      }
      audit_.compare(sample.storage);
      metrics_.update(sample, h);
      if (k % s_.timing.record_steps == 0) record(sample, alive);
      advance(k);
    }
  }

 private:
  void control(long k, double time) {
    if (capture_) capture_->observe(k, x_);
    if (k % s_.timing.control_steps != 0) return;
    if (k > 0) audit_.adapt(law_.drag_estimate());
    if (capture_)
      measured_ = capture_->read(k);
    else
      tell_truth(x_, measured_);
    measured_.time = time;
    for (std::size_t i = 0; i < n_; ++i)
      measured_.saturated[i].is = saturated_[i].is | actuation_.saturated(i);
    law_.step(measured_, targets_[0], command_.force);
    command_.yaw = targets_[0].yaw;
    sent_ = command_;
    transmission_->send(k, sent_, saturated_);
  }

  void advance(long k) {
    if (s_.reference.stands()) {
      audit_.next_step({&targets_[0], &targets_[0], &targets_[0]});
    } else {
      s_.reference.at(world_.time_of(k) + 0.5 * s_.timing.step, targets_[1]);
      s_.reference.at(world_.time_of(k + 1), targets_[2]);
      audit_.next_step({&targets_[0], &targets_[1], &targets_[2]});
    }
    world_.advance(k, audit_);
  }

  mask_t<R> keep_clear(const Instant<R>& now) {
    const Clearance<R> found = world_.clearance(now);
    metrics_.keep_clearance(found);
    return world_.collided(found);
  }

  template <class Finish>
  void end(const Sample<R, V>& sample, const mask_t<R>& ending, const mask_t<R>& diverged,
           const mask_t<R>& collided, Finish&& finish) {
    for (int k = 0; k < lanes_of<R>; ++k) {
      if (!lane(ending, k)) continue;
      const bool lost = lane(diverged, k);
      Metrics<R> metrics = metrics_;
      Audit<R, V> audit = audit_;
      metrics.keep_events(world_.stepper().events());
      const Status status = lost                ? Status::diverged
                            : lane(collided, k) ? Status::collision
                                                : Status::finished;
      // A state without meaning belongs neither to the metrics nor to the audit.
      if (!lost) {
        metrics.update(sample, 0.0);
        audit.compare(sample.storage);
      }
      if (status != Status::finished) metrics.cut_short(k);
      finish(k, status, sample.time, x_, metrics, audit);
    }
    world_.retire(ending);
  }

  W world_;
  const S& s_;              // the world's
  const typename W::X& x_;  // the world's
  Law<R>& law_;
  Actuation actuation_;
  std::size_t n_;
  Audit<R, V> audit_;
  std::array<Target<R>, 3> targets_;  // at the start, middle and end of a step
  Measurement<R> measured_;
  ForceCommand<R> command_, sent_;
  Masks<R> saturated_;
  Metrics<R> metrics_;
  std::optional<Transmission<R>> transmission_;
  std::optional<MotionCapture<R>> capture_;
};

}  // namespace multilift::spatial
