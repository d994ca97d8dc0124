// A quadrotor's own control, from a wanted force to rotor speeds, in the cascade that PX4 uses:
// attitude P on quaternions, rate PID, mixing, thrust normalised by a hover thrust.
//
// The attitude law splits the error into tilt and heading and gives the heading less weight
// (Brescianini, Hehn, D'Andrea 2013). Torques are in rotor thrusts: 1 moves each rotor's normalised
// thrust by sqrt(1/2) for roll and pitch and by 1 for yaw, as PX4's quadrotor mixers do.
#pragma once

#include <utility>

#include "multilift/control/spatial/law.hpp"
#include "multilift/control/spatial/set_point.hpp"
#include "multilift/model/spatial/quadrotor.hpp"

namespace multilift::spatial {

template <Real R>
struct AutopilotParameters {
  explicit AutopilotParameters(std::size_t n)
      : attitude_gain(n, {R(6.5), R(6.5), R(2.8)}),
        yaw_weight(n, R(0.4)),
        rate_limit(n, {R(3.84), R(3.84), R(3.49)}),
        rate_p(n, {R(0.15), R(0.15), R(0.2)}),
        rate_i(n, {R(0.2), R(0.2), R(0.1)}),
        rate_d(n, {R(0.003), R(0.003), R(0.0)}),
        rate_integral_limit(n, {R(0.3), R(0.3), R(0.3)}),
        rate_filter(n, R(30.0)),
        hover_thrust(n, R(0.0)),
        thrust_curve(n, R(1.0)) {}

  std::vector<Vec3<R>> attitude_gain;
  std::vector<R> yaw_weight;
  std::vector<Vec3<R>> rate_limit, rate_p, rate_i, rate_d, rate_integral_limit;
  std::vector<R> rate_filter, hover_thrust, thrust_curve;

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"attitude_gain", "1/s", Range::positive,
            "attitude error to rate setpoint about x, y, z (PX4 MC_ROLL_P, MC_PITCH_P, MC_YAW_P)"},
      self.attitude_gain);
    v(Field{"yaw_weight", "", Range::positive, "of the heading's error, at most 1 (MC_YAW_WEIGHT)"},
      self.yaw_weight);
    v(Field{"rate_limit", "rad/s", Range::positive, "of the rate setpoint (MC_ROLLRATE_MAX, ...)"},
      self.rate_limit);
    v(Field{"rate_p", "s", Range::non_negative, "rate error to torque (MC_ROLLRATE_P, ...)"},
      self.rate_p);
    v(Field{"rate_i", "", Range::non_negative, "its integral's gain (MC_ROLLRATE_I, ...)"},
      self.rate_i);
    v(Field{"rate_d", "s^2", Range::non_negative, "gain of the rate's change (MC_ROLLRATE_D, ...)"},
      self.rate_d);
    v(Field{"rate_integral_limit", "", Range::non_negative,
            "bound on the integral's torque (MC_RR_INT_LIM, ...)"},
      self.rate_integral_limit);
    v(Field{"rate_filter", "Hz", Range::positive,
            "cut-off of the low-pass on the rate's change (IMU_DGYRO_CUTOFF)"},
      self.rate_filter);
    v(Field{"hover_thrust", "", Range::non_negative,
            "normalised thrust that the ground station takes for the vehicle's and its share of "
            "the load's weight (MPC_THR_HOVER); 0: the exact thrust curve"},
      self.hover_thrust);
    v(Field{"thrust_curve", "", Range::non_negative,
            "how much of the rotors' square law the mixer undoes, 0 to 1 (THR_MDL_FAC)"},
      self.thrust_curve);
  }
};

/// The scale of quadrotors of these numbers.
template <Real R>
ThrustScale<R> thrust_scale(const AutopilotParameters<R>& p,
                            const typename Quadrotors<R>::Parameters& craft,
                            std::vector<R> hover_force) {
  ThrustScale<R> scale{std::move(hover_force), p.hover_thrust, {}, p.thrust_curve};
  for (std::size_t i = 0; i < craft.size(); ++i)
    scale.greatest.push_back(R(static_cast<double>(rotors)) * craft.thrust_coefficient[i] *
                             square(craft.rotor_speed_max[i]));
  return scale;
}

template <Real R>
class Autopilot {
 public:
  Autopilot(const AutopilotParameters<R>& p, const typename Quadrotors<R>::Parameters& craft,
            double period)
      : p_(p), craft_(craft), period_(period), memory_(craft.size()) {
    for (const R& cutoff : p.rate_filter) {
      const R omega = R(2.0 * std::numbers::pi * period) * cutoff;
      filter_.push_back(omega / (R(1.0) + omega));
    }
  }

  /// One period of vehicle i's attitude and rate control: rotor speeds, rad/s.
  MULTILIFT_INLINE std::array<R, rotors> step(std::size_t i, const Craft<R>& craft,
                                              const AttitudeThrust<R>& wanted) {
    const Vec3<R> rate_wanted = rate_setpoint(i, craft.attitude, wanted.attitude);
    return mix(i, torque(i, craft.rate, rate_wanted), wanted.thrust);
  }

