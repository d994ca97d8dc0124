// One world that is stepped from outside, by commands as a run's law gives them, or closer to the
// rotors: attitudes and thrusts, or motors. The same commands make it go the same way as a run
// (rollout.hpp), bit for bit.
#pragma once

#include <utility>

#include "multilift/sim/spatial/world.hpp"
#include "multilift/sim/status.hpp"

namespace multilift::spatial {

/// Something that happened, known at the start of the integration step after it.
struct Incident {
  double time;  // s
  const char* what;
  int vehicle;  // -1 the payload, or nobody's
};

/// A stepper's ledger that keeps nothing.
template <class X>
struct NoLedger {
  void restart() {}
  template <class... Anything>
  void add(const Anything&...) {}
  void book() {}
  void before_jump(const X&) {}
  void after_jump(const X&) {}
};

/// What drives vehicles of a kind; by their own control, where they have one.
template <class Vehicles>
struct DriveOf {
  using Type = DirectForce<double>;
};
template <>
struct DriveOf<Quadrotors<double>> {
  using Type = Autopilots<double>;
};

template <class Vehicles, class Cables>
class SteppedWorld {
 public:
  using W = World<double, Vehicles, Cables>;
  using Drive = typename DriveOf<Vehicles>::Type;
  static constexpr bool turning = std::is_same_v<Vehicles, Quadrotors<double>>;

  SteppedWorld(const typename W::S& setup, Drive drive)
      : world_(setup),
        scratch_(world_.stepper()),
        drive_(std::move(drive)),
        n_(setup.start.size()),
        target_(n_),
        measured_(n_),
        saturated_(n_),
        taut_(n_, true),
        standing_(n_ + 1, false),
        capture_(motion_capture_of(setup)) {
    setup.reference.at(0.0, target_);
    command_ = first_command(setup, target_);
    // Commands may come at every integration step.
    transmission_.emplace(setup.link, setup.limits, setup.timing.step, 1L, setup.seeds, command_);
    if constexpr (!turning) world_.input() = command_.force;
    if (capture_) capture_->observe(0, world_.x());
    sense();
    watch(look());
    incidents_.clear();
  }

  /// Forces, W, N, held for `steps` integration steps, through limits, link and the vehicles' own
  /// control; their heading, rad, or the reference's.
  void step_forces(const std::vector<Vec3<double>>& force, std::optional<double> yaw, long steps) {
    const auto& setup = world_.setup();
    if (!yaw) setup.reference.at(time(), target_);
    command_.force = force;
    command_.yaw = yaw ? *yaw : target_.yaw;
    if (running()) transmission_->send(k_, command_, saturated_);
    go(steps,
       [&] { drive_.drive(k_, world_.x().vehicle, transmission_->receive(k_), world_.input()); });
  }

  /// What quadrotors' own control follows for `steps` integration steps.
  void step_set_points(const std::vector<AttitudeThrust<double>>& wanted, long steps)
    requires turning
  {
    uncut();
    go(steps, [&] { drive_.follow(k_, world_.x().vehicle, wanted, world_.input()); });
  }

  /// Motor commands of quadrotors, parts of the greatest rotor speed, held for `steps` integration
  /// steps; 0 stops a rotor, and nothing else makes it slower than its least speed.
  void step_motors(const std::vector<std::array<double, rotors>>& part, long steps)
    requires turning
  {
    uncut();
    const auto& craft = world_.setup().vehicles.parameters();
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t r = 0; r < rotors; ++r) {
        const double t = clamp(part[i][r], 0.0, 1.0);
        const double speed = std::fmax(t * craft.rotor_speed_max[i], craft.rotor_speed_min[i]);
        world_.input()[i][r] = t > 0.0 ? speed : 0.0;
      }
    go(steps, [] {});
  }

  /// Something breaks from now on.
  void fail(Failure what, std::size_t vehicle, std::size_t rotor) {
    world_.expect({what, vehicle, rotor, k_});
  }

  double time() const { return world_.time_of(k_); }
  bool running() const { return !ended_; }
  /// Why it ended: collision or divergence.
  const std::optional<Status>& ended() const { return ended_; }
  const W& world() const { return world_; }
  /// What holds now, under what drives the vehicles until they are told otherwise.
  const Instant<double>& now() const { return *now_; }
  const Masks<double>& taut() const { return scratch_.taut(); }
  const Measurement<double>& measured() const { return measured_; }
  bool saturated(std::size_t i) const { return saturated_[i].is || drive_.saturated(i); }
  const std::vector<Incident>& incidents() const { return incidents_; }

