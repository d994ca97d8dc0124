// The pushes of a scenario, summed over what they act on.
#pragma once

#include <type_traits>
#include <vector>

#include "multilift/model/planar/dynamics.hpp"
#include "multilift/sim/push.hpp"

namespace multilift::planar {

/// What a push acts on: vehicle 1, vehicle 2 (at their centres) or the bar's centre of mass.
enum class Body { vehicle_1, vehicle_2, bar };

template <Real R>
struct Push {
  Body body{Body::bar};
  Vec2<R> force;  // world y-z, N, times the profile
  R torque{0.0};  // N m, times the profile; bar only
  PushProfile<R> profile;
};

/// The loads at a stage of a step: the applied command and every push. Worlds may differ in time.
template <Real R>
MULTILIFT_INLINE Loads<R> loads_at(const std::type_identity_t<R>& time, Stage stage,
                                   const std::array<Vec2<R>, 2>& applied,
                                   const std::vector<Push<R>>& pushes) {
  Loads<R> loads{applied, {}, {}, R(0.0), !pushes.empty()};
  for (const Push<R>& push : pushes) {
    R height = push.profile.at(time, stage);
    Vec2<R> force = height * push.force;
    if (push.body == Body::bar) {
      loads.bar_push += force;
      loads.bar_torque += height * push.torque;
    } else if (push.body == Body::vehicle_1) {  // no index, which would keep loads in memory
      loads.vehicle_push[0] += force;
    } else {
      loads.vehicle_push[1] += force;
    }
  }
  return loads;
}

}  // namespace multilift::planar
