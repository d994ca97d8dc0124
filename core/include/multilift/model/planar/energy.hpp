// The energies of the paper's sections 3 and 4, and the powers that change them.
//
// Written for the constrained plant. Along any motion the storage function (49) obeys
//
//     d/dt V = -eps_dot' K_d eps_dot - (1 + k_lambda kappa) sum d_theta_i theta_dot_i^2     (57)
//              + internal + push + actuation + adaptation + reference
//
// with kappa = 4/m3 + 1/m1 + 1/m2. `internal` is the term that (57) lacks: the difference of the
// cables' forces on the bar times the rate at which the formation deforms, and, for unequal
// masses, times the swing rate. docs/theory derives it; tests/test_energy_proof.py proves it.
#pragma once

#include "multilift/model/planar/dynamics.hpp"

namespace multilift::planar {

/// The gains of a control law that its storage function (49) is made of; all zero, which turns the
/// audit into that of the mechanical energy (18), for a law that has none.
template <Real R>
struct StorageGains {
  R k_lambda{0.0};
  std::array<Vec2<R>, 2> k_p;
  std::array<Vec2<R>, 2> k_d;
  std::array<Vec2<R>, 2> inverse_gamma;
};

/// Swing of the bar relative to the mean of the vehicles, doubled as in the paper.
template <Real R>
struct Swing {
  Vec2<R> displacement;  // [l1S1-l2S2+2l3S3, l1(1-C1)+l2(1-C2)+2l3(1-C3)], m
  Vec2<R> rate;          // s_y, s_z of (7)-(13), m/s
};

/// From the angles alone, as a controller sees them; p may be the controller's own idea of the
/// plant.
template <Real R>
MULTILIFT_INLINE Swing<R> swing_of(const Plant<R>& p, const std::array<SinCos<R>, 3>& angle,
                                   const std::array<R, 3>& theta_dot) {
  R l1 = p.cable_length[0], l2 = p.cable_length[1];
  R twice_l3 = R(2.0) * p.bar_half_thickness;
  const auto& [s1, c1] = angle[0];
  const auto& [s2, c2] = angle[1];
  const auto& [s3, c3] = angle[2];
  const R one(1.0);
  return {{l1 * s1 - l2 * s2 + twice_l3 * s3,
           l1 * (one - c1) + l2 * (one - c2) + twice_l3 * (one - c3)},
          {l1 * c1 * theta_dot[0] - l2 * c2 * theta_dot[1] + twice_l3 * c3 * theta_dot[2],
           l1 * s1 * theta_dot[0] + l2 * s2 * theta_dot[1] + twice_l3 * s3 * theta_dot[2]}};
}

/// The same from bar and vehicles, where these are known: twice the bar less the vehicles. How far
/// it is raised is left to the angles, since the energies' least value hangs on it being exact.
template <Real R>
MULTILIFT_INLINE Swing<R> swing_of(const Plant<R>& p, const State<R>& state, const Pose<R>& pose) {
  const auto& [first, second, bar] = pose.angle;
  const R one(1.0);
  R raised = p.cable_length[0] * (one - first.cos) + p.cable_length[1] * (one - second.cos) +
             R(2.0) * p.bar_half_thickness * (one - bar.cos);
  R aside = (state.bar.y - pose.vehicle[0].y) + (state.bar.y - pose.vehicle[1].y);
  return {{aside, raised},
          (state.bar_velocity - pose.vehicle_velocity[0]) +
              (state.bar_velocity - pose.vehicle_velocity[1])};
}

/// E of (18), J, plus the bar's rotational energy.
template <Real R>
MULTILIFT_INLINE R mechanical_energy(const Plant<R>& p, const State<R>& state, const Pose<R>& pose,
                                     const Swing<R>& swing) {
  R twice_kinetic = p.bar_mass * dot(state.bar_velocity, state.bar_velocity) +
                    p.bar_inertia * square(state.theta_dot[2]);
  for (std::size_t i = 0; i < 2; ++i)
    twice_kinetic += p.vehicle_mass[i] * dot(pose.vehicle_velocity[i], pose.vehicle_velocity[i]);
  return R(0.5) * (twice_kinetic + p.bar_mass * p.gravity * swing.displacement.z);
}

/// E_k of (46), J; the bar's rotational energy enters with weight 1 + k_lambda kappa.
template <Real R>
MULTILIFT_INLINE R shaped_energy(const Plant<R>& p, const R& k_lambda, const State<R>& state,
                                 const Pose<R>& pose, const Swing<R>& swing) {
  // 2 (1 + m3/4m1 + m3/4m2) = m3 kappa / 2
  return mechanical_energy(p, state, pose, swing) +
         R(0.5) * k_lambda *
             (dot(swing.rate, swing.rate) +
              p.bar_mass * p.kappa * p.gravity * swing.displacement.z +
              p.kappa * p.bar_inertia * square(state.theta_dot[2]));
}

/// The unified error (48) and its rate.
template <Real R>
struct UnifiedError {
  std::array<Vec2<R>, 2> eps;      // m
  std::array<Vec2<R>, 2> eps_dot;  // m/s
};

/// k_lambda/m_i, by which (47) leans each vehicle after the swing.
template <Real R>
std::array<R, 2> swing_coupling(const Plant<R>& p, const R& k_lambda) {
  return {k_lambda * p.inverse_mass[0], k_lambda * p.inverse_mass[1]};
}

/// `coupling` is k_lambda/m_i.
template <Real R>
MULTILIFT_INLINE UnifiedError<R> unified_error(const std::array<R, 2>& coupling,
                                               const Swing<R>& swing,
                                               const std::array<Vec2<R>, 2>& vehicle,
                                               const std::array<Vec2<R>, 2>& vehicle_velocity,
                                               const std::array<Vec2<R>, 2>& goal) {
  // eta_i = -(k_lambda/m_i) swing, (47)
  return {each<R>(both(vehicle) - both(goal) - both(coupling) * both(swing.displacement)),
          each<R>(both(vehicle_velocity) - both(coupling) * both(swing.rate))};
}

/// Where vehicles and load shall be at an instant, and the forces that take them along.
template <Real R>
struct Target {
  std::array<Vec2<R>, 2> vehicle;           // xi_id, m
  std::array<Vec2<R>, 2> vehicle_velocity;  // m/s
  std::array<Vec2<R>, 2> feedforward;       // u that the motion takes, N
  Swing<R> swing;                           // of the load on its way
};

/// The rate of the unified reference xi_id + eta_d, m/s.
template <Real R>
std::array<Vec2<R>, 2> reference_rate(const std::array<R, 2>& coupling, const Target<R>& target) {
  return each<R>(both(target.vehicle_velocity) - both(coupling) * both(target.swing.rate));
}

/// Turns an error from a resting goal into one from a target that moves: both vehicles and load are
/// measured against where they shall be.
template <Real R>
MULTILIFT_NOINLINE void follow(UnifiedError<R>& error, const std::array<R, 2>& coupling,
                               const std::array<Vec2<R>, 2>& goal, const Target<R>& target) {
  const auto rate = reference_rate(coupling, target);
  for (std::size_t i = 0; i < 2; ++i) {
    error.eps[i] += goal[i] - target.vehicle[i] + coupling[i] * target.swing.displacement;
    error.eps_dot[i] -= rate[i];
  }
}

/// What changes the storage function, W; integrated over time, J.
template <Real R>
struct Powers {
  R dissipation{0.0};  // the right side of (57): never positive
  R internal{0.0};     // cable force difference times deformation of the formation
  R push{0.0};         // pushes on vehicles and bar
  R actuation{0.0};    // eps_dot . (u applied - u of the law at this instant)
  R adaptation{0.0};   // estimate held between control instants, against (51)
  R reference{0.0};    // of a moving reference

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"dissipation", "J", Range::any, "right side of (57)"}, self.dissipation);
    v(Field{"internal_force", "J", Range::any,
            "the term (57) lacks: internal force of the bar times deformation of the formation"},
      self.internal);
    v(Field{"push", "J", Range::any, "pushes on vehicles and bar"}, self.push);
    v(Field{"actuation", "J", Range::any,
            "force applied less the law's: sampling, delay, lag, limits, noise, integral, wrong "
            "masses; for a law without a storage function, the whole work of u"},
      self.actuation);
    v(Field{"adaptation", "J", Range::any,
            "estimate updated at control instants, against (51); for a law without a storage "
            "function, the work of the vehicles' drag"},
      self.adaptation);
    v(Field{"reference", "J", Range::any, "of a moving reference"}, self.reference);
  }

  friend Powers operator+(const Powers& a, const Powers& b) {
    return {a.dissipation + b.dissipation, a.internal + b.internal,     a.push + b.push,
            a.actuation + b.actuation,     a.adaptation + b.adaptation, a.reference + b.reference};
  }
  friend Powers operator*(const R& k, const Powers& a) {
    return {k * a.dissipation, k * a.internal,   k * a.push,
            k * a.actuation,   k * a.adaptation, k * a.reference};
  }
  R total() const { return dissipation + internal + push + actuation + adaptation + reference; }
};

