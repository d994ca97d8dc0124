// The plant of one run, or of several side by side, under way: bodies, cables, air, pushes, and
// what breaks. Who drives the vehicles, and what is recorded of it, is not its business.
#pragma once

#include "multilift/sim/spatial/setup.hpp"
#include "multilift/sim/spatial/stepper.hpp"

namespace multilift::spatial {

/// Integration step k goes: input() is set, fail(k), observe(k), advance(k); k counts up from 0.
template <Real R, class Vehicles, class Cables>
class World {
 public:
  using S = Setup<R, Vehicles, Cables>;
  using V = typename Vehicles::State;
  using X = State<R, V>;
  using D = Dynamics<R, Vehicles, Cables>;
  using Input = typename Vehicles::Input;

  explicit World(const S& setup)
      : s_(setup),
        x_(setup.start),
        stepper_(D(setup.plant, setup.vehicles, setup.ground), x_.size()),
        wind_(setup.wind, setup.timing.step, setup.seeds),
        input_(x_.size()),
        outside_(x_.size()) {
    outside_.pushes = !s_.pushes.empty();
    stepper_.begin(x_);
  }

  /// What breaks at step k or broke before: cables are cut, and rotors that stopped turn no more,
  /// whatever input() says.
  void fail(long k) {
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

  /// Something more that shall break.
  void expect(const Happening& event) { s_.happenings.push_back(event); }

  /// What holds at the start of step k.
  const Instant<R>& observe(long k) {
    outside_.wind = wind_.at(k);
    if (outside_.pushes) add_pushes(s_.pushes, R(time_of(k)), Stage::start, outside_);
    return stepper_.observe(x_, input_, outside_);
  }

  /// Step k from what was observed; `ledger` as in stepper.hpp.
  template <class Ledger>
  void advance(long k, Ledger&& ledger) {
    const double time = time_of(k);
    stepper_.step(
        x_, input_, s_.timing.step,
        [&](const R& since, Stage stage) -> const Surroundings<R>& {
          if (outside_.pushes) add_pushes(s_.pushes, R(time) + since, stage, outside_);
          return outside_;
        },
        ledger);
  }

  mask_t<R> collided(const Clearance<R>& found) const {
    return (found.vehicles < s_.safety.vehicle_distance) |
           (found.cables < s_.safety.cable_distance);
  }

  /// Whether every number is far inside any flight's range; false for NaN too.
  mask_t<R> bounded(const Instant<R>& now) const {
    const R bound(1e6);
    R sum(0.0);
    RigidBody<R> payload = x_.payload;
    zip([&](const R& number) { sum += abs(number); }, payload);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const V& v = x_.vehicle[i];
      sum += abs(v.position.x) + abs(v.position.y) + abs(v.position.z);
      sum += abs(v.velocity.x) + abs(v.velocity.y) + abs(v.velocity.z);
      sum += abs(now.motion.tension[i]);
      if constexpr (requires { v.rate; }) sum += abs(v.rate.x) + abs(v.rate.y) + abs(v.rate.z);
    }
    return sum <= bound;
  }

  /// Worlds that have ended must not hold up their neighbours: back to the start, without cables.
  void retire(const mask_t<R>& ended) {
    for (std::size_t i = 0; i < x_.size(); ++i) stepper_.cut(i, ended);
    zip([&](R& now, const R& start) { now = select(ended, start, now); }, x_, s_.start);
  }

  double time_of(long k) const { return s_.timing.step * static_cast<double>(k); }
  const S& setup() const { return s_; }
  const X& x() const { return x_; }
  /// What drives the vehicles until it is set anew.
  std::vector<Input>& input() { return input_; }
  const std::vector<Input>& input() const { return input_; }
  const Surroundings<R>& outside() const { return outside_; }
  Clearance<R> clearance(const Instant<R>& now) const {
    return clearance_of(s_.plant, x_, now, stepper_.whole());
  }
  const Stepper<R, D>& stepper() const { return stepper_; }

 private:
  S s_;
  X x_;
  Stepper<R, D> stepper_;
  Wind<R> wind_;
  std::vector<Input> input_;
  Surroundings<R> outside_;
};

}  // namespace multilift::spatial
