// Spatial worlds as rows of numbers, and what they share.
//
// A row: plant | assumed plant | vehicles | autopilots (quadrotors only) | ground (if there is one)
// | formation | goal x, y, z, yaw | link | limits | motion capture (if there is one) | wind |
// safety | gains | payload's start: position, attitude, velocity, rate (13) | vehicles' starts:
// position, velocity (6 each) | for each push: force (3), torque (3), start, duration, frequency.
//
// Included by the kernels of each instruction set, so that all is in their unnamed namespaces.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "fields.hpp"
#include "multilift/sim/spatial/rollout.hpp"
#include "push_names.hpp"

namespace multilift::bindings {

namespace {

namespace nb = nanobind;
namespace sp = multilift::spatial;

/// Body (-1 the payload), shape, sample times, sample values.
using SpatialPush = std::tuple<int, std::string, std::vector<double>, std::vector<double>>;
/// Start, and coefficients of x, y, z, yaw.
using SpatialPiece = std::tuple<double, std::array<plan::Polynomial, 4>>;
/// What, vehicle, rotor, step.
using SpatialHappening = std::tuple<std::string, std::size_t, std::size_t, long>;

/// What the worlds of one batch share.
struct Frame {
  std::size_t n;
  std::string law;
  bool quadrotors, rigid, ground, motion_capture, rotors_running;
  long autopilot_steps;
  sp::Path path;
  std::vector<SpatialPush> pushes;
  std::vector<sp::Happening> happenings;
  Timing timing;
};

inline sp::Failure failure_from(const std::string& name) {
  if (name == "cable_cut") return sp::Failure::cable_cut;
  if (name == "rotor_stopped") return sp::Failure::rotor_stopped;
  if (name == "vehicle_lost") return sp::Failure::vehicle_lost;
  throw std::invalid_argument("nothing that happens is called '" + name + "'");
}

inline Frame make_frame(std::size_t n, const std::string& law, bool quadrotors, bool rigid,
                        bool ground, bool motion_capture, bool rotors_running, long autopilot_steps,
                        const std::vector<SpatialPiece>& pieces, double path_end,
                        const std::vector<SpatialPush>& pushes,
                        const std::vector<SpatialHappening>& happenings, double step, long steps,
                        long control_steps, long record_steps) {
  Frame frame{n,
              law,
              quadrotors,
              rigid,
              ground,
              motion_capture,
              rotors_running,
              autopilot_steps,
              {{}, path_end},
              pushes,
              {},
              {step, steps, control_steps, record_steps}};
  for (const auto& [start, coordinate] : pieces) frame.path.pieces.push_back({start, coordinate});
  for (const auto& [what, vehicle, rotor, when] : happenings)
    frame.happenings.push_back({failure_from(what), vehicle, rotor, when});
  return frame;
}

inline void bind_frame(nb::module_& m) {
  nb::class_<Frame>(m, "SpatialFrame", "What the spatial worlds of one batch share.")
      .def(
          "__init__",
          [](Frame* self, std::size_t n, const std::string& law, bool quadrotors, bool rigid,
             bool ground, bool motion_capture, bool rotors_running, long autopilot_steps,
             const std::vector<SpatialPiece>& pieces, double path_end,
             const std::vector<SpatialPush>& pushes,
             const std::vector<SpatialHappening>& happenings, double step, long steps,
             long control_steps, long record_steps) {
            new (self) Frame(make_frame(n, law, quadrotors, rigid, ground, motion_capture,
                                        rotors_running, autopilot_steps, pieces, path_end, pushes,
                                        happenings, step, steps, control_steps, record_steps));
          },
          nb::kw_only(), nb::arg("n"), nb::arg("law"), nb::arg("quadrotors"), nb::arg("rigid"),
          nb::arg("ground"), nb::arg("motion_capture"), nb::arg("rotors_running"),
          nb::arg("autopilot_steps"), nb::arg("pieces"), nb::arg("path_end"), nb::arg("pushes"),
          nb::arg("happenings"), nb::arg("step"), nb::arg("steps"), nb::arg("control_steps"),
          nb::arg("record_steps"));
}

/// Where vehicle i starts: at rest or as it was, its rotors holding what it shall.
template <Real R>
sp::PointMass<R> start_of(const sp::IdealVehicles<R>&, std::size_t, const Vec3<R>& position,
                          const Vec3<R>& velocity, const Vec3<R>&, const R&, bool) {
  return {position, velocity};
}
template <Real R>
sp::Craft<R> start_of(const sp::Quadrotors<R>& kind, std::size_t i, const Vec3<R>& position,
                      const Vec3<R>& velocity, const Vec3<R>& force, const R& yaw, bool running) {
  const R size = norm(force), zero(0.0);
  sp::Craft<R> craft;
  craft.position = position;
  craft.velocity = velocity;
  const SinCos<R> half = sincos(R(0.5) * yaw);
  craft.attitude = running ? sp::attitude_along(force, size, half)
                           : Quaternion<R>{half.cos, zero, zero, half.sin};
  const R each = running ? R(1.0 / sp::rotors) * size : zero;
  craft.rotor_speed.fill(sqrt(each / kind.parameters().thrust_coefficient[i]));
  return craft;
}

/// The problem of one world or of several side by side, and its law.
template <Real R, class Vehicles, class Cables>
struct Problem {
  sp::Setup<R, Vehicles, Cables> setup;
  std::optional<sp::AutopilotParameters<R>> autopilot;
  std::unique_ptr<sp::Law<R>> law;
};

template <class P, class Columns>
P take(const Columns& rows, std::size_t& column, std::size_t n) {
  if constexpr (std::is_default_constructible_v<P>)
    return unpack<P>(rows, column);
  else
    return unpack<P>(rows, column, n);
}

template <Real R, class Vehicles, class Cables, class Columns = Rows>
Problem<R, Vehicles, Cables> problem_from(const Frame& frame, const Columns& rows,
                                          const typename sp::MotionCapture<R>::Seeds& seeds) {
  const std::size_t n = frame.n;
  std::size_t column = 0;
  const auto number = [&] { return rows.template at<R>(column++); };
  const auto vector = [&]() -> Vec3<R> { return {number(), number(), number()}; };
  const auto plant = take<sp::Parameters<R>>(rows, column, n);
  const auto assumed = take<sp::Parameters<R>>(rows, column, n);
  const Vehicles vehicles(take<typename Vehicles::Parameters>(rows, column, n));
  std::optional<sp::AutopilotParameters<R>> autopilot;
  if (frame.quadrotors) autopilot = take<sp::AutopilotParameters<R>>(rows, column, n);
  std::optional<sp::Ground<R>> ground;
  if (frame.ground) ground = take<sp::Ground<R>>(rows, column, n);
  auto formation = take<sp::Formation<R>>(rows, column, n);
  formation.complete();
  const Vec3<R> goal = vector();
  const R yaw = number();
  const auto link = take<sp::LinkParameters<R>>(rows, column, n);
  const auto limits = take<sp::LimitParameters<R>>(rows, column, n);
  std::optional<sp::MotionCaptureParameters<R>> capture;
  if (frame.motion_capture) capture = take<sp::MotionCaptureParameters<R>>(rows, column, n);
  const auto wind = take<sp::WindParameters<R>>(rows, column, n);
  const auto safety = take<sp::SafetyParameters<R>>(rows, column, n);
  auto law = sp::make_law<R>(frame.law, assumed, frame.timing.control_period(),
                             [&]<class Gains>() { return take<Gains>(rows, column, n); });

  const sp::Reference<R> reference(goal, yaw, frame.path, formation);
  sp::Target<R> target(n);
  reference.at(0.0, target);
  sp::State<R, typename Vehicles::State> start(n);
  start.payload.position = vector();
  start.payload.attitude = {number(), number(), number(), number()};
  start.payload.velocity = vector();
  start.payload.rate = vector();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3<R> position = vector(), velocity = vector();
    Vec3<R> force = target.cable_force[i];
    force.z += assumed.vehicle_mass[i] * assumed.gravity;
    start.vehicle[i] =
        start_of<R>(vehicles, i, position, velocity, force, target.yaw, frame.rotors_running);
  }
  std::vector<sp::Push<R>> pushes;
  for (const auto& [body, shape, times, heights] : frame.pushes) {
    sp::Push<R> push{body, vector(), vector(), {}};
    const R begin = number(), duration = number(), frequency = number();
    push.profile = {shape_from(shape), begin, duration, frequency, times, heights};
    pushes.push_back(std::move(push));
  }
  if (column != rows.stride)
    throw std::invalid_argument("a world takes " + std::to_string(column) + " numbers, got " +
                                std::to_string(rows.stride));
  return {{sp::Plant<R>(plant), assumed, vehicles, ground, start, formation, reference, link,
           limits, capture, wind, safety, pushes, frame.happenings, frame.timing, seeds},
          autopilot,
          std::move(law)};
}

/// Calls f.template operator()<Vehicles, Cables>() for what the frame says.
template <Real R, class F>
void with_kinds(const Frame& frame, F&& f) {
  const auto with = [&]<class Vehicles>() {
    if (frame.rigid)
      f.template operator()<Vehicles, sp::RigidCables<R>>();
    else
      f.template operator()<Vehicles, sp::ElasticCables<R>>();
  };
  if (frame.quadrotors)
    with.template operator()<sp::Quadrotors<R>>();
  else
    with.template operator()<sp::IdealVehicles<R>>();
}

/// Calls f with what drives the problem's vehicles.
template <Real R, class Vehicles, class Cables, class F>
void with_actuation(const Frame& frame, const Problem<R, Vehicles, Cables>& problem, F&& f) {
  const auto& setup = problem.setup;
  if constexpr (std::is_same_v<Vehicles, sp::Quadrotors<R>>)
    f(sp::Autopilots<R>(*problem.autopilot, setup.vehicles.parameters(),
                        sp::hover_forces(setup.assumed, setup.formation), frame.autopilot_steps,
                        frame.timing.step));
  else
    f(sp::DirectForce<R>());
}

/// Runs a problem under a law; see sp::Rollout::run.
template <Real R, class Vehicles, class Cables, class Record, class Finish>
void run_problem(const Frame& frame, Problem<R, Vehicles, Cables>& problem, sp::Law<R>& law,
                 Record&& record, Finish&& finish) {
  with_actuation(frame, problem, [&]<class Actuation>(Actuation actuation) {
    sp::Rollout<R, Vehicles, Cables, Actuation> rollout(problem.setup, law, std::move(actuation));
    rollout.run(record, finish);
  });
}

}  // namespace

}  // namespace multilift::bindings