  /// Whether vehicle i's last mixing had to give up some torque or thrust.
  const mask_t<R>& saturated(std::size_t i) const { return memory_[i].saturated; }

  /// Rate setpoint, body, rad/s, from the attitude error.
  MULTILIFT_INLINE Vec3<R> rate_setpoint(std::size_t i, const Quaternion<R>& attitude,
                                         const Quaternion<R>& wanted) const {
    const R zero(0.0), one(1.0);
    // Error as seen from the body: first tilt, then heading about the tilted z.
    const Quaternion<R> e = conjugate(attitude) * wanted;
    const R size = sqrt(max(e.w * e.w + e.z * e.z, R(1e-24)));
    const R inverse = one / size;
    const R sign = select(e.w < zero, R(-1.0), one);
    const R yaw_sin = p_.yaw_weight[i] * (sign * e.z * inverse);
    const Quaternion<R> heading{e.w * inverse, zero, zero, e.z * inverse};
    const Quaternion<R> tilt = e * conjugate(heading);
    const Quaternion<R> less{sqrt(max(one - yaw_sin * yaw_sin, zero)), zero, zero, yaw_sin};
    const Quaternion<R> error = tilt * less;
    const R twice = select(error.w < zero, R(-2.0), R(2.0));
    Vec3<R> gain = p_.attitude_gain[i];
    gain.z = gain.z / p_.yaw_weight[i];
    Vec3<R> rate = scale(gain, twice * Vec3<R>{error.x, error.y, error.z});
    zip([](R& r, const R& limit) { r = clamp(r, -limit, limit); }, rate, p_.rate_limit[i]);
    return rate;
  }

 private:
  struct Memory {
    Vec3<R> integral, last_rate, change;
    mask_t<R> saturated{};
    bool started{false};
  };

  MULTILIFT_INLINE Vec3<R> torque(std::size_t i, const Vec3<R>& rate, const Vec3<R>& wanted) {
    Memory& m = memory_[i];
    if (!m.started) m.last_rate = rate;
    m.started = true;
    const Vec3<R> error = wanted - rate;
    const Vec3<R> change = R(1.0 / period_) * (rate - m.last_rate);
    m.last_rate = rate;
    m.change += filter_[i] * (change - m.change);
    const Vec3<R> result = scale(p_.rate_p[i], error) + m.integral - scale(p_.rate_d[i], m.change);
    const mask_t<R> full = m.saturated;
    zip(
        [&](R& sum, const R& e, const R& gain, const R& limit) {
          const R next = clamp(sum + R(period_) * gain * e, -limit, limit);
          sum = select(full & (abs(sum) < abs(next)), sum, next);
        },
        m.integral, error, p_.rate_i[i], p_.rate_integral_limit[i]);
    return result;
  }

  /// Tilt has priority: roll and pitch keep their torque as long as rotors allow any split of it,
  /// the thrust moves to make room, and yaw takes what is left.
  MULTILIFT_INLINE std::array<R, rotors> mix(std::size_t i, const Vec3<R>& torque,
                                             const R& thrust) {
    const R zero(0.0), one(1.0);
    const auto [s, c] = sincos(craft_.frame_angle[i]);
    std::array<R, rotors> share;
    // As Quadrotors::turn: rotor k stands at (c, s) turned by k quarter turns.
    const R a = s * torque.x - c * torque.y, b = c * torque.x + s * torque.y;
    share = {a, b, -a, -b};
    R top = max(abs(a), abs(b));
    const R squeeze = one / max(one, R(2.0) * top);
    for (R& x : share) x *= squeeze;
    top *= squeeze;
    const R level = clamp(thrust, top, one - top);
    // Rotors 0 and 2 turn the body left as they speed up.
    R room = one;
    for (const R& x : share) room = min(room, min(level + x, one - level - x));
    const R yaw = clamp(torque.z, -room, room);
    memory_[i].saturated =
        (squeeze < one) | (level < thrust) | (thrust < level) | (yaw < torque.z) | (torque.z < yaw);
    std::array<R, rotors> speed;
    for (std::size_t k = 0; k < rotors; ++k) {
      const R sign(k % 2 == 0 ? 1.0 : -1.0);
      const R wanted = max(level + share[k] + sign * yaw, zero);
      speed[k] = clamp(craft_.rotor_speed_max[i] * undo_curve(i, wanted), craft_.rotor_speed_min[i],
                       craft_.rotor_speed_max[i]);
    }
    return speed;
  }

  /// The motor command t with (1 - c) t + c t^2 = thrust.
  MULTILIFT_INLINE R undo_curve(std::size_t i, const R& thrust) const {
    const R c = p_.thrust_curve[i];
    const R linear = R(1.0) - c;
    // In this form a curve of 0 divides by nothing.
    return R(2.0) * thrust / max(linear + sqrt(linear * linear + R(4.0) * c * thrust), R(1e-12));
  }

  AutopilotParameters<R> p_;
  typename Quadrotors<R>::Parameters craft_;
  double period_;
  std::vector<Memory> memory_;
  std::vector<R> filter_;
};

}  // namespace multilift::spatial
