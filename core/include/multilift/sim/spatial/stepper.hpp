// One integration step of the spatial plant, through whatever its cables do on the way.
//
// Between two events the classical Runge-Kutta step of order 4. An event is a rigid cable that goes
// slack, its tension passing through zero, or one that is pulled taut, its length reaching the rest
// length; its time is found by bisection, the step is taken to there, the cable changes, and the
// rest of the step follows. Worlds side by side have events of their own.
#pragma once

#include <utility>

#include "multilift/model/spatial/dynamics.hpp"
#include "multilift/sim/rk4.hpp"

namespace multilift::spatial {

/// How finely an event's time is found, as a part of the step: 2^-20, a nanosecond of a
/// millisecond.
inline constexpr int event_halvings = 20;
/// A slack cable this much longer than its rest length counts as pulled taut, m.
inline constexpr double contact_tolerance = 1e-7;
/// Slower rebounds of a cable pulled taut are none, m/s.
inline constexpr double least_rebound = 0.02;
/// A slack cable at its full length that changes it no faster than this may pull again, m/s. One
/// that stretches faster is on its way into a jerk, which takes an impulse.
inline constexpr double grazing_speed = 1e-5;
/// More events within one step wait for its end.
inline constexpr int most_events = 24;

/// What the rigid cables of each world did so far.
template <Real R>
struct CableEvents {
  R impacts{0.0};          // how many times cables were pulled taut
  R energy_lost{0.0};      // in these, J
  R hardest_impulse{0.0};  // of one cable in one of them, N s
};

/// Takes out of `who`, in each world of `where`, the entry with the least pull, if that is
/// negative.
template <Real R>
bool drop_most_pushing(const std::vector<R>& pull, Masks<R>& who, const mask_t<R>& where) {
  const R zero(0.0);
  R worst(0.0);
  for (const R& x : pull) worst = min(worst, x);
  const mask_t<R> some = where & (worst < zero);
  if (!any(some)) return false;
  for (std::size_t i = 0; i < who.size(); ++i) who[i].is = who[i].is & !(some & (pull[i] <= worst));
  return true;
}

/// `Ledger` is told of every evaluation that the result is made of: restart() forgets what was not
/// booked, add(weight, stage, x, instant, surroundings) has the weight in s, book() keeps it;
/// before_jump(x) and after_jump(x) stand around an impact.
template <Real R, class Dynamics>
class Stepper {
 public:
  using X = typename Dynamics::X;
  using Input = typename Dynamics::Input;

  Stepper(const Dynamics& dynamics, std::size_t n)
      : dynamics_(dynamics),
        taut_(n, {R(0.0) < R(1.0)}),
        whole_(taut_),
        candidate_(taut_),
        released_(taut_),
        now_(n),
        later_(n),
        stage_(n),
        k1_(n),
        k_(n),
        sum_(n),
        trial_(n),
        impulse_(n),
        target_(n) {}

  /// Decides at x which rigid cables start taut: those at full length, or beyond, that do not
  /// stretch.
  void begin(const X& x) {
    if constexpr (!Dynamics::Cables::rigid) return;
    dynamics_.lay_cables(x, now_);
    for (std::size_t i = 0; i < x.size(); ++i)
      taut_[i].is = (rest_length(i) - R(contact_tolerance) <= now_.cable[i].length) &
                    (now_.cable[i].stretch_rate <= R(grazing_speed));
  }

  /// Cuts cable i in the worlds of `mask`.
  void cut(std::size_t i, const mask_t<R>& mask) {
    whole_[i].is = whole_[i].is & !mask;
    taut_[i].is = taut_[i].is & whole_[i].is;
  }

  /// Works out what holds at x; cables that would push go slack.
  const Instant<R>& observe(const X& x, const std::vector<Input>& input,
                            const Surroundings<R>& outside) {
    dynamics_.evaluate(x, input, outside, taut_, now_);
    if constexpr (Dynamics::Cables::rigid) {
      for (Mask<R>& mask : candidate_) mask.is = R(0.0) < R(1.0);
      settle(x, R(0.0) < R(1.0));
    }
    return now_;
  }

  /// Moves x on by h from the instant last observed, `input` being held. outside_at(r, stage) gives
  /// the surroundings a time r, s, after that instant.
  template <class OutsideAt, class Ledger>
  void step(X& x, const std::vector<Input>& input, double h, OutsideAt&& outside_at,
            Ledger&& ledger) {
    R left(h), done(0.0);
    if constexpr (Dynamics::Cables::rigid) {
      for (int event = 0; event < most_events; ++event) {
        // Worlds whose step is over wait for those that have events still.
        const mask_t<R> going = R(0.0) < left;
        if (!any(going)) return;
        runge_kutta(x, input, done, left, outside_at, ledger);
        const mask_t<R> breach = going & breach_at(trial_);
        if (!any(breach)) return accept(x, going, ledger);
        const R piece = time_of_event(x, input, done, left, breach, outside_at, ledger);
        accept(x, going, ledger);
        change(x, breach, ledger);
        done += piece;
        left -= piece;
        dynamics_.evaluate(x, input, outside_at(done, Stage::start), taut_, now_);
        settle(x, breach);
      }
    }
    runge_kutta(x, input, done, left, outside_at, ledger);
    accept(x, R(0.0) < left, ledger);
  }

