// Planned moves: ways of load or vehicles within limits, in two coordinates or three.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "multilift/plan/online.hpp"

namespace multilift::bindings {

namespace {

namespace nb = nanobind;

template <std::size_t D>
using Place = std::array<double, D>;

plan::ShaperKind shaper_from(const std::string& name) {
  if (name == "zv") return plan::ShaperKind::zv;
  if (name == "zvd") return plan::ShaperKind::zvd;
  if (name == "ei") return plan::ShaperKind::ei;
  throw std::invalid_argument("no shaper is called '" + name + "'");
}

plan::Follow follow_from(bool load) { return load ? plan::Follow::load : plan::Follow::vehicles; }

std::vector<std::pair<double, double>> impulses(const std::string& kind, double frequency,
                                                double damping, double tolerance) {
  std::vector<std::pair<double, double>> result;
  for (const auto& [time, weight] :
       plan::shaper(shaper_from(kind), {frequency, damping}, tolerance))
    result.emplace_back(time, weight);
  return result;
}

std::vector<plan::Impulse> impulses_from(const std::vector<std::pair<double, double>>& given) {
  std::vector<plan::Impulse> result;
  for (const auto& [time, weight] : given) result.push_back({time, weight});
  return result;
}

template <std::size_t D>
void bind_in(nb::module_& m, const char* name) {
  using Path = plan::Path<D>;
  using PieceTuple = std::tuple<double, std::array<plan::Polynomial, D>>;
  nb::class_<Path> way(m, name, "A planned way; empty where none keeps to the limits.");
  way.def_ro("end", &Path::end, "When it stands still, s; infinite behind a goal that moves.")
      .def_prop_ro(
          "pieces",
          [](const Path& path) {
            std::vector<PieceTuple> pieces;
            for (const auto& piece : path.pieces)
              pieces.emplace_back(piece.start, piece.coordinate);
            return pieces;
          },
          "Start, s, and coefficients of (t - start)^0 to ^9 of each coordinate.")
      .def(
          "at",
          [](const Path& path, double time) {
            if (path.pieces.empty()) throw std::invalid_argument("the way is empty");
            return path.at(time);
          },
          nb::arg("time"), "Each coordinate with four derivatives.");
  way.def_static(
      "timed",
      [](const plan::Motion<D>& from, const Place<D>& goal, const Place<D>& velocity,
         double duration) { return plan::timed_move<D>(from, {goal, velocity}, duration); },
      nb::arg("start"), nb::arg("goal"), nb::arg("goal_velocity"), nb::arg("duration"));
  way.def_static(
      "least_snap",
      [](const Place<D>& from, const Place<D>& to, double duration) {
        return plan::least_snap_move<D>(from, to, duration);
      },
      nb::arg("start"), nb::arg("goal"), nb::arg("duration"));
  way.def_static(
      "move",
      [](const plan::Motion<D>& from, const Place<D>& goal, const Place<D>& velocity,
         const plan::Limits& limits, double remaining) {
        return plan::fastest_move<D>(from, {goal, velocity}, limits, remaining);
      },
      nb::arg("start"), nb::arg("goal"), nb::arg("goal_velocity"), nb::arg("limits"),
      nb::arg("remaining"));
  way.def_static(
      "shaped",
      [](const Place<D>& from, const Place<D>& to, const plan::Limits& limits,
         const std::vector<std::pair<double, double>>& given, const std::array<double, 3>& p,
         bool load) {
        return plan::shaped_move<D>(from, to, limits, impulses_from(given), {p[0], p[1], p[2]},
                                    follow_from(load));
      },
      nb::arg("start"), nb::arg("goal"), nb::arg("limits"), nb::arg("impulses"),
      nb::arg("pendulum"), nb::arg("load"));
  way.def_static(
      "antiswing",
      [](const Place<D>& position, const Place<D>& velocity, const Place<D>& lean,
         const Place<D>& lean_rate, const Place<D>& goal, const Place<D>& goal_velocity,
         const plan::Limits& limits, double ratio, const std::array<double, 3>& p, bool load) {
        return plan::antiswing_move<D>({position, velocity, {lean, lean_rate}},
                                       {goal, goal_velocity}, limits, ratio, {p[0], p[1], p[2]},
                                       follow_from(load));
      },
      nb::arg("position"), nb::arg("velocity"), nb::arg("lean"), nb::arg("lean_rate"),
      nb::arg("goal"), nb::arg("goal_velocity"), nb::arg("limits"), nb::arg("ratio"),
      nb::arg("pendulum"), nb::arg("load"));
}

}  // namespace

void bind_plan(nb::module_& m) {
  bind_in<2>(m, "PlannedWay2");
  bind_in<3>(m, "PlannedWay3");
  m.def(
      "plan_least_snap_duration",
      [](double distance, const plan::Limits& limits) {
        return plan::rest_to_rest_duration(distance, limits, plan::least_snap_peak);
      },
      nb::arg("distance"), nb::arg("limits"), "The shortest time of such a move within limits, s.");
  m.def("shaper_impulses", &impulses, nb::arg("kind"), nb::arg("frequency"), nb::arg("damping"),
        nb::arg("tolerance"), "Times, s, and weights of a shaper's impulses.");
  m.def(
      "shaper_residual",
      [](const std::vector<std::pair<double, double>>& given, double frequency, double damping) {
        return plan::residual(impulses_from(given), {frequency, damping});
      },
      nb::arg("impulses"), nb::arg("frequency"), nb::arg("damping"),
      "What is left of a mode's swing, as a part of that of one impulse.");
}

}  // namespace multilift::bindings
