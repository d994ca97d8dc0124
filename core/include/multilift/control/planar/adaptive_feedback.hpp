// The feedback that both of the paper's laws share:
//
//     u = -K_p eps - K_d eps_dot + Phi d_hat - K_i integral(eps)           (55), (71), Remark 6
//     d/dt d_hat = -Gamma Phi eps_dot,   Phi = diag(velocities)            (51), (72)
//
// and, on a way, the forces that it takes. A law decides what eps is. Estimate and integral advance
// by forward Euler once a control period.
#pragma once

#include "multilift/control/planar/measurement.hpp"

namespace multilift::planar {

/// [y, z] for each of the two vehicles.
template <Real R>
using PerAxis = std::array<Vec2<R>, 2>;

template <Real R>
constexpr PerAxis<R> every_axis(double x) {
  return {Vec2<R>{R(x), R(x)}, Vec2<R>{R(x), R(x)}};
}

template <Real R>
struct FeedbackGains {
  PerAxis<R> k_p = every_axis<R>(required);
  PerAxis<R> k_d = every_axis<R>(required);
  PerAxis<R> gamma = every_axis<R>(required);
  PerAxis<R> d_hat_start = every_axis<R>(0.0);
  PerAxis<R> k_i = every_axis<R>(0.0);
  PerAxis<R> integral_limit = every_axis<R>(unlimited);

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"k_p", "N/m", Range::positive, "proportional gain K_p"}, self.k_p);
    v(Field{"k_d", "N s/m", Range::positive, "derivative gain K_d"}, self.k_d);
    v(Field{"gamma", "N s^2/m^3", Range::positive, "adaptation gain Gamma of (51)"}, self.gamma);
    v(Field{"d_hat_start", "N s/m", Range::any, "drag estimate at the start"}, self.d_hat_start);
    v(Field{"k_i", "N/(m s)", Range::non_negative, "integral gain (Remark 6); 0 switches it off"},
      self.k_i);
    v(Field{"integral_limit", "N", Range::positive,
            "bound on the integral action's force; it also rests while the vehicle's command "
            "is saturated and the error would drive it further"},
      self.integral_limit);
  }
};

template <Real R>
class AdaptiveFeedback {
 public:
  AdaptiveFeedback(const FeedbackGains<R>& gains, double period)
      : gains_(gains), period_(period), d_hat_(gains.d_hat_start) {}

  MULTILIFT_INLINE Command<R> step(const UnifiedError<R>& error, const Measurement<R>& measured) {
    return step(error, error.eps_dot, measured);
  }

  /// `power` are the velocities that an unknown drag works on in the law's storage function.
  MULTILIFT_INLINE Command<R> step(const UnifiedError<R>& error, const PerAxis<R>& power,
                                   const Measurement<R>& measured) {
    Command<R> u;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec2<R>& velocity = measured.vehicle_velocity[i];
      u[i] = scale(d_hat_[i], velocity) - scale(gains_.k_p[i], error.eps[i]) -
             scale(gains_.k_d[i], error.eps_dot[i]) + integral_[i];
      d_hat_[i] -= R(period_) * scale(gains_.gamma[i], scale(velocity, power[i]));
      integrate(i, error.eps[i], measured.saturated[i]);
    }
    if (measured.target != nullptr)
      for (std::size_t i = 0; i < 2; ++i) u[i] += measured.target->feedforward[i];
    return u;
  }

  StorageGains<R> storage_gains(const R& k_lambda) const {
    StorageGains<R> storage{k_lambda, gains_.k_p, gains_.k_d, {}};
    for (std::size_t i = 0; i < 2; ++i)
      storage.inverse_gamma[i] = {R(1.0) / gains_.gamma[i].y, R(1.0) / gains_.gamma[i].z};
    return storage;
  }

  const PerAxis<R>& d_hat() const { return d_hat_; }

 private:
  void integrate(std::size_t i, const Vec2<R>& eps, const mask_t<R>& saturated) {
    const auto advance = [&](R& force, const R& gain, const R& error, const R& limit) {
      const R next = clamp(force - R(period_) * gain * error, -limit, limit);
      force = select(saturated & (abs(force) < abs(next)), force, next);
    };
    advance(integral_[i].y, gains_.k_i[i].y, eps.y, gains_.integral_limit[i].y);
    advance(integral_[i].z, gains_.k_i[i].z, eps.z, gains_.integral_limit[i].z);
  }

  FeedbackGains<R> gains_;
  double period_;
  PerAxis<R> d_hat_;
  PerAxis<R> integral_;  // force of the integral action, N
};

}  // namespace multilift::planar
