// The columns of a recorded spatial trajectory: name, unit, meaning and value of each in one place.
#pragma once

#include <string>

#include "multilift/model/spatial/energy.hpp"
#include "multilift/model/spatial/quadrotor.hpp"
#include "multilift/sim/spatial/metrics.hpp"

namespace multilift::spatial {

/// Calls v(name, unit, doc, x) for each column; names count vehicles from 1.
template <Real R, class V, class F>
void visit_columns(const Sample<R, V>& s, F&& v) {
  const auto column = [&](const std::string& name, const char* unit, const std::string& doc,
                          const R& x) { v(name, unit, doc, x); };
  const auto vector = [&](const std::string& name, const char* unit, const std::string& doc,
                          const Vec3<R>& x) {
    column(name + "_x", unit, doc + ", x", x.x);
    column(name + "_y", unit, doc + ", y", x.y);
    column(name + "_z", unit, doc + ", z", x.z);
  };
  const auto attitude = [&](const std::string& name, const std::string& of,
                            const Quaternion<R>& q) {
    column(name + "_qw", "", of + "'s attitude to the world, unit quaternion, scalar", q.w);
    column(name + "_qx", "", of + "'s attitude, x", q.x);
    column(name + "_qy", "", of + "'s attitude, y", q.y);
    column(name + "_qz", "", of + "'s attitude, z", q.z);
  };
  const RigidBody<R>& payload = s.x.payload;
  column("t", "s", "time", R(s.time));
  vector("payload", "m", "payload's centre of mass", payload.position);
  vector("payload_v", "m/s", "payload's velocity", payload.velocity);
  attitude("payload", "payload", payload.attitude);
  vector("payload_rate", "rad/s", "payload's angular rate in its frame", payload.rate);
  vector("target", "m", "the payload's target", s.target.payload);
  column("target_yaw", "rad", "the payload's target heading", s.target.yaw);
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const std::string k = std::to_string(i + 1);
    const V& vehicle = s.x.vehicle[i];
    vector("vehicle" + k, "m", "vehicle " + k, vehicle.position);
    vector("vehicle" + k + "_v", "m/s", "vehicle " + k + "'s velocity", vehicle.velocity);
    if constexpr (requires { vehicle.attitude; }) {
      attitude("vehicle" + k, "vehicle " + k, vehicle.attitude);
      vector("vehicle" + k + "_rate", "rad/s", "vehicle " + k + "'s angular rate in its frame",
             vehicle.rate);
      for (std::size_t rotor = 0; rotor < rotors; ++rotor)
        column("vehicle" + k + "_rotor" + std::to_string(rotor + 1), "rad/s",
               "speed of a rotor of vehicle " + k, vehicle.rotor_speed[rotor]);
    }
    vector("goal" + k, "m", "vehicle " + k + "'s target", s.target.vehicle[i]);
    vector("force" + k, "N", "force commanded of vehicle " + k, s.commanded[i]);
    vector("thrust" + k, "N", "force of vehicle " + k + "'s rotors as it acts", s.now.thrust[i]);
    vector("d_hat" + k, "N s/m", "the law's drag estimate for vehicle " + k, s.d_hat[i]);
    column("tension" + k, "N", "tension of cable " + k + ", 0 where slack",
           s.now.motion.tension[i]);
    column("length" + k, "m", "distance from vehicle " + k + " to its attachment",
           s.now.cable[i].length);
  }
  column("energy", "J", "mechanical energy, from z = 0", mechanical_energy(s.plant, s.x));
  column("storage", "J", "storage function of the law", s.storage);
}

}  // namespace multilift::spatial