/// What energies and powers share at one state.
template <Real R>
struct Formation {
  Swing<R> swing;
  UnifiedError<R> error;
};

/// A moving reference drives with its rate whatever acts on the vehicles, and with eps_dot the
/// force that it asks for, which the law adds on purpose.
template <Real R>
MULTILIFT_NOINLINE void add_reference(Powers<R>& w, const Plant<R>& p, const Pose<R>& pose,
                                      const std::array<Vec2<R>, 2>& eps_dot,
                                      const std::array<Vec2<R>, 2>& rate, const Loads<R>& loads,
                                      const Target<R>& target) {
  for (std::size_t i = 0; i < 2; ++i) {
    Vec2<R> force = loads.u[i] - scale(p.vehicle_drag[i], pose.vehicle_velocity[i]);
    if (loads.pushed) force += loads.vehicle_push[i];
    const R wanted = dot(eps_dot[i], target.feedforward[i]);
    w.reference += dot(rate[i], force) + wanted;
    w.actuation -= wanted;
  }
}

/// The storage function (49) of a law on a plant and the powers that change it, with the products
/// of gains and masses found once.
template <Real R>
class Storage {
 public:
  Storage(const Plant<R>& p, const StorageGains<R>& gains, const std::array<Vec2<R>, 2>& goal)
      : gains_(gains),
        goal_(goal),
        coupling_(swing_coupling(p, gains.k_lambda)),
        bar_coupling_(R(2.0) * gains.k_lambda * p.inverse_bar_mass),
        weight_(R(1.0) + gains.k_lambda * p.kappa),
        half_coupling_(R(0.5) * gains.k_lambda * p.kappa),
        half_asymmetry_(R(0.5) * gains.k_lambda * (p.inverse_mass[0] - p.inverse_mass[1])) {
    for (std::size_t k = 0; k < 3; ++k) swing_damping_[k] = weight_ * p.swing_damping[k];
  }

