// The paper's energy-coupled adaptive law (48), (51), (55): feedback of the UAV-payload unified
// signal xi + eta(theta), which leans each vehicle after the swinging load.
#pragma once

#include "multilift/control/planar/adaptive_feedback.hpp"

namespace multilift::planar {

template <Real R>
class EnergyCoupled {
 public:
  static constexpr const char* name = "energy_coupled";
  static constexpr const char* title = "energy-coupled adaptive law, equations (48), (51), (55)";

  struct Gains {
    FeedbackGains<R> feedback;
    R k_lambda{required};

    template <class Self, class V>
    static void visit(Self& self, V&& v) {
      FeedbackGains<R>::visit(self.feedback, v);
      v(Field{"k_lambda", "kg", Range::non_negative,
              "swing coupling k_lambda of (45); 0 gives the PD law"},
        self.k_lambda);
    }
  };

  EnergyCoupled(const Gains& gains, const Plant<R>& assumed, const PerAxis<R>& goal, double period)
      : k_lambda_(gains.k_lambda),
        coupling_(swing_coupling(assumed, gains.k_lambda)),
        assumed_(assumed),
        goal_(goal),
        feedback_(gains.feedback, period) {}

  MULTILIFT_INLINE Command<R> step(const Measurement<R>& measured) {
    Swing<R> swing = swing_of(assumed_, measured.angle, measured.theta_dot);
    UnifiedError<R> error =
        unified_error(coupling_, swing, measured.vehicle, measured.vehicle_velocity, goal_);
    if (measured.target != nullptr) follow(error, coupling_, goal_, *measured.target);
    return feedback_.step(error, measured);
  }

  StorageGains<R> storage_gains() const { return feedback_.storage_gains(k_lambda_); }
  const PerAxis<R>& d_hat() const { return feedback_.d_hat(); }

 private:
  R k_lambda_;
  std::array<R, 2> coupling_;
  Plant<R> assumed_;
  PerAxis<R> goal_;
  AdaptiveFeedback<R> feedback_;
};

}  // namespace multilift::planar
