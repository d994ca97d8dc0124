// The storage function of the momentum-coupled law, and the powers that change it.
//
// With X how far the centre of mass of vehicles and bar is from where it shall rest, V = dX/dt, M
// the mass of all, g = lead, a = g / (1 + g) and y_i = xi_i - xi_id - a X,
//
//     S = E - 1/2 a M |V|^2 + 1/2 sum y_i' K_p y_i + 1/2 g y_p' (sum K_p) y_p + 1/2 w~' Gamma^-1 w~
//
// where y_p is the mean of the y_i weighed by K_p. No force inside the formation moves the common
// centre of mass, so that none appears in
//
//     dS/dt = -sum y_i_dot' K_d y_i_dot - g y_d_dot' (sum K_d) y_d_dot
//             - sum d_theta_i theta_dot_i^2 + push + actuation + adaptation + reference,
//
// whatever masses, cables and motion. docs/momentum-law derives it; tests/test_momentum_proof.py
// proves it.
#pragma once

#include "multilift/model/planar/energy.hpp"

namespace multilift::planar {

/// What the storage function of the momentum-coupled law is made of.
template <Real R>
struct MomentumGains {
  StorageGains<R> feedback;  // k_lambda 0
  R lead{0.0};
};

/// How far the common centre of mass is from its place at rest, or its velocity: from the vehicles'
/// errors and the bar's swing, or from their rates.
template <Real R>
MULTILIFT_INLINE Vec2<R> common_centre(const Plant<R>& p, const std::array<Vec2<R>, 2>& vehicle,
                                       const Vec2<R>& swing) {
  const R half_bar = R(0.5) * p.bar_mass;
  const R share = R(1.0) / (p.bar_mass + p.vehicle_mass[0] + p.vehicle_mass[1]);
  return share * (half_bar * swing + (half_bar + p.vehicle_mass[0]) * vehicle[0] +
                  (half_bar + p.vehicle_mass[1]) * vehicle[1]);
}

/// The mean of both along each axis, weighed.
template <Real R>
MULTILIFT_INLINE Vec2<R> weighed_mean(const std::array<Vec2<R>, 2>& weight,
                                      const std::array<Vec2<R>, 2>& x) {
  const Vec2<R> moment = scale(weight[0], x[0]) + scale(weight[1], x[1]);
  const Vec2<R> all = weight[0] + weight[1];
  return {moment.y / all.y, moment.z / all.z};
}

/// y_i and its rate, in the fields of the unified error that they take the place of, and V.
template <Real R>
struct CommonMotion {
  Swing<R> swing;
  UnifiedError<R> error;
  Vec2<R> velocity;
};

/// `follow` is a; `target` is null where the goal rests. On a way, vehicles and load are measured
/// against where they shall be; the velocity of the common centre of mass stays its own.
template <Real R>
MULTILIFT_INLINE CommonMotion<R> common_motion(const Plant<R>& p, const R& follow,
                                               const Swing<R>& swing,
                                               const std::array<Vec2<R>, 2>& vehicle,
                                               const std::array<Vec2<R>, 2>& vehicle_velocity,
                                               const std::array<Vec2<R>, 2>& goal,
                                               const Target<R>* target) {
  const Vec2<R> velocity = common_centre(p, vehicle_velocity, swing.rate);
  std::array<Vec2<R>, 2> error{vehicle[0] - goal[0], vehicle[1] - goal[1]};
  std::array<Vec2<R>, 2> rate = vehicle_velocity;
  Swing<R> apart = swing;
  if (target != nullptr) {
    for (std::size_t i = 0; i < 2; ++i) {
      error[i] = vehicle[i] - target->vehicle[i];
      rate[i] -= target->vehicle_velocity[i];
    }
    apart.displacement -= target->swing.displacement;
    apart.rate -= target->swing.rate;
  }
  const Vec2<R> shift = follow * common_centre(p, error, apart.displacement);
  const Vec2<R> shift_rate = follow * common_centre(p, rate, apart.rate);
  return {swing,
          {{error[0] - shift, error[1] - shift}, {rate[0] - shift_rate, rate[1] - shift_rate}},
          velocity};
}

/// As `Storage`, for the momentum-coupled law.
template <Real R>
class MomentumStorage {
 public:
  MomentumStorage(const Plant<R>& p, const MomentumGains<R>& gains,
                  const std::array<Vec2<R>, 2>& goal)
      : gains_(gains),
        goal_(goal),
        follow_(gains.lead / (R(1.0) + gains.lead)),
        followed_mass_(follow_ * (p.bar_mass + p.vehicle_mass[0] + p.vehicle_mass[1])),
        plain_(p, gains.feedback, goal) {}

