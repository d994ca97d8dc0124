// One spatial run: plant, law, link, autopilots and motion capture stepped together at a fixed
// step.
#pragma once

#include <utility>

#include "multilift/control/spatial/laws.hpp"
#include "multilift/sim/spatial/actuation.hpp"
#include "multilift/sim/spatial/audit.hpp"
#include "multilift/sim/spatial/columns.hpp"
#include "multilift/sim/spatial/happenings.hpp"
#include "multilift/sim/spatial/motion_capture.hpp"
#include "multilift/sim/spatial/weather.hpp"
#include "multilift/sim/status.hpp"
#include "multilift/sim/timing.hpp"

namespace multilift::spatial {

/// How close bodies may come before they count as collided, m; 0 lets everything pass.
template <Real R>
struct SafetyParameters {
  R vehicle_distance{0.0};
  R cable_distance{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"vehicle_distance", "m", Range::non_negative,
            "two vehicles closer than this have collided, which ends the run; 0: never"},
      self.vehicle_distance);
    v(Field{"cable_distance", "m", Range::non_negative,
            "a vehicle closer than this to another's cable has collided; 0: never"},
      self.cable_distance);
  }
};

/// Everything about a run besides its law.
template <Real R, class Vehicles, class Cables>
struct Setup {
  using VehicleState = typename Vehicles::State;

  Plant<R> plant;
  Parameters<R> assumed;
  Vehicles vehicles;
  std::optional<Ground<R>> ground;
  State<R, VehicleState> start;
  Formation<R> formation;
  Reference<R> reference;
  LinkParameters<R> link;
  LimitParameters<R> limits;
  std::optional<MotionCaptureParameters<R>> motion_capture;
  WindParameters<R> wind;
  SafetyParameters<R> safety;
  std::vector<Push<R>> pushes;
  std::vector<Happening> happenings;
  Timing timing;
  std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)> seeds{};
};

template <Real R, class Vehicles, class Cables, class Actuation>
class Rollout {
 public:
  using S = Setup<R, Vehicles, Cables>;
  using V = typename Vehicles::State;
  using X = State<R, V>;
  using D = Dynamics<R, Vehicles, Cables>;

  Rollout(const S& setup, Law<R>& law, Actuation actuation)
      : s_(setup),
        law_(law),
        actuation_(std::move(actuation)),
        n_(setup.start.size()),
        x_(setup.start),
        stepper_(D(setup.plant, setup.vehicles, setup.ground), n_),
        audit_(setup.plant, law.storage_gains()),
        wind_(setup.wind, setup.timing.step, setup.seeds),
        targets_{Target<R>(n_), Target<R>(n_), Target<R>(n_)},
        measured_(n_),
        command_(n_),
        input_(n_),
        outside_(n_),
        saturated_(n_),
        metrics_(rest_directions(setup.formation)) {
    outside_.pushes = !s_.pushes.empty();
    s_.reference.at(0.0, targets_[0]);
    targets_[1] = targets_[2] = targets_[0];
    for (std::size_t i = 0; i < n_; ++i) {
      command_.force[i] = targets_[0].cable_force[i];
      command_.force[i].z += s_.assumed.vehicle_mass[i] * s_.assumed.gravity;
    }
    command_.yaw = targets_[0].yaw;
    transmission_.emplace(s_.link, s_.limits, s_.timing.step, s_.timing.control_steps, s_.seeds,
                          command_);
    if (s_.motion_capture) {
      tell_truth(x_, measured_);
      capture_.emplace(*s_.motion_capture, s_.timing.control_steps, s_.timing.step, s_.seeds,
                       measured_);
    }
  }

  /// Runs to the end of the timing; each world of a batch only until it collides or diverges.
  /// record(sample, whose) is called every record_steps and once more at each world's end;
  /// finish(k, status, culprit, time, x, metrics, audit) once a world, culprits being vehicles.
  template <class Record, class Finish>
  void run(Record&& record, Finish&& finish) {
    const double h = s_.timing.step;
    mask_t<R> alive = R(0.0) < R(1.0);
    stepper_.begin(x_);
    audit_.begin(x_, targets_[0], law_.drag_estimate());
    for (long k = 0;; ++k) {
      const double time = h * static_cast<double>(k);
      if (k > 0 && !s_.reference.stands()) std::swap(targets_[0], targets_[2]);
      control(k, time);
      actuate(k);
      outside_.wind = wind_.at(k);
      if (outside_.pushes) add_pushes(s_.pushes, R(time), Stage::start, outside_);
      const Instant<R>& now = stepper_.observe(x_, input_, outside_);

      const Sample<R, V> sample{time,
                                s_.plant,
                                x_,
                                now,
                                targets_[0],
                                stepper_.taut(),
                                command_.force,
                                law_.drag_estimate(),
                                audit_.storage(x_, targets_[0])};
      const mask_t<R> diverged = !bounded(now);
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
      advance(time, h);
    }
  }