  /// `target` is null where the goal rests, here and below.
  MULTILIFT_INLINE Formation<R> formation(const Plant<R>& p, const State<R>& state,
                                          const Pose<R>& pose, const Target<R>* target) const {
    Swing<R> swing = swing_of(p, state, pose);
    Formation<R> formation{
        swing, unified_error(coupling_, swing, pose.vehicle, pose.vehicle_velocity, goal_)};
    if (target != nullptr) follow(formation.error, coupling_, goal_, *target);
    return formation;
  }

  /// The last term of (49): half of the estimation error weighed by the inverse of Gamma, J.
  MULTILIFT_INLINE R estimation_energy(const Plant<R>& p,
                                       const std::array<Vec2<R>, 2>& d_hat) const {
    R sum(0.0);
    for (std::size_t i = 0; i < 2; ++i) {
      Vec2<R> error = p.vehicle_drag[i] - d_hat[i];
      sum += dot(gains_.inverse_gamma[i], scale(error, error));
    }
    return R(0.5) * sum;
  }

  /// (49) without its last term, J.
  MULTILIFT_INLINE R motion_energy(const Plant<R>& p, const State<R>& state, const Pose<R>& pose,
                                   const Formation<R>& formation) const {
    Vec2<Both<R>> eps = both(formation.error.eps);
    return shaped_energy(p, gains_.k_lambda, state, pose, formation.swing) +
           R(0.5) * sum(dot(both(gains_.k_p), scale(eps, eps)));
  }

  MULTILIFT_INLINE Powers<R> powers(const Plant<R>& p, const State<R>& state, const Pose<R>& pose,
                                    const Formation<R>& formation, const Loads<R>& loads,
                                    const Motion<R>& motion, const std::array<Vec2<R>, 2>& d_hat,
                                    const Target<R>* target) const {
    const Swing<R>& swing = formation.swing;
    using B = Both<R>;
    Vec2<B> eps = both(formation.error.eps), eps_dot = both(formation.error.eps_dot);
    Vec2<B> velocity = both(pose.vehicle_velocity);
    Vec2<B> compensation = scale(both(d_hat), velocity);
    B braking = dot(eps_dot, scale(both(gains_.k_d), eps_dot));
    R damping(0.0);
    for (std::size_t k = 0; k < 3; ++k) damping += swing_damping_[k] * square(state.theta_dot[k]);

    Powers<R> w;
    w.dissipation = -(sum(braking) + damping);
    // u less the law's, of which -K_d eps_dot is the braking.
    w.actuation =
        sum(dot(eps_dot, both(loads.u) + scale(both(gains_.k_p), eps) - compensation) + braking);
    w.adaptation = sum(dot(eps_dot, compensation - scale(both(p.vehicle_drag), velocity)));
    if (loads.pushed)
      w.push = dot(loads.bar_push, state.bar_velocity) +
               bar_coupling_ * dot(swing.rate, loads.bar_push) +
               weight_ * loads.bar_torque * state.theta_dot[2] +
               sum(dot(eps_dot, both(loads.vehicle_push)));
    Vec2<R> difference = motion.cable_force[0] - motion.cable_force[1];
    Vec2<R> deformation = pose.vehicle_velocity[0] - pose.vehicle_velocity[1];
    w.internal = dot(difference, half_coupling_ * deformation + half_asymmetry_ * swing.rate);
    if (target != nullptr)
      add_reference(w, p, pose, formation.error.eps_dot, reference_rate(coupling_, *target), loads,
                    *target);
    return w;
  }

 private:
  StorageGains<R> gains_;
  std::array<Vec2<R>, 2> goal_;
  std::array<R, 2> coupling_;
  R bar_coupling_, weight_, half_coupling_, half_asymmetry_;
  std::array<R, 3> swing_damping_;
};

}  // namespace multilift::planar
