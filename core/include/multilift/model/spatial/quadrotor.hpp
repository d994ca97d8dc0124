// A quadrotor as a rigid body with four rotors.
//
// Body frame B: x forward, y left, z up (FLU), at the centre of mass, where the cable is tied too.
// Rotors stand in a circle around it, counted counterclockwise from the front (+ frame) or the
// front left (X frame), and turn alternately, the first one clockwise seen from above, which drives
// the body counterclockwise (+z).
#pragma once

#include <numbers>

#include "multilift/math/sincos.hpp"
#include "multilift/model/spatial/vehicle.hpp"

namespace multilift::spatial {

inline constexpr std::size_t rotors = 4;

/// A vehicle that turns: a rigid body, and its rotors' speeds in rad/s.
template <class R>
struct Craft {
  Vec3<R> position;
  Quaternion<R> attitude;
  Vec3<R> velocity;
  Vec3<R> rate;
  std::array<R, rotors> rotor_speed{R(0.0), R(0.0), R(0.0), R(0.0)};
};

template <class R, class F, class... Same>
MULTILIFT_INLINE void zip(F&& f, Craft<R>& a, Same&... b) {
  zip(f, a.position, b.position...);
  zip(f, a.attitude, b.attitude...);
  zip(f, a.velocity, b.velocity...);
  zip(f, a.rate, b.rate...);
  for (std::size_t k = 0; k < rotors; ++k) f(a.rotor_speed[k], b.rotor_speed[k]...);
}

template <Real R>
class Quadrotors {
 public:
  using State = Craft<R>;
  using Input = std::array<R, rotors>;  // rotor speeds that the motors are told, rad/s

  static constexpr const char* name = "quadrotor";

  struct Parameters {
    explicit Parameters(std::size_t n)
        : inertia(n, {R(required), R(required), R(required)}),
          arm_length(n, R(required)),
          frame_angle(n, R(std::numbers::pi / 4)),
          thrust_coefficient(n, R(required)),
          torque_ratio(n, R(required)),
          rotor_speed_max(n, R(required)),
          rotor_speed_min(n, R(0.0)),
          rotor_time_constant(n, R(required)),
          rotor_drag(n, R(0.0)) {}

    std::vector<Vec3<R>> inertia;
    std::vector<R> arm_length, frame_angle, thrust_coefficient, torque_ratio, rotor_speed_max,
        rotor_speed_min, rotor_time_constant, rotor_drag;

    std::size_t size() const { return arm_length.size(); }

    template <class Self, class V>
    static void visit(Self& self, V&& v) {
      v(Field{"inertia", "kg m^2", Range::positive,
              "principal moments of inertia of each vehicle about its x, y, z"},
        self.inertia);
      v(Field{"arm_length", "m", Range::positive, "from the centre of mass to each rotor"},
        self.arm_length);
      v(Field{"frame_angle", "rad", Range::any,
              "of the first rotor from the front: 45 deg is an X frame, 0 a + frame"},
        self.frame_angle);
      v(Field{"thrust_coefficient", "N s^2", Range::positive,
              "k_f: a rotor's thrust is k_f times the square of its speed in rad/s"},
        self.thrust_coefficient);
      v(Field{"torque_ratio", "m", Range::non_negative, "drag torque of a rotor per its thrust"},
        self.torque_ratio);
      v(Field{"rotor_speed_max", "rad/s", Range::positive, "greatest speed of a rotor"},
        self.rotor_speed_max);
      v(Field{"rotor_speed_min", "rad/s", Range::non_negative, "least speed of a rotor"},
        self.rotor_speed_min);
      v(Field{"rotor_time_constant", "s", Range::positive, "first-order lag of a rotor's speed"},
        self.rotor_time_constant);
      v(Field{"rotor_drag", "kg", Range::non_negative,
              "drag across the rotor axis per rotor speed and airspeed, N / (rad/s m/s)"},
        self.rotor_drag);
    }
  };

  explicit Quadrotors(const Parameters& p) : p_(p) {
    for (std::size_t i = 0; i < p.size(); ++i) {
      const auto [s, c] = sincos(p.frame_angle[i]);
      lever_.push_back({p.arm_length[i] * c, p.arm_length[i] * s});
      inverse_inertia_.push_back(
          {R(1.0) / p.inertia[i].x, R(1.0) / p.inertia[i].y, R(1.0) / p.inertia[i].z});
      inverse_lag_.push_back(R(1.0) / p.rotor_time_constant[i]);
    }
  }

  MULTILIFT_INLINE Vec3<R> force(std::size_t i, const State& x, const Input&,
                                 const Vec3<R>& air) const {
    R thrust(0.0), speed(0.0);
    for (const R& omega : x.rotor_speed) {
      thrust += omega * omega;
      speed += omega;
    }
    const Rotation<R> turn = rotation(x.attitude);
    const R drag = p_.rotor_drag[i] * speed;
    // Across the rotor axis: air less its part along it.
    return (p_.thrust_coefficient[i] * thrust + drag * dot(turn.z, air)) * turn.z - drag * air;
  }

  MULTILIFT_INLINE void turn(std::size_t i, const State& x, const Input& input, State& rate) const {
    std::array<R, rotors> thrust;
    for (std::size_t k = 0; k < rotors; ++k)
      thrust[k] = p_.thrust_coefficient[i] * x.rotor_speed[k] * x.rotor_speed[k];
    // Rotor k stands at the lever (c, s) turned by k quarter turns: (c, s), (-s, c), (-c, -s), ...
    const auto [c, s] = lever_[i];
    const R ahead = thrust[0] - thrust[2], aside = thrust[1] - thrust[3];
    const Vec3<R> torque{s * ahead + c * aside, s * aside - c * ahead,
                         p_.torque_ratio[i] * (thrust[0] - thrust[1] + thrust[2] - thrust[3])};
    rate.attitude = quaternion_rate(x.attitude, x.rate);
    rate.rate = scale(inverse_inertia_[i], torque - cross(x.rate, scale(p_.inertia[i], x.rate)));
    for (std::size_t k = 0; k < rotors; ++k)
      rate.rotor_speed[k] = inverse_lag_[i] * (input[k] - x.rotor_speed[k]);
  }

  const Parameters& parameters() const { return p_; }

 private:
  struct Lever {
    R ahead, aside;  // the first rotor's place, m
  };

  Parameters p_;
  std::vector<Lever> lever_;
  std::vector<Vec3<R>> inverse_inertia_;
  std::vector<R> inverse_lag_;
};

}  // namespace multilift::spatial
