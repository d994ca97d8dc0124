// What happens to a flight from outside at given times: pushes, cables cut, rotors and vehicles
// lost.
#pragma once

#include "multilift/model/spatial/dynamics.hpp"
#include "multilift/sim/push.hpp"

namespace multilift::spatial {

/// A push on the payload (body -1) or on a vehicle, at the centre of mass.
template <Real R>
struct Push {
  int body{-1};
  Vec3<R> force;   // W, N, times the profile
  Vec3<R> torque;  // L, N m, times the profile; payload only
  PushProfile<R> profile;
};

template <Real R>
MULTILIFT_INLINE void add_pushes(const std::vector<Push<R>>& pushes, const R& time, Stage stage,
                                 Surroundings<R>& outside) {
  const R zero(0.0);
  for (Vec3<R>& push : outside.vehicle_push) push = {zero, zero, zero};
  outside.payload_push = outside.payload_push_torque = {zero, zero, zero};
  for (const Push<R>& push : pushes) {
    const R height = push.profile.at(time, stage);
    if (push.body < 0) {
      outside.payload_push += height * push.force;
      outside.payload_push_torque += height * push.torque;
    } else {
      outside.vehicle_push[static_cast<std::size_t>(push.body)] += height * push.force;
    }
  }
}

enum class Failure { cable_cut, rotor_stopped, vehicle_lost };

/// Something that breaks for good. A lost vehicle's rotors all stop.
struct Happening {
  Failure what{Failure::cable_cut};
  std::size_t vehicle{0};
  std::size_t rotor{0};
  long step{0};  // from which on
};

}  // namespace multilift::spatial
