// The paper's baseline (71), (72) for n vehicles in space: PD with adaptive drag compensation,
// blind to the swing.
#pragma once

#include "multilift/control/spatial/adaptive_feedback.hpp"

namespace multilift::spatial {

template <Real R>
class Pd : public Law<R> {
 public:
  static constexpr const char* name = "pd";
  static constexpr const char* title = "PD law with drag estimate, (71), (72) in space";

  using Gains = FeedbackGains<R>;

  Pd(const Gains& gains, const Parameters<R>& assumed, double period)
      : Law<R>(assumed.size()), assumed_(assumed), feedback_(gains, period) {
    this->drag_estimate_ = feedback_.start();
  }

  void step(const Measurement<R>& measured, const Target<R>& target,
            std::vector<Vec3<R>>& force) override {
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Vec3<R> eps = measured.vehicle[i] - target.vehicle[i];
      const Vec3<R> eps_dot = measured.vehicle_velocity[i] - target.vehicle_velocity[i];
      force[i] = holding_force(assumed_, target, feedback_.feedforward(), i) +
                 feedback_.step(i, eps, eps_dot, measured, this->drag_estimate_[i]);
    }
  }

  StorageGains<R> storage_gains() const override { return feedback_.storage_gains(R(0.0)); }

 private:
  Parameters<R> assumed_;
  AdaptiveFeedback<R> feedback_;
};

}  // namespace multilift::spatial
