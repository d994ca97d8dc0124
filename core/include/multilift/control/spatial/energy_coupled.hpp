// The paper's energy-coupled adaptive law (48), (51), (55) for n vehicles in space.
//
// The unified signal leans each vehicle after the load: eta_i = -kappa_i r, where r is the
// payload's displacement from where it hangs at rest below the vehicles' mean, and kappa_i = n
// k_lambda / m_i. For two vehicles in a plane this is (47).
#pragma once

#include "multilift/control/spatial/adaptive_feedback.hpp"

namespace multilift::spatial {

/// The payload from where it would hang at rest below the vehicles, W.
template <Real R>
struct Displacement {
  Vec3<R> r;      // m
  Vec3<R> r_dot;  // m/s
};

template <Real R>
MULTILIFT_INLINE Displacement<R> displacement_of(const std::vector<Vec3<R>>& vehicle,
                                                 const std::vector<Vec3<R>>& vehicle_velocity,
                                                 const RigidBody<R>& payload,
                                                 const Target<R>& target) {
  Vec3<R> mean{}, mean_rate{};
  for (std::size_t i = 0; i < vehicle.size(); ++i) {
    mean += vehicle[i];
    mean_rate += vehicle_velocity[i];
  }
  const R share(1.0 / static_cast<double>(vehicle.size()));
  return {payload.position - share * mean - target.below,
          payload.velocity - share * mean_rate - target.below_rate};
}

template <Real R>
class EnergyCoupled : public Law<R> {
 public:
  static constexpr const char* name = "energy_coupled";
  static constexpr const char* title = "energy-coupled adaptive law, (48), (51), (55) in space";

  struct Gains {
    explicit Gains(std::size_t n) : feedback(n) {}
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

  EnergyCoupled(const Gains& gains, const Parameters<R>& assumed, double period)
      : Law<R>(assumed.size()),
        k_lambda_(gains.k_lambda),
        assumed_(assumed),
        feedback_(gains.feedback, period) {
    this->drag_estimate_ = feedback_.start();
    for (const R& mass : assumed.vehicle_mass)
      coupling_.push_back(R(static_cast<double>(assumed.size())) * k_lambda_ / mass);
  }

  void step(const Measurement<R>& measured, const Target<R>& target,
            std::vector<Vec3<R>>& force) override {
    const auto [r, r_dot] =
        displacement_of(measured.vehicle, measured.vehicle_velocity, measured.payload, target);
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Vec3<R> eps = measured.vehicle[i] - target.vehicle[i] - coupling_[i] * r;
      const Vec3<R> eps_dot =
          measured.vehicle_velocity[i] - target.vehicle_velocity[i] - coupling_[i] * r_dot;
      force[i] = holding_force(assumed_, target, feedback_.feedforward(), i) +
                 feedback_.step(i, eps, eps_dot, measured, this->drag_estimate_[i]);
    }
  }

  StorageGains<R> storage_gains() const override { return feedback_.storage_gains(k_lambda_); }

 private:
  R k_lambda_;
  Parameters<R> assumed_;
  AdaptiveFeedback<R> feedback_;
  std::vector<R> coupling_;  // kappa_i
};

}  // namespace multilift::spatial
