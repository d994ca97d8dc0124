// From the state to what the control law is told.
//
// `Truth` tells the state at the control instant. `MotionCapture` samples at its own rate, blurs
// each value with white Gaussian noise, delivers late or not at all, may freeze, and may take two
// vehicles for one another.
#pragma once

#include <cstdint>

#include "multilift/control/spatial/law.hpp"
#include "multilift/math/normal.hpp"
#include "multilift/sim/lossy_line.hpp"
#include "multilift/sim/steps.hpp"

namespace multilift::spatial {

template <Real R>
struct MotionCaptureParameters {
  R period{0.0};
  R delay{0.0};
  R position_noise{0.0};
  R velocity_noise{0.0};
  R attitude_noise{0.0};
  R rate_noise{0.0};
  R dropout{0.0};
  R freeze_start{0.0};
  R freeze_duration{0.0};
  R swap_start{0.0};
  R swap_duration{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"period", "s", Range::non_negative,
            "between two samples, a multiple of the step; 0 samples at every control instant"},
      self.period);
    v(Field{"delay", "s", Range::non_negative,
            "from capture to the control law; a multiple of the step"},
      self.delay);
    v(Field{"position_noise", "m", Range::non_negative,
            "standard deviation of each measured position"},
      self.position_noise);
    v(Field{"velocity_noise", "m/s", Range::non_negative,
            "standard deviation of each measured velocity"},
      self.velocity_noise);
    v(Field{"attitude_noise", "rad", Range::non_negative,
            "standard deviation of the payload's measured attitude about each axis"},
      self.attitude_noise);
    v(Field{"rate_noise", "rad/s", Range::non_negative,
            "standard deviation of the payload's measured angular rate"},
      self.rate_noise);
    v(Field{"dropout", "", Range::non_negative, "part of the samples that is lost, below 1"},
      self.dropout);
    v(Field{"freeze_start", "s", Range::non_negative, "when the stream stops changing"},
      self.freeze_start);
    v(Field{"freeze_duration", "s", Range::non_negative, "for how long; 0 never"},
      self.freeze_duration);
    v(Field{"swap_start", "s", Range::non_negative,
            "when vehicles 1 and 2 are taken for each other"},
      self.swap_start);
    v(Field{"swap_duration", "s", Range::non_negative, "for how long; 0 never"},
      self.swap_duration);
  }
};

template <Real R, class V>
MULTILIFT_INLINE void tell_truth(const State<R, V>& x, Measurement<R>& measured) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    measured.vehicle[i] = x.vehicle[i].position;
    measured.vehicle_velocity[i] = x.vehicle[i].velocity;
  }
  measured.payload = x.payload;
}

template <Real R>
class MotionCapture {
 public:
  using Seeds = std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)>;

  /// All worlds sample at the first one's period; every other number is a world's own.
  MotionCapture(const MotionCaptureParameters<R>& p, long control_steps, double step,
                const Seeds& seeds, const Measurement<R>& start)
      : p_(p),
        step_(step),
        every_(value(lane(p.period, 0)) > 0.0 ? steps_of(p.period, step)[0] : control_steps),
        seeds_(seed_words<R>(seeds)),
        sample_(start),
        line_(steps_of(p.delay, step), start,
              room_under_way(longest_of(steps_of(p.delay, step)) + control_steps, every_)) {}

  template <class V>
  void observe(long step, const State<R, V>& x) {
    if (step % every_ != 0) return;
    // Half a step on, so that rounding moves no edge to the next sample.
    const double time = step_ * (static_cast<double>(step) + 0.5);
    const auto within = [&](const R& start, const R& duration) {
      return (start <= R(time)) & (R(time) < start + duration);
    };
    const auto frozen = within(p_.freeze_start, p_.freeze_duration);
    Measurement<R> fresh = sample_;
    tell_truth(x, fresh);
    blur(fresh, static_cast<std::uint64_t>(step / every_));
    if (x.size() > 1) swap(fresh, within(p_.swap_start, p_.swap_duration));
    fresh.visit_scalars(sample_,
                        [&](R& now, const R& before) { now = select(frozen, before, now); });
    sample_ = fresh;
    line_.send(step, sample_, losses(static_cast<std::uint64_t>(step / every_)));
  }

  const Measurement<R>& read(long step) { return line_.receive(step); }

 private:
  static constexpr std::uint64_t loss_stream = std::uint64_t{1} << 32;

  /// Adds noise to both of a pair. Each pair keeps its own stream, whichever noises are on.
  void blur(R& a, R& b, const R& da, const R& db, std::uint64_t stream, std::uint64_t draw) const {
    if (!any(R(0.0) < da + db)) return;
    const auto [na, nb] = normal_pair<R>(seeds_, stream, words_t<R>{} + draw);
    a += da * na;
    b += db * nb;
  }
  void blur(Vec3<R>& a, Vec3<R>& b, const R& da, const R& db, std::uint64_t stream,
            std::uint64_t draw) const {
    blur(a.x, b.x, da, db, stream, draw);
    blur(a.y, b.y, da, db, stream + 1, draw);
    blur(a.z, b.z, da, db, stream + 2, draw);
  }
  void blur(Measurement<R>& m, std::uint64_t draw) const {
    std::uint64_t stream = 0;
    blur(m.payload.position, m.payload.velocity, p_.position_noise, p_.velocity_noise, stream,
         draw);
    Vec3<R> turn{};
    blur(turn, m.payload.rate, p_.attitude_noise, p_.rate_noise, stream += 3, draw);
    const R half(0.5);
    m.payload.attitude = normalised(
        m.payload.attitude * Quaternion<R>{R(1.0), half * turn.x, half * turn.y, half * turn.z});
    for (std::size_t i = 0; i < m.vehicle.size(); ++i)
      blur(m.vehicle[i], m.vehicle_velocity[i], p_.position_noise, p_.velocity_noise, stream += 3,
           draw);
  }

  static void swap(Measurement<R>& m, const mask_t<R>& where) {
    const auto exchange = [&](R& a, R& b) {
      const R other = a;
      a = select(where, b, a);
      b = select(where, other, b);
    };
    zip(exchange, m.vehicle[0], m.vehicle[1]);
    zip(exchange, m.vehicle_velocity[0], m.vehicle_velocity[1]);
  }

  StepsOf<R> losses(std::uint64_t draw) const {
    StepsOf<R> late{};
    if (!any(R(0.0) < p_.dropout)) return late;
    const auto [u, unused] = uniform_pair<R>(seeds_, loss_stream, words_t<R>{} + draw);
    static_cast<void>(unused);
    for (int k = 0; k < lanes_of<R>; ++k)
      if (value(lane(u, k)) < value(lane(p_.dropout, k)))
        late[static_cast<std::size_t>(k)] = LossyLine<R, Measurement<R>>::lost;
    return late;
  }

  MotionCaptureParameters<R> p_;
  double step_;
  long every_;
  words_t<R> seeds_;
  Measurement<R> sample_;
  LossyLine<R, Measurement<R>> line_;
};

}  // namespace multilift::spatial
