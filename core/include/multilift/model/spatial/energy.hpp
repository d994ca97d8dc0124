// Energies of the spatial plant, and the powers that change the storage function of a law.
//
// With r the payload's displacement from where it hangs at rest below the vehicles' plain mean,
// kappa_i = n k_lambda / m_i and h_i the force that cable i asks of its vehicle at rest,
//
//     V = kinetic + m_L g x_z - sum h_i . p_i + 1/2 sum eps_i' K_p eps_i + 1/2 d~' Gamma^-1 d~
//         + n^2 k_lambda (1/2 |r_dot|^2 + g r_z) + sum kappa_i h_i . r + 1/2 c w' J w
//
// c being the mean of c_i = n^2 k_lambda / m_L + kappa_i. For two vehicles in a plane this is (49).
// docs/theory-spatial derives its rate, entry by entry as in Powers.
//
// The momentum-coupled law has k_lambda = 0 here, y_i = e_i - a X in the place of eps_i, and adds
// -1/2 a M |X_dot|^2 + 1/2 g y_p' (sum K_p) y_p; docs/momentum-law derives that.
#pragma once

#include "multilift/control/spatial/energy_coupled.hpp"
#include "multilift/control/spatial/momentum_coupled.hpp"
#include "multilift/model/spatial/dynamics.hpp"

namespace multilift::spatial {

/// What changes the storage function, W; integrated over time, J.
template <Real R>
struct Powers {
  R dissipation{0.0};   // -eps_dot' K_d eps_dot: never positive
  R internal{0.0};      // cable forces times deformation of the formation
  R cables{0.0};        // taken up by stretching cables
  R payload_drag{0.0};  // drag and spin damping of the payload
  R push{0.0};
  R contact{0.0};     // of the floor
  R actuation{0.0};   // eps_dot . (u that acts - u of the law at this instant)
  R adaptation{0.0};  // estimate held between control instants, against (51)
  R reference{0.0};   // of a moving reference
  R impact{0.0};      // cables pulled taut: jumps only

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"dissipation", "J", Range::any, "feedback of the unified error's rate"},
      self.dissipation);
    v(Field{"internal_force", "J", Range::any,
            "cables' forces times the deformation of the formation, and what unequal masses add"},
      self.internal);
    v(Field{"cable_stretch", "J", Range::any, "taken up by cables that change their length"},
      self.cables);
    v(Field{"payload_drag", "J", Range::any, "drag and spin damping of the payload"},
      self.payload_drag);
    v(Field{"push", "J", Range::any, "pushes on vehicles and payload"}, self.push);
    v(Field{"contact", "J", Range::any, "the floor's forces"}, self.contact);
    v(Field{"actuation", "J", Range::any,
            "force that acts less the law's: sampling, delay, loss, limits, attitude loops, noise, "
            "integral, wrong masses; for a law without a storage function, the work of u"},
      self.actuation);
    v(Field{"adaptation", "J", Range::any,
            "estimate updated at control instants, against (51), and wind; for a law without a "
            "storage function, the work of the vehicles' drag"},
      self.adaptation);
    v(Field{"reference", "J", Range::any, "of a moving reference"}, self.reference);
    v(Field{"impact", "J", Range::any, "lost or gained where cables are pulled taut"}, self.impact);
  }

  MULTILIFT_INLINE void add(const R& k, const Powers& w) {
    dissipation += k * w.dissipation;
    internal += k * w.internal;
    cables += k * w.cables;
    payload_drag += k * w.payload_drag;
    push += k * w.push;
    contact += k * w.contact;
    actuation += k * w.actuation;
    adaptation += k * w.adaptation;
    reference += k * w.reference;
    impact += k * w.impact;
  }
  R total() const {
    return dissipation + internal + cables + payload_drag + push + contact + actuation +
           adaptation + reference + impact;
  }
};

/// Where the momentum-coupled law's storage function differs; all zero for other laws.
template <Real R>
struct CommonPart {
  Vec3<R> shift, shift_rate;     // a X and a times the rate of X, as far as not the target's own
  Vec3<R> lead_mean, lead_rate;  // g times the means of the y_i and of their rates
  Vec3<R> velocity;              // a times that of the common centre of mass
  R stored{0.0}, braking{0.0};   // J, W
};

template <Real R, class V>
MULTILIFT_INLINE CommonPart<R> common_part(const Plant<R>& p, const StorageGains<R>& gains,
                                           const State<R, V>& x, const Target<R>& target) {
  CommonPart<R> part;
  if (!gains.lead) return part;
  const R& lead = *gains.lead;
  const R follow = lead / (R(1.0) + lead);
  const auto at = [&](std::size_t i) { return x.vehicle[i].position - target.vehicle[i]; };
  const auto rate = [&](std::size_t i) {
    return x.vehicle[i].velocity - target.vehicle_velocity[i];
  };
  part.shift = follow * common_centre(p, x.payload.position - target.payload, at);
  part.shift_rate = follow * common_centre(p, x.payload.velocity - target.payload_velocity, rate);
  const Vec3<R> own =
      common_centre(p, x.payload.velocity, [&](std::size_t i) { return x.vehicle[i].velocity; });
  part.velocity = follow * own;
  const auto y = [&](std::size_t i) { return at(i) - part.shift; };
  const auto y_dot = [&](std::size_t i) { return rate(i) - part.shift_rate; };
  Vec3<R> all, all_rate;
  const Vec3<R> mean = weighed_mean(gains.k_p, y, all);
  const Vec3<R> mean_rate = weighed_mean(gains.k_d, y_dot, all_rate);
  part.lead_mean = lead * mean;
  part.lead_rate = lead * mean_rate;
  part.stored =
      R(0.5) * (lead * dot(all, scale(mean, mean)) - common_mass(p) * dot(part.velocity, own));
  part.braking = lead * dot(all_rate, scale(mean_rate, mean_rate));
  return part;
}

