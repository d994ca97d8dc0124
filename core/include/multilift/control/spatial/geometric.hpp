// Geometric control of a rigid payload on cables, after T. Lee, "Geometric control of quadrotor
// UAVs transporting a cable-suspended rigid body", IEEE Trans. Control Systems Technology 26(1),
// 2018.
//
// Outer loop: the payload's pose errors ask for a wrench, which the cables share (allocation.hpp):
// mu_i is the force that cable i shall exert. Inner loop: each vehicle turns its cable's direction
// d_i on the sphere towards mu_i / |mu_i| while it holds the tension T_i = mu_i . d_i.
//
//     e'' = -k_p e - k_d e' - k_i integral(e),   w' = -K_R e_R - K_w e_w - K_I integral(e_R) wanted
//     omega_i' = -k_q (c_i x d_i) - k_c e_omega - (d_i . w_i) d_i' + (I - d_i d_i') w_i' wanted u_i
//     = T_i d_i + m_i (a_i + g e_3) + m_i l_i d_i''
//
// c_i is the wanted direction, w_i its rate of turning, omega_i = d_i x d_i', e_omega = omega_i -
// (I - d_i d_i') w_i and a_i the attachment's acceleration. Lee's q_i is -d_i. Other than there:
//
//  * The wrench's gains are per unit of mass and inertia, and the payload's gyroscopic torque is
//    cancelled at its rate rather than at the wanted one.
//  * a_i and the rates of mu_i need the payload's accelerations. They follow from the tensions that
//    this law makes, which are known, not from differentiated measurements: three passes over the
//    cables give mu_i, mu_i', mu_i''. The rate of e_R is exact, its second rate to first order in
//    the error; of the target's heading, derivatives above the third are left out.
//  * Lee leaves the internal forces open; here the formation's at rest are kept.
//  * No integral of the cables' errors, and linear drag as assumed is made up for.
#pragma once

#include "multilift/control/spatial/allocation.hpp"
#include "multilift/control/spatial/attitude_error.hpp"
#include "multilift/control/spatial/cable_tracking.hpp"
#include "multilift/control/spatial/geometric_gains.hpp"
#include "multilift/control/spatial/law.hpp"

namespace multilift::spatial {

template <Real R>
class Geometric : public Law<R> {
 public:
  static constexpr const char* name = "geometric";
  static constexpr const char* title = "geometric control of the payload's pose on SE(3)";

  using Gains = GeometricGains<R>;

  Geometric(const Gains& gains, const Parameters<R>& assumed, double period)
      : Law<R>(assumed.size()),
        gains_(gains),
        assumed_(assumed),
        period_(period),
        allocation_(assumed.attachment),
        turns_(R(0.0) <
               assumed.payload_inertia.x + assumed.payload_inertia.y + assumed.payload_inertia.z),
        rest_(assumed.size()),
        cable_(assumed.size()) {
    const R zero(0.0), one(1.0);
    zip(
        [&](R& inverse, const R& inertia) {
          const mask_t<R> some = zero < inertia;
          inverse = select(some, one / select(some, inertia, one), zero);
        },
        inverse_inertia_, assumed_.payload_inertia);
  }

  void step(const Measurement<R>& measured, const Target<R>& target,
            std::vector<Vec3<R>>& force) override {
    const Payload p = observe(measured, target);
    const Vec3<R> g = p.turn.to_body({R(0.0), R(0.0), assumed_.gravity});
    Outer o;
    share_out(p, target, o);
    wanted_directions(p, target, o);
    for (std::size_t i = 0; i < force.size(); ++i) {
      const TrackedCable<R>& c = cable_[i];
      const R mass = assumed_.vehicle_mass[i];
      const Vec3<R>& r = assumed_.attachment[i];
      const Vec3<R> a = o.acceleration + g + cross(o.turning, r) + cross(p.rate, cross(p.rate, r));
      const Vec3<R> pull =
          c.tension * c.d + mass * a +
          (mass * assumed_.cable_length[i]) * c.wanted_bend(gains_.k_cable, gains_.k_cable_rate);
      force[i] =
          p.turn.to_world(pull) + scale(assumed_.vehicle_drag[i], measured.vehicle_velocity[i]);
    }
    integrate(p, measured);
  }