 private:
  static std::vector<Vec3<R>> rest_directions(const Formation<R>& formation) {
    std::vector<Vec3<R>> directions;
    for (const Vec3<R>& force : formation.cable_force) {
      const R size = norm(force);
      const R zero(0.0);
      directions.push_back(
          select<R>(zero < size, (R(1.0) / max(size, R(1e-12))) * force, {zero, zero, R(1.0)}));
    }
    return directions;
  }

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

  void actuate(long k) {
    actuation_.drive(k, x_.vehicle, transmission_->receive(k), input_);
    for (const Happening& event : s_.happenings) {
      if (k < event.step) continue;
      switch (event.what) {
        case Failure::cable_cut:
          if (k == event.step) stepper_.cut(event.vehicle, R(0.0) < R(1.0));
          break;
        case Failure::rotor_stopped:
          if constexpr (requires(V v) { v.rotor_speed; })
            input_[event.vehicle][event.rotor] = R(0.0);
          break;
        case Failure::vehicle_lost:
          input_[event.vehicle] = {};
          break;
      }
    }
  }

  void advance(double time, double h) {
    if (s_.reference.stands()) {
      audit_.next_step({&targets_[0], &targets_[0], &targets_[0]});
    } else {
      s_.reference.at(time + 0.5 * h, targets_[1]);
      s_.reference.at(time + h, targets_[2]);
      audit_.next_step({&targets_[0], &targets_[1], &targets_[2]});
    }
    stepper_.step(
        x_, input_, h,
        [&](const R& since, Stage stage) -> const Surroundings<R>& {
          if (outside_.pushes) add_pushes(s_.pushes, R(time) + since, stage, outside_);
          return outside_;
        },
        audit_);
  }

  mask_t<R> keep_clear(const Instant<R>& now) {
    const Clearance<R> found = clearance_of(s_.plant, x_, now);
    metrics_.keep_clearance(found);
    return (found.vehicles < s_.safety.vehicle_distance) |
           (found.cables < s_.safety.cable_distance);
  }

  /// Whether every number is far inside any flight's range; false for NaN too.
  mask_t<R> bounded(const Instant<R>& now) const {
    const R bound(1e6);
    R sum(0.0);
    RigidBody<R> payload = x_.payload;
    zip([&](const R& number) { sum += abs(number); }, payload);
    for (std::size_t i = 0; i < n_; ++i) {
      const V& v = x_.vehicle[i];
      sum += abs(v.position.x) + abs(v.position.y) + abs(v.position.z);
      sum += abs(v.velocity.x) + abs(v.velocity.y) + abs(v.velocity.z);
      sum += abs(now.motion.tension[i]);
      if constexpr (requires { v.rate; }) sum += abs(v.rate.x) + abs(v.rate.y) + abs(v.rate.z);
    }
    return sum <= bound;
  }

  template <class Finish>
  void end(const Sample<R, V>& sample, const mask_t<R>& ending, const mask_t<R>& diverged,
           const mask_t<R>& collided, Finish&& finish) {
    for (int k = 0; k < lanes_of<R>; ++k) {
      if (!lane(ending, k)) continue;
      const bool lost = lane(diverged, k);
      Metrics<R> metrics = metrics_;
      Audit<R, V> audit = audit_;
      metrics.keep_events(stepper_.events());
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
    // What has ended must not hold up its neighbours: back to the start, without cables.
    for (std::size_t i = 0; i < n_; ++i) stepper_.cut(i, ending);
    zip([&](R& now, const R& start) { now = select(ending, start, now); }, x_, s_.start);
  }

  S s_;
  Law<R>& law_;
  Actuation actuation_;
  std::size_t n_;
  X x_;
  Stepper<R, D> stepper_;
  Audit<R, V> audit_;
  Wind<R> wind_;
  std::array<Target<R>, 3> targets_;  // at the start, middle and end of a step
  Measurement<R> measured_;
  ForceCommand<R> command_, sent_;
  std::vector<typename Vehicles::Input> input_;
  Surroundings<R> outside_;
  Masks<R> saturated_;
  Metrics<R> metrics_;
  std::optional<Transmission<R>> transmission_;
  std::optional<MotionCapture<R>> capture_;
};

}  // namespace multilift::spatial
