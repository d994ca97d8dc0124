// The energy-coupled law with the paper's swing replaced by what no internal force works on: how
// far the common centre of mass of vehicles and payload leads the vehicles.
//
//     y_i = e_i - a X,   eps_i = y_i + g y_K,   g = n^2 k_lambda M / (m_V m_L),   a = g / (1 + g)
//
// e_i are the vehicles' errors, X that of the common centre of mass, M the mass of all, m_V of all
// vehicles, y_K the mean weighed by the gain that eps is multiplied with. For equal masses and
// gains eps is that of the energy-coupled law. The estimates follow y_i' instead of eps_i'.
#pragma once

#include "multilift/control/spatial/energy_coupled.hpp"
#include "multilift/model/spatial/common_motion.hpp"

namespace multilift::spatial {

template <Real R>
class MomentumCoupled : public Law<R> {
 public:
  static constexpr const char* name = "momentum_coupled";
  static constexpr const char* title = "momentum-coupled adaptive law: no internal force feeds it";

  using Gains = typename EnergyCoupled<R>::Gains;

  MomentumCoupled(const Gains& gains, const Parameters<R>& assumed, double period)
      : Law<R>(assumed.size()),
        gains_(gains.feedback),
        assumed_(assumed),
        feedback_(gains.feedback, period) {
    this->drag_estimate_ = feedback_.start();
    const double n = static_cast<double>(assumed.size());
    const R mass = common_mass(assumed);
    lead_ =
        R(n * n) * gains.k_lambda * mass / ((mass - assumed.payload_mass) * assumed.payload_mass);
    follow_ = lead_ / (R(1.0) + lead_);
  }

  void step(const Measurement<R>& measured, const Target<R>& target,
            std::vector<Vec3<R>>& force) override {
    const auto error = [&](std::size_t i) { return measured.vehicle[i] - target.vehicle[i]; };
    const auto rate = [&](std::size_t i) {
      return measured.vehicle_velocity[i] - target.vehicle_velocity[i];
    };
    const Vec3<R> shift =
        follow_ * common_centre(assumed_, measured.payload.position - target.payload, error);
    const Vec3<R> shift_rate =
        follow_ *
        common_centre(assumed_, measured.payload.velocity - target.payload_velocity, rate);
    const auto y = [&](std::size_t i) { return error(i) - shift; };
    const auto y_dot = [&](std::size_t i) { return rate(i) - shift_rate; };
    Vec3<R> all;
    const Vec3<R> more = lead_ * weighed_mean(gains_.k_p, y, all);
    const Vec3<R> more_rate = lead_ * weighed_mean(gains_.k_d, y_dot, all);
    for (std::size_t i = 0; i < force.size(); ++i)
      force[i] = holding_force(assumed_, target, feedback_.feedforward(), i) +
                 feedback_.step(i, y(i) + more, y_dot(i) + more_rate, y_dot(i), measured,
                                this->drag_estimate_[i]);
  }

  StorageGains<R> storage_gains() const override {
    StorageGains<R> storage = feedback_.storage_gains(R(0.0));
    storage.lead = lead_;
    return storage;
  }

 private:
  FeedbackGains<R> gains_;
  Parameters<R> assumed_;
  AdaptiveFeedback<R> feedback_;
  R lead_, follow_;
};

}  // namespace multilift::spatial