 private:
  /// Vectors are rates in W, their coordinates those of the payload's frame, unless said otherwise.
  struct Payload {
    Rotation<R> turn;
    Vec3<R> rate, velocity;
    Vec3<R> error, error_rate;  // of the position
    R near;                     // by how much the error's limit shortens it
    Vec3<R> far_along;          // unit vector along an error that is over its limit, else zero
    AttitudeError<R> attitude;
    Vec3<R> spin, spin_rate,
        spin_jerk_at_rest;  // wanted rate of turning and its derivatives in this frame
  };

  /// What the payload does under the tensions of this law.
  struct Outer {
    Vec3<R> acceleration;  // m/s^2
    Vec3<R> turning;       // rad/s^2
    Wrench<R> wanted;
  };

  Payload observe(const Measurement<R>& measured, const Target<R>& target) {
    const R zero(0.0), one(1.0);
    const RigidBody<R>& body = measured.payload;
    const Rotation<R> level = level_at(target.heading);
    // A point mass has no attitude: its frame is the target's, so that the formation keeps to that.
    const Rotation<R> own = rotation(body.attitude);
    const Rotation<R> turn{select<R>(turns_, own.x, level.x), select<R>(turns_, own.y, level.y),
                           select<R>(turns_, own.z, level.z)};
    Payload p{turn,
              select<R>(turns_, body.rate, {zero, zero, target.yaw_rate}),
              turn.to_body(body.velocity),
              turn.to_body(body.position - target.payload),
              turn.to_body(body.velocity - target.payload_velocity),
              one,
              {},
              AttitudeError<R>(turn, level),
              {},
              {},
              {}};
    const R distance = max(norm(p.error), R(1e-12));
    const mask_t<R> far = gains_.error_limit < distance;
    p.near = select(far, gains_.error_limit / distance, one);
    p.far_along = select<R>(far, (one / distance) * p.error, {});
    // The wanted attitude turns about the world's upright axis, seen from this frame.
    const Vec3<R> up{turn.x.z, turn.y.z, turn.z.z};
    const Vec3<R> up_rate = cross(up, p.rate);
    p.spin = target.yaw_rate * up;
    p.spin_rate = target.yaw_acceleration * up + target.yaw_rate * up_rate;
    p.spin_jerk_at_rest = target.yaw_jerk * up + (R(2.0) * target.yaw_acceleration) * up_rate +
                          target.yaw_rate * cross(up_rate, p.rate);

    for (std::size_t i = 0; i < cable_.size(); ++i) {
      const Vec3<R>& r = assumed_.attachment[i];
      rest_[i] = level.to_body(target.cable_force[i]);
      cable_[i].observe(
          turn.to_body(measured.vehicle[i] - body.position) - r,
          turn.to_body(measured.vehicle_velocity[i] - body.velocity) - cross(p.rate, r));
    }
    return p;
  }

