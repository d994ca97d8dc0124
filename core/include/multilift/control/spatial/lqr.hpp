// Linear state feedback about the formation at rest, its gains worked out elsewhere, such as by
// multilift.models.spatial.lqr as a linear-quadratic regulator:
//
//     u_i = holding force - sum_j (K_ij (p_j - p_jd) + D_ij (v_j - v_jd))
//           - (K_iL (x - x_d) + D_iL (v - v_d) + A_i e_R + B_i (w - w_d))
//
// Every error stands in the level frame with the target's heading, in which the gains were found,
// the attitude's in the payload's own. A regulator of n coupled vehicles feeds each one's state to
// each, so that gains and work grow with n squared; no formation is excluded.
#pragma once

#include "multilift/control/spatial/adaptive_feedback.hpp"
#include "multilift/control/spatial/attitude_error.hpp"

namespace multilift::spatial {

template <Real R>
class Lqr : public Law<R> {
 public:
  static constexpr const char* name = "lqr";
  static constexpr const char* title = "linear state feedback about the formation at rest";

  /// Force along x, y, z per error along or about x, y, z.
  using Matrix = std::array<Vec3<R>, 3>;

  struct Gains {
    explicit Gains(std::size_t n)
        : vehicle_position(n, std::vector<Matrix>(n, every(required))),
          vehicle_velocity(vehicle_position),
          payload_position(n, every(required)),
          payload_velocity(payload_position),
          payload_attitude(payload_position),
          payload_rate(payload_position) {}

    std::vector<std::vector<Matrix>> vehicle_position, vehicle_velocity;
    std::vector<Matrix> payload_position, payload_velocity, payload_attitude, payload_rate;
    R feedforward{1.0};

    static Matrix every(double x) {
      const Vec3<R> row{R(x), R(x), R(x)};
      return {row, row, row};
    }

    template <class Self, class V>
    static void visit(Self& self, V&& v) {
      v(Field{"vehicle_position", "N/m", Range::any,
              "force on vehicle i per error of vehicle j's position, rows the force's axes"},
        self.vehicle_position);
      v(Field{"vehicle_velocity", "N s/m", Range::any, "the same per error of its velocity"},
        self.vehicle_velocity);
      v(Field{"payload_position", "N/m", Range::any, "per error of the payload's position"},
        self.payload_position);
      v(Field{"payload_velocity", "N s/m", Range::any, "per error of its velocity"},
        self.payload_velocity);
      v(Field{"payload_attitude", "N/rad", Range::any, "per error of its attitude about its axes"},
        self.payload_attitude);
      v(Field{"payload_rate", "N s/rad", Range::any, "per error of its angular rate"},
        self.payload_rate);
      v(Field{"feedforward", "", Range::non_negative,
              "how much of the force that the reference's acceleration takes is commanded ahead: 0 "
              "none, 1 all"},
        self.feedforward);
    }
  };

  Lqr(const Gains& gains, const Parameters<R>& assumed, double)
      : Law<R>(assumed.size()),
        gains_(gains),
        assumed_(assumed),
        position_(assumed.size()),
        velocity_(assumed.size()) {}

  void step(const Measurement<R>& measured, const Target<R>& target,
            std::vector<Vec3<R>>& force) override {
    const Rotation<R> level = level_at(target.heading);
    const RigidBody<R>& body = measured.payload;
    const Rotation<R> turn = rotation(body.attitude);
    const Vec3<R> x = level.to_body(body.position - target.payload);
    const Vec3<R> v = level.to_body(body.velocity - target.payload_velocity);
    const AttitudeError<R> attitude(turn, level);
    const Vec3<R> spin = body.rate - target.yaw_rate * attitude.wanted.z;
    for (std::size_t j = 0; j < force.size(); ++j) {
      position_[j] = level.to_body(measured.vehicle[j] - target.vehicle[j]);
      velocity_[j] = level.to_body(measured.vehicle_velocity[j] - target.vehicle_velocity[j]);
    }
    for (std::size_t i = 0; i < force.size(); ++i) {
      Vec3<R> asked = times(gains_.payload_position[i], x) + times(gains_.payload_velocity[i], v) +
                      times(gains_.payload_attitude[i], attitude.error) +
                      times(gains_.payload_rate[i], spin);
      for (std::size_t j = 0; j < force.size(); ++j)
        asked += times(gains_.vehicle_position[i][j], position_[j]) +
                 times(gains_.vehicle_velocity[i][j], velocity_[j]);
      force[i] = holding_force(assumed_, target, gains_.feedforward, i) - level.to_world(asked);
    }
  }

 private:
  static MULTILIFT_INLINE Vec3<R> times(const Matrix& m, const Vec3<R>& v) {
    return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
  }

  Gains gains_;
  Parameters<R> assumed_;
  std::vector<Vec3<R>> position_, velocity_;  // errors in the level frame
};

}  // namespace multilift::spatial
