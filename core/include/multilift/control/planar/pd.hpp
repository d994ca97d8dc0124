// The paper's baseline (71), (72): PD with adaptive drag compensation, blind to the swing.
#pragma once

#include "multilift/control/planar/adaptive_feedback.hpp"

namespace multilift::planar {

template <Real R>
class Pd {
 public:
  static constexpr const char* name = "pd";
  static constexpr const char* title = "PD law with drag estimate, equations (71), (72)";

  using Gains = FeedbackGains<R>;

  Pd(const Gains& gains, const Plant<R>&, const PerAxis<R>& goal, double period)
      : goal_(goal), feedback_(gains, period) {}

  MULTILIFT_INLINE Command<R> step(const Measurement<R>& measured) {
    UnifiedError<R> error;
    for (std::size_t i = 0; i < 2; ++i) {
      error.eps[i] = measured.vehicle[i] - goal_[i];
      error.eps_dot[i] = measured.vehicle_velocity[i];
    }
    if (measured.target != nullptr) follow(error, {R(0.0), R(0.0)}, goal_, *measured.target);
    return feedback_.step(error, measured);
  }

  StorageGains<R> storage_gains() const { return feedback_.storage_gains(R(0.0)); }
  const PerAxis<R>& d_hat() const { return feedback_.d_hat(); }

 private:
  PerAxis<R> goal_;
  AdaptiveFeedback<R> feedback_;
};

}  // namespace multilift::planar
