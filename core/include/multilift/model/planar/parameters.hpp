// The numbers of the planar twin-lift plant (paper, section 2).
#pragma once

#include "multilift/fields.hpp"

namespace multilift::planar {

template <Real R>
struct Parameters {
  std::array<R, 2> vehicle_mass{required, required};
  std::array<R, 2> cable_length{required, required};
  R bar_mass{required};
  R bar_length{required};
  R bar_half_thickness{required};
  R bar_inertia{0.0};
  R gravity{9.8};
  std::array<Vec2<R>, 2> vehicle_drag{};
  std::array<R, 3> swing_damping{R(0.0), R(0.0), R(0.0)};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"vehicle_mass", "kg", Range::positive, "masses m1, m2 of the vehicles"},
      self.vehicle_mass);
    v(Field{"cable_length", "m", Range::positive, "cable lengths l1, l2"}, self.cable_length);
    v(Field{"bar_mass", "kg", Range::positive, "payload mass m3"}, self.bar_mass);
    v(Field{"bar_length", "m", Range::positive, "distance l0 between the cables' ends on the bar"},
      self.bar_length);
    v(Field{"bar_half_thickness", "m", Range::non_negative,
            "l3: how far the bar's centre of mass hangs below the line through the cables' ends"},
      self.bar_half_thickness);
    v(Field{"bar_inertia", "kg m^2", Range::non_negative,
            "rotational inertia of the bar about its centre of mass; the paper takes 0"},
      self.bar_inertia);
    v(Field{"gravity", "m/s^2", Range::non_negative, "gravitational acceleration g"}, self.gravity);
    v(Field{"vehicle_drag", "N s/m", Range::non_negative,
            "damping d_y, d_z of each vehicle's motion, equation (14)"},
      self.vehicle_drag);
    v(Field{"swing_damping", "N m s", Range::non_negative,
            "damping d_theta1, d_theta2, d_theta3 of the three angles, equation (14)"},
      self.swing_damping);
  }
};

/// The parameters with what the equations make of them alone, found once.
template <Real R>
struct Plant : Parameters<R> {
  std::array<R, 2> inverse_mass;    // of the vehicles, 1/kg
  std::array<R, 2> inverse_length;  // of the cables, 1/m
  std::array<R, 2> mass_length;     // vehicle's mass times cable's length, kg m
  std::array<R, 2> couple_rate;     // swing damping over cable length, N s
  R inverse_bar_mass;               // 1/kg
  R kappa;                          // 4/m3 + 1/m1 + 1/m2 of (23), 1/kg
  R half_bar_length;                // m
  R half_bar_weight;                // N
  R twice_bar_and_vehicles;         // 2 m3 + m1 + m2, kg

  explicit Plant(const Parameters<R>& p)
      : Parameters<R>(p),
        inverse_mass{R(1.0) / p.vehicle_mass[0], R(1.0) / p.vehicle_mass[1]},
        inverse_length{R(1.0) / p.cable_length[0], R(1.0) / p.cable_length[1]},
        mass_length{p.vehicle_mass[0] * p.cable_length[0], p.vehicle_mass[1] * p.cable_length[1]},
        couple_rate{p.swing_damping[0] * inverse_length[0], p.swing_damping[1] * inverse_length[1]},
        inverse_bar_mass(R(1.0) / p.bar_mass),
        kappa(R(4.0) * inverse_bar_mass + inverse_mass[0] + inverse_mass[1]),
        half_bar_length(R(0.5) * p.bar_length),
        half_bar_weight(R(0.5) * p.bar_mass * p.gravity),
        twice_bar_and_vehicles(R(2.0) * p.bar_mass + p.vehicle_mass[0] + p.vehicle_mass[1]) {}

  /// Force that holds vehicle i and its half of the bar against gravity, N.
  R gravity_share(std::size_t i) const {
    return (this->vehicle_mass[i] + R(0.5) * this->bar_mass) * this->gravity;
  }
};

}  // namespace multilift::planar