/// What a law's gains amount to for a plant.
template <Real R>
struct Coupling {
  std::vector<R> kappa, c;
  std::vector<R> one_and_c, c_apart;  // 1 + c, and c less its mean
  R swing{0.0};                       // n^2 k_lambda
  R mean_c{0.0};

  Coupling(const Parameters<R>& p, const StorageGains<R>& gains) {
    const double n = static_cast<double>(p.size());
    swing = R(n * n) * gains.k_lambda;
    for (const R& mass : p.vehicle_mass) {
      kappa.push_back(R(n) * gains.k_lambda / mass);
      c.push_back(swing / p.payload_mass + kappa.back());
      mean_c += R(1.0 / n) * c.back();
      one_and_c.push_back(R(1.0) + c.back());
    }
    for (const R& each : c) c_apart.push_back(each - mean_c);
  }
};

/// Kinetic energy of payload and vehicles as points, J. What vehicles have by turning is their own.
template <Real R, class V>
MULTILIFT_INLINE R kinetic_energy(const Plant<R>& p, const State<R, V>& x) {
  R twice = p.payload_mass * dot(x.payload.velocity, x.payload.velocity) +
            dot(x.payload.rate, scale(p.payload_inertia, x.payload.rate));
  for (std::size_t i = 0; i < x.size(); ++i)
    twice += p.vehicle_mass[i] * dot(x.vehicle[i].velocity, x.vehicle[i].velocity);
  return R(0.5) * twice;
}

/// The same with the potential of gravity, J, from z = 0.
template <Real R, class V>
R mechanical_energy(const Plant<R>& p, const State<R, V>& x) {
  R moment = p.payload_mass * x.payload.position.z;
  for (std::size_t i = 0; i < x.size(); ++i) moment += p.vehicle_mass[i] * x.vehicle[i].position.z;
  return kinetic_energy(p, x) + p.gravity * moment;
}

template <Real R, class V>
MULTILIFT_INLINE Displacement<R> displacement_of(const State<R, V>& x, const Target<R>& target) {
  Vec3<R> mean{}, mean_rate{};
  for (const V& vehicle : x.vehicle) {
    mean += vehicle.position;
    mean_rate += vehicle.velocity;
  }
  const R share(1.0 / static_cast<double>(x.size()));
  return {x.payload.position - share * mean - target.below,
          x.payload.velocity - share * mean_rate - target.below_rate};
}

/// The part of the storage function that the drag estimates make, J.
template <Real R>
MULTILIFT_INLINE R estimation_energy(const Plant<R>& p, const StorageGains<R>& gains,
                                     const std::vector<Vec3<R>>& d_hat) {
  R twice(0.0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec3<R> error = p.vehicle_drag[i] - d_hat[i];
    twice += dot(gains.inverse_gamma[i], scale(error, error));
  }
  return R(0.5) * twice;
}

/// The storage function V, J; 0 at rest at the target with the right estimate.
template <Real R, class V>
MULTILIFT_INLINE R storage_function(const Plant<R>& p, const StorageGains<R>& gains,
                                    const Coupling<R>& coupling, const State<R, V>& x,
                                    const Target<R>& target, const std::vector<Vec3<R>>& d_hat) {
  const auto [r, r_dot] = displacement_of(x, target);
  const CommonPart<R> common = common_part(p, gains, x, target);
  R potential = p.payload_mass * p.gravity * (x.payload.position.z - target.payload.z);
  R twice_spring(0.0), leaning(0.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3<R> error = x.vehicle[i].position - target.vehicle[i];
    const Vec3<R> eps = error - coupling.kappa[i] * r - common.shift;
    potential -= dot(target.cable_force[i], error);
    leaning += coupling.kappa[i] * dot(target.cable_force[i], r);
    twice_spring += dot(gains.k_p[i], scale(eps, eps));
  }
  const R spin = dot(x.payload.rate, scale(p.payload_inertia, x.payload.rate));
  return kinetic_energy(p, x) + common.stored + potential + leaning + R(0.5) * twice_spring +
         estimation_energy(p, gains, d_hat) +
         coupling.swing * (R(0.5) * dot(r_dot, r_dot) + p.gravity * r.z) +
         R(0.5) * coupling.mean_c * spin;
}

