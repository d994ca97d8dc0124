// The numbers of the spatial plant: n vehicles, a payload and the cables between them.
//
// World W: x east, y north, z up (ENU). Payload frame L: at the payload's centre of mass, axes
// along its principal axes of inertia, level with the world's at rest.
#pragma once

#include <vector>

#include "multilift/fields.hpp"

namespace multilift::spatial {

template <Real R>
struct Parameters {
  /// Everything that is there once a vehicle has room for n.
  explicit Parameters(std::size_t n)
      : vehicle_mass(n, R(required)),
        vehicle_drag(n),
        cable_length(n, R(required)),
        attachment(n),
        cable_stiffness(n, R(5000.0)),
        cable_damping(n, R(20.0)) {}

  R gravity{9.8};
  R payload_mass{required};
  Vec3<R> payload_inertia{R(0.0), R(0.0), R(0.0)};
  Vec3<R> payload_drag{};
  R payload_drag_quadratic{0.0};
  Vec3<R> payload_spin_damping{};
  std::vector<R> vehicle_mass;
  std::vector<Vec3<R>> vehicle_drag;
  std::vector<R> cable_length;
  std::vector<Vec3<R>> attachment;
  std::vector<R> cable_stiffness;
  std::vector<R> cable_damping;
  R cable_restitution{0.0};

  std::size_t size() const { return vehicle_mass.size(); }

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"gravity", "m/s^2", Range::non_negative, "gravitational acceleration g"}, self.gravity);
    v(Field{"payload_mass", "kg", Range::positive, "mass m_L of the payload"}, self.payload_mass);
    v(Field{"payload_inertia", "kg m^2", Range::non_negative,
            "principal moments of inertia about the payload's centre of mass; all 0 for a point "
            "mass"},
      self.payload_inertia);
    v(Field{"payload_drag", "N s/m", Range::non_negative,
            "linear drag of the payload along the world's axes"},
      self.payload_drag);
    v(Field{"payload_drag_quadratic", "N s^2/m^2", Range::non_negative,
            "drag per square of the payload's speed through the air"},
      self.payload_drag_quadratic);
    v(Field{"payload_spin_damping", "N m s", Range::non_negative,
            "damping of the payload's turning about its axes"},
      self.payload_spin_damping);
    v(Field{"vehicle_mass", "kg", Range::positive, "masses m_i of the vehicles"},
      self.vehicle_mass);
    v(Field{"vehicle_drag", "N s/m", Range::non_negative,
            "linear drag of each vehicle along the world's axes, as (14)"},
      self.vehicle_drag);
    v(Field{"cable_length", "m", Range::positive, "rest lengths l_i of the cables"},
      self.cable_length);
    v(Field{"attachment", "m", Range::any, "r_i: where each cable is tied, in the payload's frame"},
      self.attachment);
    v(Field{"cable_stiffness", "N/m", Range::positive,
            "of each elastic cable; rigid cables ignore it"},
      self.cable_stiffness);
    v(Field{"cable_damping", "N s/m", Range::non_negative,
            "of each elastic cable while it is stretched; rigid cables ignore it"},
      self.cable_damping);
    v(Field{"cable_restitution", "", Range::non_negative,
            "of rigid cables that are pulled taut: 0 loses the impact's energy, 1 keeps it"},
      self.cable_restitution);
  }
};

/// The parameters with what the equations divide by, found once.
template <Real R>
struct Plant : Parameters<R> {
  std::vector<R> inverse_mass;    // of the vehicles, 1/kg
  std::vector<R> inverse_length;  // of the cables, 1/m
  R inverse_payload_mass;         // 1/kg
  Vec3<R> turning_inertia;        // as the equations use it: 1 where a point mass has none, kg m^2
  mask_t<R> turns;                // false for a point mass

  explicit Plant(const Parameters<R>& p)
      : Parameters<R>(p),
        inverse_payload_mass(R(1.0) / p.payload_mass),
        turns(R(0.0) < p.payload_inertia.x + p.payload_inertia.y + p.payload_inertia.z) {
    // A point mass has every cable at its centre, so that any inertia leaves it at rest.
    const R one(1.0);
    turning_inertia = select<R>(turns, p.payload_inertia, {one, one, one});
    for (std::size_t i = 0; i < p.size(); ++i) {
      inverse_mass.push_back(one / p.vehicle_mass[i]);
      inverse_length.push_back(one / p.cable_length[i]);
    }
  }
};

}  // namespace multilift::spatial