  const Masks<R>& taut() const { return taut_; }
  const Masks<R>& whole() const { return whole_; }  // those not cut
  const CableEvents<R>& events() const { return events_; }
  const Dynamics& dynamics() const { return dynamics_; }

 private:
  const R& rest_length(std::size_t i) const { return dynamics_.plant().cable_length[i]; }

  /// From x and now_ over h, which may differ from world to world, into trial_; later_ is left at
  /// the last stage.
  template <class OutsideAt, class Ledger>
  MULTILIFT_INLINE void runge_kutta(const X& x, const std::vector<Input>& input, const R& done,
                                    const R& h, OutsideAt&& outside_at, Ledger&& ledger) {
    const R half = R(0.5) * h, third = R(1.0 / 3.0) * h, sixth = R(1.0 / 6.0) * h;
    ledger.restart();
    ledger.add(sixth, Stage::start, x, now_, outside_at(done, Stage::start));
    const auto stage = [&](const X& k, const R& ahead, Stage at, const R& weight) {
      zip([&](R& s, const R& a, const R& b) { s = a + ahead * b; }, stage_, x, k);
      const Surroundings<R>& outside = outside_at(done + ahead, at);
      dynamics_.evaluate(stage_, input, outside, taut_, later_);
      dynamics_.rate(stage_, input, later_, k_);
      ledger.add(weight, at, stage_, later_, outside);
    };
    dynamics_.rate(x, input, now_, k1_);
    stage(k1_, half, Stage::middle, third);
    zip([](R& s, const R& a, const R& b) { s = a + R(2.0) * b; }, sum_, k1_, k_);
    stage(k_, half, Stage::middle, third);
    zip([](R& s, const R& a) { s += R(2.0) * a; }, sum_, k_);
    stage(k_, h, Stage::end, sixth);
    zip([&](R& out, const R& a, const R& s, const R& b) { out = a + sixth * (s + b); }, trial_, x,
        sum_, k_);
  }

  /// What was tried becomes the state of the worlds of `going`. The others keep theirs to the bit.
  template <class Ledger>
  MULTILIFT_INLINE void accept(X& x, const mask_t<R>& going, Ledger&& ledger) {
    normalise(trial_);
    if (all(going))
      std::swap(x, trial_);
    else
      zip([&](R& now, const R& next) { now = select(going, next, now); }, x, trial_);
    ledger.book();
  }

  /// Worlds in which, at the end of what was tried, some cable breaks what it was taken for.
  mask_t<R> breach_at(const X& end) {
    const R zero(0.0);
    mask_t<R> breach = zero < zero, slack = breach;
    for (std::size_t i = 0; i < taut_.size(); ++i) {
      breach = breach | (taut_[i].is & (later_.motion.tension[i] < zero));
      slack = slack | (whole_[i].is & !taut_[i].is);
    }
    if (!any(slack)) return breach;
    dynamics_.lay_cables(end, later_);
    for (std::size_t i = 0; i < taut_.size(); ++i)
      breach = breach | (whole_[i].is & !taut_[i].is & jerked(i, later_));
    return breach;
  }

  mask_t<R> jerked(std::size_t i, const Instant<R>& at) const {
    return (rest_length(i) + R(contact_tolerance) < at.cable[i].length) &
           (R(0.0) < at.cable[i].stretch_rate);
  }

  /// How far worlds with a breach go until it is there; those without go all the way. Leaves
  /// trial_ and later_ at that time.
  template <class OutsideAt, class Ledger>
  R time_of_event(const X& x, const std::vector<Input>& input, const R& done, const R& left,
                  const mask_t<R>& breach, OutsideAt&& outside_at, Ledger&& ledger) {
    R before = select(breach, R(0.0), left), after = left;
    for (int k = 0; k < event_halvings; ++k) {
      const R middle = select(breach, R(0.5) * (before + after), left);
      runge_kutta(x, input, done, middle, outside_at, ledger);
      const mask_t<R> still = breach & breach_at(trial_);
      after = select(still, middle, after);
      before = select(still, before, middle);
    }
    runge_kutta(x, input, done, after, outside_at, ledger);
    if constexpr (differentiates<R>) {
      after = moving(after);
      runge_kutta(x, input, done, after, outside_at, ledger);
    }
    return after;
  }

