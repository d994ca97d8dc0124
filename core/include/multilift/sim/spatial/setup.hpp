// Everything about a world besides the law that flies it.
#pragma once

#include "multilift/sim/spatial/actuation.hpp"
#include "multilift/sim/spatial/clearance.hpp"
#include "multilift/sim/spatial/happenings.hpp"
#include "multilift/sim/spatial/motion_capture.hpp"
#include "multilift/sim/spatial/weather.hpp"
#include "multilift/sim/timing.hpp"

namespace multilift::spatial {

template <Real R, class Vehicles, class Cables>
struct Setup {
  using VehicleState = typename Vehicles::State;

  Plant<R> plant;
  Parameters<R> assumed;
  Vehicles vehicles;
  std::optional<Ground<R>> ground;
  State<R, VehicleState> start;
  Formation<R> formation;
  Reference<R> reference;
  LinkParameters<R> link;
  LimitParameters<R> limits;
  std::optional<MotionCaptureParameters<R>> motion_capture;
  WindParameters<R> wind;
  SafetyParameters<R> safety;
  std::vector<Push<R>> pushes;
  std::vector<Happening> happenings;
  Timing timing;
  std::array<std::uint64_t, static_cast<std::size_t>(lanes_of<R>)> seeds{};
};

/// What the vehicles are told before anyone commands them: to hold themselves and the load.
template <Real R, class Vehicles, class Cables>
ForceCommand<R> first_command(const Setup<R, Vehicles, Cables>& s, const Target<R>& target) {
  ForceCommand<R> command(s.start.size());
  for (std::size_t i = 0; i < command.force.size(); ++i) {
    command.force[i] = target.cable_force[i];
    command.force[i].z += s.assumed.vehicle_mass[i] * s.assumed.gravity;
  }
  command.yaw = target.yaw;
  return command;
}

/// The motion capture of a world, if its law is not told the truth.
template <Real R, class Vehicles, class Cables>
std::optional<MotionCapture<R>> motion_capture_of(const Setup<R, Vehicles, Cables>& s) {
  if (!s.motion_capture) return {};
  Measurement<R> start(s.start.size());
  tell_truth(s.start, start);
  return MotionCapture<R>(*s.motion_capture, s.timing.control_steps, s.timing.step, s.seeds, start);
}

}  // namespace multilift::spatial
