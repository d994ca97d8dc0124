// Equations of motion of the spatial plant for any kind of vehicle and of cable.
#pragma once

#include <optional>

#include "multilift/model/spatial/cables.hpp"
#include "multilift/model/spatial/surroundings.hpp"
#include "multilift/model/spatial/vehicle.hpp"

namespace multilift::spatial {

/// Outside forces at one instant, and the air's motion.
template <Real R>
struct Surroundings {
  std::vector<Vec3<R>> vehicle_push;  // W, N
  Vec3<R> payload_push;               // at the centre of mass, W, N
  Vec3<R> payload_push_torque;        // L, N m
  bool pushes = true;                 // whether any of these may be other than zero
  Vec3<R> wind;                       // W, m/s

  explicit Surroundings(std::size_t n) : vehicle_push(n) {}
};

/// Everything about one instant that the equations of motion work out on the way.
template <Real R>
struct Instant {
  Rotation<R> payload_turn;
  std::vector<Cable<R>> cable;
  std::vector<Vec3<R>> thrust;     // force of each vehicle's rotors and their drag, W, N
  std::vector<Vec3<R>> contact;    // the floor's force on each vehicle, W, N
  Vec3<R> payload_contact;         // W, N
  Vec3<R> payload_contact_torque;  // L, N m
  Vec3<R> payload_drag;            // W, N
  Loads<R> loads;
  Motion<R> motion;
  bool floor = false;  // whether there is one; without it nothing above of contact is touched

  explicit Instant(std::size_t n) : cable(n), thrust(n), contact(n), loads(n), motion(n) {}
};

template <Real R, class VehicleKind, class CableKind>
class Dynamics {
 public:
  using Vehicles = VehicleKind;
  using Cables = CableKind;
  using VehicleState = typename Vehicles::State;
  using Input = typename Vehicles::Input;
  using X = State<R, VehicleState>;

  Dynamics(const Plant<R>& plant, const Vehicles& vehicles, const std::optional<Ground<R>>& ground)
      : plant_(plant), vehicles_(vehicles), ground_(ground) {}

  /// Works out `now` at x; `taut` says which rigid cables are, or which elastic ones are whole.
  MULTILIFT_INLINE void evaluate(const X& x, const std::vector<Input>& input,
                                 const Surroundings<R>& outside, const Masks<R>& taut,
                                 Instant<R>& now) const {
    gather(x, input, outside, now);
    Cables::motion(plant_, x.payload, now.cable, now.loads, taut, now.motion);
  }

  /// The same with other cables taut, at the state that `now` was evaluated at.
  void evaluate_tensions(const X& x, const Masks<R>& taut, Instant<R>& now) const {
    Cables::motion(plant_, x.payload, now.cable, now.loads, taut, now.motion);
  }

  /// The state's rate of change once `now` has been evaluated at x.
  MULTILIFT_INLINE void rate(const X& x, const std::vector<Input>& input, const Instant<R>& now,
                             X& rate) const {
    rate.payload.position = x.payload.velocity;
    rate.payload.attitude = quaternion_rate(x.payload.attitude, x.payload.rate);
    rate.payload.velocity = now.motion.payload_acceleration;
    rate.payload.rate = now.motion.payload_angular_acceleration;
    for (std::size_t i = 0; i < x.size(); ++i) {
      rate.vehicle[i].position = x.vehicle[i].velocity;
      rate.vehicle[i].velocity =
          plant_.inverse_mass[i] *
          (now.loads.vehicle[i] - now.motion.tension[i] * now.cable[i].direction);
      vehicles_.turn(i, x.vehicle[i], input[i], rate.vehicle[i]);
    }
  }

  const Plant<R>& plant() const { return plant_; }
  const Vehicles& vehicles() const { return vehicles_; }
  const std::optional<Ground<R>>& ground() const { return ground_; }

  /// The cables alone, where only they are wanted.
  MULTILIFT_INLINE void lay_cables(const X& x, Instant<R>& now) const {
    now.payload_turn = rotation(x.payload.attitude);
    for (std::size_t i = 0; i < x.size(); ++i)
      now.cable[i] = cable_at(plant_.attachment[i], x.payload, now.payload_turn,
                              x.vehicle[i].position, x.vehicle[i].velocity);
  }

 private:
  MULTILIFT_INLINE void gather(const X& x, const std::vector<Input>& input,
                               const Surroundings<R>& outside, Instant<R>& now) const {
    const Plant<R>& p = plant_;
    lay_cables(x, now);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const VehicleState& v = x.vehicle[i];
      const Vec3<R> air = v.velocity - outside.wind;
      now.thrust[i] = vehicles_.force(i, v, input[i], air);
      Vec3<R> force = now.thrust[i] - scale(p.vehicle_drag[i], air) + outside.vehicle_push[i];
      force.z -= p.vehicle_mass[i] * p.gravity;
      now.loads.vehicle[i] = force;
    }
    const Vec3<R> air = x.payload.velocity - outside.wind;
    now.payload_drag = -(scale(p.payload_drag, air) + p.payload_drag_quadratic * norm(air) * air);
    now.loads.payload = now.payload_drag + outside.payload_push;
    now.loads.payload.z -= p.payload_mass * p.gravity;
    now.loads.payload_torque =
        outside.payload_push_torque - scale(p.payload_spin_damping, x.payload.rate);
    now.floor = ground_.has_value();
    if (now.floor) stand(x, now);
  }

  /// Adds what the floor does to those who touch it.
  void stand(const X& x, Instant<R>& now) const {
    const Plant<R>& p = plant_;
    const Ground<R>& ground = *ground_;
    const std::size_t n = x.size();
    const R zero(0.0);
    const R share(1.0 / static_cast<double>(n));
    now.payload_contact = now.payload_contact_torque = {zero, zero, zero};
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3<R> feet = x.vehicle[i].position - Vec3<R>{zero, zero, ground.vehicle_clearance};
      now.contact[i] = contact_force(ground, p.vehicle_mass[i] * p.gravity, p.gravity, feet,
                                     x.vehicle[i].velocity);
      now.loads.vehicle[i] += now.contact[i];

      const Vec3<R> foot = p.attachment[i] - Vec3<R>{zero, zero, ground.payload_clearance};
      const Vec3<R> velocity =
          x.payload.velocity + now.payload_turn.to_world(cross(x.payload.rate, foot));
      const Vec3<R> force =
          contact_force(ground, share * p.payload_mass * p.gravity, p.gravity,
                        x.payload.position + now.payload_turn.to_world(foot), velocity);
      now.payload_contact += force;
      now.payload_contact_torque += cross(foot, now.payload_turn.to_body(force));
    }
    now.loads.payload += now.payload_contact;
    now.loads.payload_torque += now.payload_contact_torque;
  }

  Plant<R> plant_;
  Vehicles vehicles_;
  std::optional<Ground<R>> ground_;
};

}  // namespace multilift::spatial