/// Adds what outside forces on the vehicles and on the payload, with a torque there, do: each
/// against the velocity that it works on in the storage function.
template <Real R, class Velocity>
MULTILIFT_INLINE void add_outside_power(R& power, const std::vector<Vec3<R>>& vehicle,
                                        const Vec3<R>& payload, const Vec3<R>& torque,
                                        Velocity&& eps_dot, const Vec3<R>& lever,
                                        const Vec3<R>& spin) {
  for (std::size_t i = 0; i < vehicle.size(); ++i) power += dot(eps_dot(i), vehicle[i]);
  power += dot(lever, payload) + dot(spin, torque);
}

/// What a moving reference adds; `r` is the payload's displacement and `r_dot` its rate, and
/// `common_velocity` a times the target's of the common centre of mass.
template <Real R, class V>
MULTILIFT_INLINE R reference_power(const Plant<R>& p, const Coupling<R>& coupling,
                                   const State<R, V>& x, const Instant<R>& now,
                                   const Surroundings<R>& outside, const Target<R>& target,
                                   const Displacement<R>& displacement,
                                   const Vec3<R>& common_velocity) {
  const auto& [r, r_dot] = displacement;
  R power = -(p.payload_mass * p.gravity * target.payload_velocity.z) -
            coupling.swing * dot(r_dot, target.below_acceleration) +
            p.payload_mass * p.gravity * common_velocity.z;
  for (std::size_t i = 0; i < x.size(); ++i) {
    Vec3<R> force = now.thrust[i] - scale(p.vehicle_drag[i], x.vehicle[i].velocity - outside.wind);
    force.z -= p.vehicle_mass[i] * p.gravity;
    if (outside.pushes) force += outside.vehicle_push[i];
    if (now.floor) force += now.contact[i];
    const Vec3<R> error = x.vehicle[i].position - target.vehicle[i];
    power += dot(target.vehicle_velocity[i] - common_velocity, force) -
             dot(target.cable_force_rate[i], error - coupling.kappa[i] * r);
  }
  return power;
}

template <Real R, class V>
MULTILIFT_INLINE Powers<R> powers_of(const Plant<R>& p, const StorageGains<R>& gains,
                                     const Coupling<R>& coupling, const State<R, V>& x,
                                     const Instant<R>& now, const Surroundings<R>& outside,
                                     const Target<R>& target, const std::vector<Vec3<R>>& d_hat) {
  const Displacement<R> displacement = displacement_of(x, target);
  const auto& [r, r_dot] = displacement;
  const Vec3<R>& omega = x.payload.rate;
  const Vec3<R> mean_rate = x.payload.velocity - r_dot;  // of the vehicles
  const CommonPart<R> common = common_part(p, gains, x, target);
  const auto eps_dot_of = [&](std::size_t i) {
    const Vec3<R> still = x.vehicle[i].velocity - coupling.kappa[i] * r_dot - common.shift_rate;
    return target.moves ? still - target.vehicle_velocity[i] : still;
  };

  Powers<R> w;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3<R>& v = x.vehicle[i].velocity;
    const Vec3<R> eps =
        x.vehicle[i].position - target.vehicle[i] - coupling.kappa[i] * r - common.shift;
    const Vec3<R> eps_dot = eps_dot_of(i);
    Vec3<R> u = now.thrust[i] - target.cable_force[i];
    u.z -= p.vehicle_mass[i] * p.gravity;
    const Vec3<R> compensation = scale(d_hat[i], v);
    const Vec3<R> drag = scale(p.vehicle_drag[i], v - outside.wind);
    const R braking = dot(gains.k_d[i], scale(eps_dot, eps_dot));
    w.dissipation -= braking;
    w.actuation +=
        dot(eps_dot, u + scale(gains.k_p[i], eps + common.lead_mean) - compensation) + braking;
    w.adaptation += dot(eps_dot, compensation - drag);
    const Cable<R>& cable = now.cable[i];
    const R& tension = now.motion.tension[i];
    w.internal += tension * (coupling.c[i] * dot(cable.direction, v - mean_rate) -
                             coupling.c_apart[i] * dot(omega, cable.moment));
    w.cables -= coupling.one_and_c[i] * tension * cable.stretch_rate;
  }
  w.dissipation -= common.braking;
  w.actuation += common.braking;
  const Vec3<R> lever =
      x.payload.velocity + (coupling.swing * p.inverse_payload_mass) * r_dot - common.velocity;
  const Vec3<R> spin = (R(1.0) + coupling.mean_c) * omega;
  w.payload_drag = dot(lever, now.payload_drag) - dot(spin, scale(p.payload_spin_damping, omega));
  if (outside.pushes)
    add_outside_power(w.push, outside.vehicle_push, outside.payload_push,
                      outside.payload_push_torque, eps_dot_of, lever, spin);
  if (now.floor)
    add_outside_power(w.contact, now.contact, now.payload_contact, now.payload_contact_torque,
                      eps_dot_of, lever, spin);
  if (target.moves)
    w.reference = reference_power(p, coupling, x, now, outside, target, displacement,
                                  common.velocity - common.shift_rate);
  return w;
}

}  // namespace multilift::spatial