  MULTILIFT_INLINE CommonMotion<R> formation(const Plant<R>& p, const State<R>& state,
                                             const Pose<R>& pose, const Target<R>* target) const {
    return common_motion(p, follow_, swing_of(p, state, pose), pose.vehicle, pose.vehicle_velocity,
                         goal_, target);
  }

  MULTILIFT_INLINE R estimation_energy(const Plant<R>& p,
                                       const std::array<Vec2<R>, 2>& d_hat) const {
    return plain_.estimation_energy(p, d_hat);
  }

  /// S without its last term, J.
  MULTILIFT_INLINE R motion_energy(const Plant<R>& p, const State<R>& state, const Pose<R>& pose,
                                   const CommonMotion<R>& motion) const {
    const PerVehicle& k_p = gains_.feedback.k_p;
    R twice = -followed_mass_ * dot(motion.velocity, motion.velocity);
    for (std::size_t i = 0; i < 2; ++i)
      twice += dot(k_p[i], scale(motion.error.eps[i], motion.error.eps[i]));
    const Vec2<R> mean = weighed_mean(k_p, motion.error.eps);
    twice += gains_.lead * dot(k_p[0] + k_p[1], scale(mean, mean));
    return mechanical_energy(p, state, pose, motion.swing) + R(0.5) * twice;
  }

  MULTILIFT_INLINE Powers<R> powers(const Plant<R>& p, const State<R>& state, const Pose<R>& pose,
                                    const CommonMotion<R>& motion, const Loads<R>& loads,
                                    const Motion<R>&, const std::array<Vec2<R>, 2>& d_hat,
                                    const Target<R>* target) const {
    const PerVehicle &k_p = gains_.feedback.k_p, &k_d = gains_.feedback.k_d;
    const auto& [eps, rate] = motion.error;
    const Vec2<R> mean = weighed_mean(k_p, eps), mean_rate = weighed_mean(k_d, rate);
    R braking = gains_.lead * dot(k_d[0] + k_d[1], scale(mean_rate, mean_rate));
    Powers<R> w;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec2<R>& velocity = pose.vehicle_velocity[i];
      const Vec2<R> compensation = scale(d_hat[i], velocity);
      braking += dot(k_d[i], scale(rate[i], rate[i]));
      w.actuation +=
          dot(rate[i], loads.u[i] + scale(k_p[i], eps[i] + gains_.lead * mean) - compensation);
      w.adaptation += dot(rate[i], compensation - scale(p.vehicle_drag[i], velocity));
    }
    R damping(0.0);
    for (std::size_t k = 0; k < 3; ++k) damping += p.swing_damping[k] * square(state.theta_dot[k]);
    w.dissipation = -(braking + damping);
    w.actuation += braking;
    if (loads.pushed)
      w.push = dot(loads.bar_push, state.bar_velocity - follow_ * motion.velocity) +
               loads.bar_torque * state.theta_dot[2] + dot(rate[0], loads.vehicle_push[0]) +
               dot(rate[1], loads.vehicle_push[1]);
    if (target != nullptr) {
      const Vec2<R> shift =
          follow_ * common_centre(p, target->vehicle_velocity, target->swing.rate);
      add_reference(w, p, pose, rate,
                    {target->vehicle_velocity[0] - shift, target->vehicle_velocity[1] - shift},
                    loads, *target);
    }
    return w;
  }

 private:
  using PerVehicle = std::array<Vec2<R>, 2>;

  MomentumGains<R> gains_;
  PerVehicle goal_;
  R follow_, followed_mass_;
  Storage<R> plain_;
};

/// The storage function of a law, by the gains that it names.
template <Real R>
Storage<R> storage_of(const Plant<R>& p, const StorageGains<R>& gains,
                      const std::array<Vec2<R>, 2>& goal) {
  return {p, gains, goal};
}
template <Real R>
MomentumStorage<R> storage_of(const Plant<R>& p, const MomentumGains<R>& gains,
                              const std::array<Vec2<R>, 2>& goal) {
  return {p, gains, goal};
}

}  // namespace multilift::planar