  /// What an accelerometer on vehicle i feels: its acceleration less gravity, body axes, m/s^2.
  Vec3<double> specific_force(std::size_t i) const {
    const auto& plant = world_.setup().plant;
    const Vec3<double> all =
        now_->loads.vehicle[i] - now_->motion.tension[i] * now_->cable[i].direction;
    Vec3<double> felt = plant.inverse_mass[i] * all;
    felt.z += plant.gravity;
    if constexpr (turning) felt = rotation(world_.x().vehicle[i].attitude).to_body(felt);
    return felt;
  }

  Clearance<double> clearance() const { return world_.clearance(*now_); }

 private:
  template <class DriveOn>
  void go(long steps, DriveOn&& drive_on) {
    for (; steps > 0 && running(); --steps) {
      drive_on();
      fail_now();
      const Instant<double>& now = world_.observe(k_);
      watch(now);
      check(now);
      if (!running()) break;
      world_.advance(k_, NoLedger<typename W::X>{});
      ++k_;
      if (capture_) capture_->observe(k_, world_.x());
    }
    const Instant<double>& now = look();
    if (running()) {
      watch(now);
      check(now);
    }
    sense();
  }

  void fail_now() {
    for (const Happening& event : world_.setup().happenings)
      if (event.step == k_) tell(name_of(event.what), static_cast<int>(event.vehicle));
    world_.fail(k_);
  }

  static const char* name_of(Failure what) {
    switch (what) {
      case Failure::cable_cut:
        return "cable_cut";
      case Failure::rotor_stopped:
        return "rotor_stopped";
      case Failure::vehicle_lost:
        return "vehicle_lost";
    }
    return "";
  }

  void uncut() {
    for (auto& mask : saturated_) mask.is = false;
  }

  /// What would be observed now, with the world left as it is for those who command it next.
  const Instant<double>& look() {
    scratch_ = world_.stepper();
    Surroundings<double> outside = world_.outside();
    add_pushes(world_.setup().pushes, time(), Stage::start, outside);
    now_ = &scratch_.observe(world_.x(), world_.input(), outside);
    return *now_;
  }

  void sense() {
    if (capture_)
      measured_ = capture_->read(k_);
    else
      tell_truth(world_.x(), measured_);
    measured_.time = time();
  }

  void check(const Instant<double>& now) {
    if (!world_.bounded(now))
      ended_ = Status::diverged;
    else if (k_ % distance_steps == 0 && world_.collided(world_.clearance(now)))
      ended_ = Status::collision;
    if (ended_) tell(multilift::name_of(*ended_), -1);
  }

  void watch(const Instant<double>& now) {
    for (std::size_t i = 0; i < n_; ++i)
      note(taut_, i, now.motion.tension[i] > 0.0, {"taut", "slack"}, static_cast<int>(i));
    if (!world_.setup().ground) return;
    for (std::size_t i = 0; i < n_; ++i)
      note(standing_, i, now.contact[i].z > 0.0, {"touch_down", "lift_off"}, static_cast<int>(i));
    note(standing_, n_, now.payload_contact.z > 0.0, {"touch_down", "lift_off"}, -1);
  }

  void note(std::vector<bool>& was, std::size_t i, bool is, std::array<const char*, 2> names,
            int vehicle) {
    if (was[i] != is) tell(names[is ? 0 : 1], vehicle);
    was[i] = is;
  }

  void tell(const char* what, int vehicle) { incidents_.push_back({time(), what, vehicle}); }

  W world_;
  Stepper<double, typename W::D> scratch_;
  const Instant<double>* now_{nullptr};  // the scratch's
  Drive drive_;
  std::size_t n_;
  long k_{0};
  Target<double> target_;
  ForceCommand<double> command_;
  Measurement<double> measured_;
  Masks<double> saturated_;
  std::vector<bool> taut_, standing_;  // the payload is the last that may stand
  std::vector<Incident> incidents_;
  std::optional<Status> ended_;
  std::optional<Transmission<double>> transmission_;
  std::optional<MotionCapture<double>> capture_;
};

}  // namespace multilift::spatial
