// The gains of the geometric law. Per unit of mass and inertia, so that they are the same for any
// team; the defaults suit quadrotors that turn within a quarter of a second behind a link of 20 ms.
#pragma once

#include "multilift/fields.hpp"

namespace multilift::spatial {

template <Real R>
struct GeometricGains {
  explicit GeometricGains(std::size_t) {}

  Vec3<R> k_position{R(1.0), R(1.0), R(2.0)};
  Vec3<R> k_velocity{R(1.8), R(1.8), R(2.5)};
  Vec3<R> k_integral{R(0.2), R(0.2), R(0.4)};
  R integral_limit{2.0};
  R error_limit{1.0};
  Vec3<R> k_attitude{R(2.5), R(2.5), R(2.5)};
  Vec3<R> k_rate{R(2.7), R(2.7), R(2.7)};
  Vec3<R> k_attitude_integral{};
  R attitude_integral_limit{2.0};
  R k_cable{10.0};
  R k_cable_rate{4.0};
  R tension_floor{0.0};

  template <class Self, class V>
  static void visit(Self& self, V&& v) {
    v(Field{"k_position", "1/s^2", Range::positive,
            "payload's acceleration per error of its position along x, y, z"},
      self.k_position);
    v(Field{"k_velocity", "1/s", Range::positive, "per error of its velocity"}, self.k_velocity);
    v(Field{"k_integral", "1/s^3", Range::non_negative, "per integral of its position's error"},
      self.k_integral);
    v(Field{"integral_limit", "m/s^2", Range::positive,
            "bound on the acceleration that the integral asks for along each axis; it also rests "
            "while a vehicle's command is saturated and the error would drive it further"},
      self.integral_limit);
    v(Field{"error_limit", "m", Range::positive,
            "a payload farther from its target asks for no more than at this distance"},
      self.error_limit);
    v(Field{"k_attitude", "1/s^2", Range::positive,
            "payload's angular acceleration per error of its attitude about its axes"},
      self.k_attitude);
    v(Field{"k_rate", "1/s", Range::positive, "per error of its angular rate"}, self.k_rate);
    v(Field{"k_attitude_integral", "1/s^3", Range::non_negative,
            "per integral of its attitude's error"},
      self.k_attitude_integral);
    v(Field{"attitude_integral_limit", "rad/s^2", Range::positive,
            "bound on the angular acceleration that this integral asks for about each axis"},
      self.attitude_integral_limit);
    v(Field{"k_cable", "1/s^2", Range::positive,
            "a cable's angular acceleration per error of its direction"},
      self.k_cable);
    v(Field{"k_cable_rate", "1/s", Range::positive, "per error of its rate of turning"},
      self.k_cable_rate);
    v(Field{"tension_floor", "N", Range::non_negative,
            "where the wrench would leave a cable less pull than this along its direction at rest, "
            "the formation's internal forces grow until it has it, at most to twice those at rest; "
            "that spreads the cables, whose tracking suffers meanwhile, and parallel ones have "
            "none "
            "that could grow"},
      self.tension_floor);
  }
};

}  // namespace multilift::spatial