  /// First pass: the wanted wrench, its shares, the tensions, and what the payload then does.
  void share_out(const Payload& p, const Target<R>& target, Outer& o) {
    const Parameters<R>& a = assumed_;
    const Vec3<R> asked = p.turn.to_body(
        target.payload_acceleration - integral_ + Vec3<R>{R(0.0), R(0.0), a.gravity} -
        scale(gains_.k_position, p.turn.to_world(p.near * p.error)) -
        scale(gains_.k_velocity, p.turn.to_world(p.error_rate)));
    const Vec3<R> world_velocity = p.turn.to_world(p.velocity);
    o.wanted.force =
        a.payload_mass * asked +
        p.turn.to_body(scale(a.payload_drag, world_velocity) +
                       (a.payload_drag_quadratic * norm(world_velocity)) * world_velocity);
    const Vec3<R> turning = p.spin_rate - turn_integral_ -
                            scale(gains_.k_attitude, p.attitude.error) -
                            scale(gains_.k_rate, p.rate - p.spin);
    o.wanted.moment = scale(a.payload_inertia, turning) +
                      cross(p.rate, scale(a.payload_inertia, p.rate)) +
                      scale(a.payload_spin_damping, p.rate);

    const auto parts = allocation_.parts(o.wanted);
    const auto at_rest = allocation_.parts(allocation_.wrench(rest_));
    const R internal = internal_share(parts, at_rest);
    Vec3<R> excess, moment;
    for (std::size_t i = 0; i < cable_.size(); ++i) {
      TrackedCable<R>& c = cable_[i];
      c.mu = allocation_.force(parts, i) + internal * (rest_[i] - allocation_.force(at_rest, i));
      const Vec3<R> pull = c.pull();
      excess += pull - c.mu;
      moment += cross(a.attachment[i], pull);
    }
    // The wanted force makes the asked acceleration; what the cables exert beyond it adds to that.
    const Vec3<R> gravity = p.turn.to_body({R(0.0), R(0.0), a.gravity});
    o.acceleration = asked - gravity + (R(1.0) / a.payload_mass) * excess;
    const Vec3<R> free =
        cross(p.rate, scale(a.payload_inertia, p.rate)) + scale(a.payload_spin_damping, p.rate);
    o.turning = select<R>(turns_, scale(inverse_inertia_, moment - free), p.spin_rate);
  }

  /// How many times the internal forces at rest keep every cable's pull above its floor; bounded,
  /// since they spread the cables. Its own rate is left out of the wanted directions'.
  R internal_share(const typename Allocation<R>::Parts& parts,
                   const typename Allocation<R>::Parts& at_rest) const {
    const R zero(0.0), one(1.0);
    R internal = one;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const R size = max(norm(rest_[i]), R(1e-9));
      const R given = dot(rest_[i], allocation_.force(parts, i)) / size;
      const R each = dot(rest_[i], rest_[i] - allocation_.force(at_rest, i)) / size;
      const mask_t<R> can = R(1e-6) * size < each;
      const R needed = (gains_.tension_floor - given) / select(can, each, one);
      internal = max(internal, select(can, needed, zero));
    }
    return min(internal, R(2.0));
  }

