// The energy-coupled law with the paper's swing replaced by what no internal force works on: how
// far the common centre of mass of vehicles and bar leads the vehicles.
//
//     eps_i = xi_i - xi_id - g (X - mean_K(xi - xi_d)),   g = 4 k_lambda M / ((m1 + m2) m3)
//
// X is the common centre of mass from its place at rest, M the mass of all, mean_K the mean weighed
// by the gain that eps is multiplied with. For equal masses and gains eps is that of (48). The
// estimates follow y_i' = xi_i' - g / (1 + g) X' instead of eps_i'.
#pragma once

#include "multilift/control/planar/adaptive_feedback.hpp"
#include "multilift/control/planar/energy_coupled.hpp"
#include "multilift/model/planar/common_motion.hpp"

namespace multilift::planar {

template <Real R>
class MomentumCoupled {
 public:
  static constexpr const char* name = "momentum_coupled";
  static constexpr const char* title = "momentum-coupled adaptive law: no internal force feeds it";

  using Gains = typename EnergyCoupled<R>::Gains;

  MomentumCoupled(const Gains& gains, const Plant<R>& assumed, const PerAxis<R>& goal,
                  double period)
      : gains_(gains.feedback),
        lead_(R(4.0) * gains.k_lambda *
              (assumed.bar_mass + assumed.vehicle_mass[0] + assumed.vehicle_mass[1]) /
              ((assumed.vehicle_mass[0] + assumed.vehicle_mass[1]) * assumed.bar_mass)),
        follow_(lead_ / (R(1.0) + lead_)),
        assumed_(assumed),
        goal_(goal),
        feedback_(gains.feedback, period) {}

  MULTILIFT_INLINE Command<R> step(const Measurement<R>& measured) {
    const Swing<R> swing = swing_of(assumed_, measured.angle, measured.theta_dot);
    const UnifiedError<R> y = common_motion(assumed_, follow_, swing, measured.vehicle,
                                            measured.vehicle_velocity, goal_, measured.target)
                                  .error;
    UnifiedError<R> error = y;
    const Vec2<R> more = lead_ * weighed_mean(gains_.k_p, y.eps);
    const Vec2<R> more_rate = lead_ * weighed_mean(gains_.k_d, y.eps_dot);
    for (std::size_t i = 0; i < 2; ++i) {
      error.eps[i] += more;
      error.eps_dot[i] += more_rate;
    }
    return feedback_.step(error, y.eps_dot, measured);
  }

  MomentumGains<R> storage_gains() const { return {feedback_.storage_gains(R(0.0)), lead_}; }
  const PerAxis<R>& d_hat() const { return feedback_.d_hat(); }

 private:
  FeedbackGains<R> gains_;
  R lead_, follow_;
  Plant<R> assumed_;
  PerAxis<R> goal_;
  AdaptiveFeedback<R> feedback_;
};

}  // namespace multilift::planar
