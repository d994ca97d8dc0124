// The feedback that the paper's two laws share, for n vehicles in three axes:
//
//     u = -K_p eps - K_d eps_dot + Phi d_hat - K_i integral(eps)           (55), (71), Remark 6
//     d/dt d_hat = -Gamma Phi eps_dot,   Phi = diag(velocities)            (51), (72)
//
// A law decides what eps is. Estimate and integral advance by forward Euler once a control period.
#pragma once

#include "multilift/control/spatial/law.hpp"

namespace multilift::spatial {

template <Real R>
struct FeedbackGains {
  explicit FeedbackGains(std::size_t n)
      : k_p(n, every(required)),
        k_d(n, every(required)),
        gamma(n, every(required)),
        d_hat_start(n, every(0.0)),
        k_i(n, every(0.0)),
        integral_limit(n, every(unlimited)) {}

  std::vector<Vec3<R>> k_p, k_d, gamma, d_hat_start, k_i, integral_limit;
  R feedforward{0.0};

  static Vec3<R> every(double x) { return {R(x), R(x), R(x)}; }

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"k_p", "N/m", Range::positive, "proportional gain K_p along x, y, z"}, self.k_p);
    v(Field{"k_d", "N s/m", Range::positive, "derivative gain K_d"}, self.k_d);
    v(Field{"gamma", "N s^2/m^3", Range::positive, "adaptation gain Gamma of (51)"}, self.gamma);
    v(Field{"d_hat_start", "N s/m", Range::any, "drag estimate at the start"}, self.d_hat_start);
    v(Field{"k_i", "N/(m s)", Range::non_negative, "integral gain (Remark 6); 0 switches it off"},
      self.k_i);
    v(Field{"integral_limit", "N", Range::positive,
            "bound on the integral action's force; it also rests while the vehicle's command is "
            "saturated and the error would drive it further"},
      self.integral_limit);
    v(Field{"feedforward", "", Range::non_negative,
            "how much of the force that the reference's acceleration takes is commanded ahead: 0 "
            "none, 1 all"},
      self.feedforward);
  }
};

template <Real R>
class AdaptiveFeedback {
 public:
  AdaptiveFeedback(const FeedbackGains<R>& gains, double period)
      : gains_(gains), period_(period), integral_(gains.k_p.size()) {}

  /// Vehicle i's u; its estimate moves on.
  MULTILIFT_INLINE Vec3<R> step(std::size_t i, const Vec3<R>& eps, const Vec3<R>& eps_dot,
                                const Measurement<R>& measured, Vec3<R>& d_hat) {
    return step(i, eps, eps_dot, eps_dot, measured, d_hat);
  }

  /// `power` is the velocity that an unknown drag works on in the law's storage function.
  MULTILIFT_INLINE Vec3<R> step(std::size_t i, const Vec3<R>& eps, const Vec3<R>& eps_dot,
                                const Vec3<R>& power, const Measurement<R>& measured,
                                Vec3<R>& d_hat) {
    const Vec3<R>& velocity = measured.vehicle_velocity[i];
    const Vec3<R> u = scale(d_hat, velocity) - scale(gains_.k_p[i], eps) -
                      scale(gains_.k_d[i], eps_dot) + integral_[i];
    d_hat -= R(period_) * scale(gains_.gamma[i], scale(velocity, power));
    zip(
        [&](R& force, const R& gain, const R& error, const R& limit) {
          const R next = clamp(force - R(period_) * gain * error, -limit, limit);
          force = select(measured.saturated[i].is & (abs(force) < abs(next)), force, next);
        },
        integral_[i], gains_.k_i[i], eps, gains_.integral_limit[i]);
    return u;
  }

  StorageGains<R> storage_gains(const R& k_lambda) const {
    StorageGains<R> storage(gains_.k_p.size());
    storage.k_lambda = k_lambda;
    storage.k_p = gains_.k_p;
    storage.k_d = gains_.k_d;
    for (std::size_t i = 0; i < gains_.gamma.size(); ++i)
      zip([](R& inverse, const R& gamma) { inverse = R(1.0) / gamma; }, storage.inverse_gamma[i],
          gains_.gamma[i]);
    return storage;
  }

  const R& feedforward() const { return gains_.feedforward; }
  const std::vector<Vec3<R>>& start() const { return gains_.d_hat_start; }

 private:
  FeedbackGains<R> gains_;
  double period_;
  std::vector<Vec3<R>> integral_;  // force of the integral action, N
};

/// The force that holds vehicle i and what its cable asks of it at rest, and, as far as the
/// feedforward says, that moves both as the reference does.
template <Real R>
MULTILIFT_INLINE Vec3<R> holding_force(const Parameters<R>& assumed, const Target<R>& target,
                                       const R& feedforward, std::size_t i) {
  // The share of the load that hangs on this vehicle goes with the upright part of its cable force.
  const R carried = assumed.vehicle_mass[i] + target.cable_force[i].z / assumed.gravity;
  Vec3<R> force = target.cable_force[i] + (feedforward * carried) * target.vehicle_acceleration[i];
  force.z += assumed.vehicle_mass[i] * assumed.gravity;
  return force;
}

}  // namespace multilift::spatial