  /// Second and third pass: the first and second derivative of the wanted forces.
  void wanted_directions(const Payload& p, const Target<R>& target, const Outer& o) {
    const Parameters<R>& a = assumed_;
    const R two(2.0);
    const Vec3<R>& w = p.rate;
    const R per_mass = R(1.0) / a.payload_mass;
    // Gains are along the world's axes.
    const auto along_world = [&](const Vec3<R>& gain, const Vec3<R>& v) {
      return p.turn.to_body(scale(gain, p.turn.to_world(v)));
    };
    const auto limited = [&](const Vec3<R>& v) {
      return p.near * (v - dot(v, p.far_along) * p.far_along);
    };
    const auto inertia = [&](const Vec3<R>& v) { return scale(a.payload_inertia, v); };

    const Vec3<R> error2 = o.acceleration - p.turn.to_body(target.payload_acceleration);
    const Vec3<R> asked1 = p.turn.to_body(target.payload_jerk) -
                           along_world(gains_.k_position, limited(p.error_rate)) -
                           along_world(gains_.k_velocity, error2) -
                           along_world(gains_.k_integral, p.near * p.error);
    const Vec3<R> force1 = a.payload_mass * asked1 + along_world(a.payload_drag, o.acceleration);
    Wrench<R> rate;
    rate.force = force1 - cross(w, o.wanted.force);
    const Vec3<R> turn_error_rate = p.attitude.rate(w - p.spin);
    const Vec3<R> turn_error2 = o.turning - p.spin_rate;
    const Vec3<R> spin_jerk = p.spin_jerk_at_rest + cross(p.spin, o.turning);
    const Vec3<R> turning1 = spin_jerk - scale(gains_.k_attitude, turn_error_rate) -
                             scale(gains_.k_rate, turn_error2) -
                             scale(gains_.k_attitude_integral, p.attitude.error);
    const Vec3<R> free1 = cross(o.turning, inertia(w)) + cross(w, inertia(o.turning)) +
                          scale(a.payload_spin_damping, o.turning);
    rate.moment = inertia(turning1) + free1;

    auto parts = allocation_.parts(rate);
    Vec3<R> excess, moment;
    for (std::size_t i = 0; i < cable_.size(); ++i) {
      TrackedCable<R>& c = cable_[i];
      c.share_rate = allocation_.force(parts, i);
      c.mu_rate = c.share_rate + cross(w, c.mu);
      const Vec3<R> pull_rate = c.pull_rate();
      excess += pull_rate - c.mu_rate;
      moment += cross(a.attachment[i], pull_rate - cross(w, c.tension * c.d));
    }
    const Vec3<R> jerk = asked1 + per_mass * excess;
    const Vec3<R> turning_rate =
        select<R>(turns_, scale(inverse_inertia_, moment - free1), spin_jerk);

    const Vec3<R> error3 = jerk - p.turn.to_body(target.payload_jerk);
    const Vec3<R> force2 =
        a.payload_mass *
            (p.turn.to_body(target.payload_snap) - along_world(gains_.k_position, limited(error2)) -
             along_world(gains_.k_velocity, error3) -
             along_world(gains_.k_integral, limited(p.error_rate))) +
        along_world(a.payload_drag, jerk);
    Wrench<R> second;
    second.force = force2 - two * cross(w, rate.force) - cross(o.turning, o.wanted.force) -
                   cross(w, cross(w, o.wanted.force));
    const Vec3<R> turning2 = -scale(gains_.k_attitude, p.attitude.rate(turn_error2)) -
                             scale(gains_.k_rate, turning_rate - spin_jerk) -
                             scale(gains_.k_attitude_integral, turn_error_rate);
    second.moment = inertia(turning2) + two * cross(o.turning, inertia(o.turning)) +
                    cross(turning_rate, inertia(w)) + cross(w, inertia(turning_rate)) +
                    scale(a.payload_spin_damping, turning_rate);
    parts = allocation_.parts(second);
    for (std::size_t i = 0; i < cable_.size(); ++i) {
      TrackedCable<R>& c = cable_[i];
      c.mu_jerk = allocation_.force(parts, i) + two * cross(w, c.share_rate) +
                  cross(o.turning, c.mu) + cross(w, cross(w, c.mu));
    }
  }

  void integrate(const Payload& p, const Measurement<R>& measured) {
    mask_t<R> full = R(0.0) < R(0.0);
    for (const Mask<R>& saturated : measured.saturated) full = full | saturated.is;
    const R limit = gains_.integral_limit, turn_limit = gains_.attitude_integral_limit;
    const auto add = [&](R& sum, const R& gain, const R& error, const R& bound) {
      const R next = clamp(sum + R(period_) * gain * error, -bound, bound);
      sum = select(full & (abs(sum) < abs(next)), sum, next);
    };
    const Vec3<R> error = p.turn.to_world(p.near * p.error);
    zip([&](R& sum, const R& gain, const R& e) { add(sum, gain, e, limit); }, integral_,
        gains_.k_integral, error);
    zip([&](R& sum, const R& gain, const R& e) { add(sum, gain, e, turn_limit); }, turn_integral_,
        gains_.k_attitude_integral, p.attitude.error);
  }

  Gains gains_;
  Parameters<R> assumed_;
  double period_;
  Allocation<R> allocation_;
  mask_t<R> turns_;
  Vec3<R> inverse_inertia_;    // 1/(kg m^2), 0 about axes without inertia
  Vec3<R> integral_;           // W, m/s^2
  Vec3<R> turn_integral_;      // payload frame, rad/s^2
  std::vector<Vec3<R>> rest_;  // the formation's cable forces, payload frame, N
  std::vector<TrackedCable<R>> cable_;
};

}  // namespace multilift::spatial