  /// The time of an impact with its derivatives, those that keep the length at trial_ where it is.
  /// A cable that goes slack does so without a jump, for which its time's do not matter.
  R moving(const R& time) {
    dynamics_.lay_cables(trial_, later_);
    for (std::size_t i = 0; i < taut_.size(); ++i) {
      if (!(whole_[i].is && !taut_[i].is && jerked(i, later_))) continue;
      const R over = later_.cable[i].length - rest_length(i);
      return time - (over - R(value(over))) / R(value(later_.cable[i].stretch_rate));
    }
    return time;
  }

  /// At x, where cables of `where` have just broken what they were taken for: those that would push
  /// go slack, those that are stretched take up an impulse.
  template <class Ledger>
  void change(X& x, const mask_t<R>& where, Ledger&& ledger) {
    dynamics_.lay_cables(x, now_);
    mask_t<R> hit = R(0.0) < R(0.0);
    for (std::size_t i = 0; i < taut_.size(); ++i) {
      const mask_t<R> here = where & whole_[i].is & !taut_[i].is & jerked(i, now_);
      released_[i].is = where & taut_[i].is & (later_.motion.tension[i] < R(0.0));
      taut_[i].is = taut_[i].is & !released_[i].is;
      candidate_[i].is = here;
      hit = hit | here;
    }
    if (any(hit)) jerk(x, hit, ledger);
    for (std::size_t i = 0; i < taut_.size(); ++i) candidate_[i].is = !released_[i].is;
  }

  /// The cables of candidate_ are pulled taut, all at once, and pass the jerk on through those that
  /// are taut already.
  template <class Ledger>
  void jerk(X& x, const mask_t<R>& where, Ledger&& ledger) {
    const R zero(0.0);
    const auto& plant = dynamics_.plant();
    for (std::size_t i = 0; i < taut_.size(); ++i) {
      const R rebound = plant.cable_restitution * now_.cable[i].stretch_rate;
      const mask_t<R> bounces = candidate_[i].is & (R(least_rebound) < rebound);
      target_[i] = select(bounces, -rebound, zero);
      taut_[i].is = (taut_[i].is | candidate_[i].is) & !bounces;
      events_.impacts += select(candidate_[i].is, R(1.0), zero);
      candidate_[i].is = where & (candidate_[i].is | taut_[i].is);
    }
    // Cables only pull: the one that would push most leaves, until none does.
    Pair6<R> jump;
    for (std::size_t turn = 0; turn <= taut_.size(); ++turn) {
      for (std::size_t i = 0; i < taut_.size(); ++i)
        impulse_[i] = plant.vehicle_mass[i] * (now_.cable[i].stretch_rate - target_[i]);
      jump = solve_cables(plant, now_.cable, candidate_, {}, {}, impulse_);
      if (!drop_most_pushing(impulse_, candidate_, where)) break;
    }
    ledger.restart();
    ledger.before_jump(x);
    x.payload.velocity += select<R>(where, jump.first, {});
    x.payload.rate += select<R>(where & plant.turns, jump.second, {});
    for (std::size_t i = 0; i < taut_.size(); ++i) {
      const R after = select(candidate_[i].is, target_[i], now_.cable[i].stretch_rate);
      events_.energy_lost += R(0.5) * impulse_[i] * (now_.cable[i].stretch_rate + after);
      events_.hardest_impulse = max(events_.hardest_impulse, impulse_[i]);
      x.vehicle[i].velocity -= (plant.inverse_mass[i] * impulse_[i]) * now_.cable[i].direction;
      // Who left the sum shortens.
      taut_[i].is = taut_[i].is & (candidate_[i].is | !where);
    }
    ledger.after_jump(x);
  }

  /// Which cables pull, in the worlds of `where`, at the instant evaluated in now_: of those of
  /// candidate_ that are slack at their full length, with the taut ones, all that do not push, the
  /// most pushing ones leaving first. Only cables that just went slack are no candidates, lest
  /// round-off undo it.
  void settle(const X& x, const mask_t<R>& where) {
    mask_t<R> admitted = R(0.0) < R(0.0);
    for (std::size_t i = 0; i < taut_.size(); ++i) {
      const Cable<R>& c = now_.cable[i];
      const mask_t<R> again = where & candidate_[i].is & whole_[i].is & !taut_[i].is &
                              (rest_length(i) - R(contact_tolerance) <= c.length) &
                              (abs(c.stretch_rate) <= R(grazing_speed));
      taut_[i].is = taut_[i].is | again;
      admitted = admitted | again;
    }
    if (any(admitted)) dynamics_.evaluate_tensions(x, taut_, now_);
    for (std::size_t turn = 0; turn < taut_.size(); ++turn) {
      if (!drop_most_pushing(now_.motion.tension, taut_, where)) return;
      dynamics_.evaluate_tensions(x, taut_, now_);
    }
  }

  Dynamics dynamics_;
  Masks<R> taut_, whole_, candidate_, released_;
  Instant<R> now_, later_;
  X stage_, k1_, k_, sum_, trial_;
  std::vector<R> impulse_, target_;
  CableEvents<R> events_;
};

}  // namespace multilift::spatial
