// A whole run in one call: flat numbers in, a table of samples, metrics and audit out.
#include <nanobind/ndarray.h>

#include <memory>
#include <optional>

#include "arrays.hpp"
#include "planar_path.hpp"
#include "push_names.hpp"

namespace multilift::bindings {

namespace {

using planar::join_seven;
using planar::Measurement;
using planar::Parameters;
using planar::Plant;
using planar::Pose;
using Push = planar::Push<double>;
using planar::Sample;
using planar::Seven;
using planar::State;

using Values = std::vector<double>;

/// A law written in Python: called with time, q, q_dot and saturation flags, answers u1..u4.
class CallbackLaw {
 public:
  explicit CallbackLaw(nb::callable law) : law_(std::move(law)) {}

  planar::Command<double> step(const Measurement<double>& measured) {
    nb::gil_scoped_acquire gil;
    const nb::object u =
        law_(measured.time, join_seven(measured.vehicle, measured.theta),
             join_seven(measured.vehicle_velocity, measured.theta_dot), measured.saturated);
    return pair_from(nb::cast<Four>(u));
  }
  planar::StorageGains<double> storage_gains() const { return {}; }
  std::array<Vec2<double>, 2> d_hat() const { return {}; }

 private:
  nb::callable law_;
};

struct Table {
  std::vector<double> numbers;
  std::size_t columns{0};
};

/// Everything of a run that does not depend on the law's type.
struct Setup {
  Plant<double> plant;
  Plant<double> assumed;  // the plant as the law assumes it
  State<double> start;
  std::array<Vec2<double>, 2> goal;
  std::vector<Push> pushes;
  Timing timing;
  bool ideal;  // actuators and sensors without any imperfection
  planar::ActuatorParameters<double> actuators;
  planar::SensorParameters<double> sensors;
  std::uint64_t seed;
  planar::Path path;  // of the bar; none: the goal rests from the start
  planar::View view;
};

template <class Law>
planar::Outcome<double> run_with(const Setup& s, Law& law, Table& table) {
  const auto record = [&](const Sample<double>& sample, bool) {
    const std::size_t before = table.numbers.size();
    visit_columns(sample, [&](const Field&, double x) { table.numbers.push_back(x); });
    table.columns = table.numbers.size() - before;
  };
  const auto reference = reference_along(s.path, s.assumed, s.goal, s.view);
  table.numbers.reserve(48 * static_cast<std::size_t>(s.timing.steps / s.timing.record_steps + 2));
  if (s.ideal) {
    planar::IdealActuators<double> actuators(s.assumed, s.plant);
    planar::IdealSensors<double> sensors;
    return planar::rollout<true>(s.plant, s.start, s.goal, law, actuators, sensors, s.pushes,
                                 s.timing, record, pointer_to(reference))[0];
  }
  planar::TestbedActuators<double> actuators(s.actuators, s.assumed, s.plant, s.timing.step);
  planar::TestbedSensors<double> sensors(s.sensors, s.timing.control_steps, s.timing.step, {s.seed},
                                         s.start, pose_of(s.plant, s.start));
  return planar::rollout<true>(s.plant, s.start, s.goal, law, actuators, sensors, s.pushes,
                               s.timing, record, pointer_to(reference))[0];
}

nb::dict result_of(const planar::Outcome<double>& outcome, Table&& table) {
  auto* numbers = new std::vector<double>(std::move(table.numbers));
  nb::capsule owner(numbers, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  const std::size_t rows = numbers->size() / table.columns;
  nb::dict d;
  d["samples"] =
      nb::ndarray<nb::numpy, double, nb::ndim<2>>(numbers->data(), {rows, table.columns}, owner);
  d["status"] = multilift::name_of(outcome.status);
  d["culprit"] = outcome.culprit;
  d["end_time"] = outcome.end_time;
  d["metrics"] = as_dict(outcome.metrics);
  d["audit"] = as_dict(outcome.audit);
  return d;
}

Push make_push(const std::string& body, const std::array<double, 2>& force, double torque,
               const std::string& shape, double start, double duration, double frequency,
               Values sample_times, Values sample_values) {
  return {body_from(body),
          {force[0], force[1]},
          torque,
          {shape_from(shape), start, duration, frequency, std::move(sample_times),
           std::move(sample_values)}};
}

Setup make_setup(const Values& plant, const Values& assumed, const Seven<double>& q,
                 const Seven<double>& q_dot, const Four& goal, std::vector<Push> pushes,
                 double step, long steps, long control_steps, long record_steps,
                 const Values& actuators, const Values& sensors, bool ideal, std::uint64_t seed,
                 const std::vector<PlanarPiece>& pieces, double path_end,
                 const std::array<double, 3>& view) {
  const Plant<double> p = plant_from(plant);
  return {p,
          plant_from(assumed),
          state_from_seven(p, q, q_dot),
          pair_from(goal),
          std::move(pushes),
          {step, steps, control_steps, record_steps},
          ideal,
          unpack_checked<planar::ActuatorParameters<double>>(actuators, "actuators"),
          unpack_checked<planar::SensorParameters<double>>(sensors, "sensors"),
          seed,
          planar_path(pieces, path_end),
          planar_view(view)};
}

nb::dict run_law(const Setup& setup, const std::string& name, const Values& gains) {
  std::optional<planar::Outcome<double>> outcome;
  Table table;
  planar::for_each_law<double>([&]<class Law>() {
    if (name != Law::name) return;
    Law law(unpack_checked<typename Law::Gains>(gains, Law::name), setup.assumed, setup.goal,
            setup.timing.control_period());
    nb::gil_scoped_release unlock;
    outcome.emplace(run_with(setup, law, table));
  });
  if (!outcome) throw std::invalid_argument("no compiled law is called '" + name + "'");
  return result_of(*outcome, std::move(table));
}

nb::dict run_callback(const Setup& setup, nb::callable function) {
  CallbackLaw law(std::move(function));
  Table table;
  const auto outcome = run_with(setup, law, table);
  return result_of(outcome, std::move(table));
}

/// Tables of names, units and meanings, from a run of no steps.
nb::dict describe() {
  Parameters<double> p;
  p.vehicle_mass = p.cable_length = {1.0, 1.0};
  p.bar_mass = p.bar_length = 1.0;
  p.bar_half_thickness = 0.0;
  const Setup setup{
      Plant<double>(p), Plant<double>(p), {}, {}, {}, {0.001, 0, 1, 1}, true, {}, {}, 0, {}, {}};
  struct Idle {
    planar::Command<double> step(const Measurement<double>&) { return {}; }
    planar::StorageGains<double> storage_gains() const { return {}; }
    std::array<Vec2<double>, 2> d_hat() const { return {}; }
  } idle;
  nb::list columns;
  planar::IdealActuators<double> actuators(setup.plant, setup.plant);
  planar::IdealSensors<double> sensors;
  const auto outcome =
      planar::rollout<true>(setup.plant, setup.start, setup.goal, idle, actuators, sensors,
                            setup.pushes, setup.timing, [&](const Sample<double>& sample, bool) {
                              visit_columns(sample, [&](const Field& field, double) {
                                columns.append(nb::make_tuple(field.name, field.unit, field.doc));
                              });
                            });
  nb::dict d;
  d["columns"] = columns;
  d["metrics"] = entry_table(outcome[0].metrics);
  d["audit"] = entry_table(outcome[0].audit);
  return d;
}

}  // namespace

void bind_planar_rollout(nb::module_& m) {
  m.def("planar_actuator_fields", &field_table<planar::ActuatorParameters<double>>);
  m.def("planar_sensor_fields", &field_table<planar::SensorParameters<double>>);
  m.def("planar_describe", &describe,
        "{'columns' | 'metrics' | 'audit': [(name, unit, meaning), ...]}.");
  m.attr("planar_delay_capacity") = DelayLine<double, Measurement<double>>::capacity();

  nb::class_<Push>(m, "PlanarPush", "An outside force on a body as a function of time.")
      .def(nb::new_(&make_push), nb::arg("body"), nb::arg("force"), nb::arg("torque"),
           nb::arg("shape"), nb::arg("start"), nb::arg("duration"), nb::arg("frequency"),
           nb::arg("sample_times"), nb::arg("sample_values"));
  nb::class_<Setup>(m, "PlanarSetup", "A run, less its control law.")
      .def(nb::new_(&make_setup), nb::arg("plant"), nb::arg("assumed_plant"), nb::arg("q"),
           nb::arg("q_dot"), nb::arg("goal"), nb::arg("pushes"), nb::arg("step"), nb::arg("steps"),
           nb::arg("control_steps"), nb::arg("record_steps"), nb::arg("actuators"),
           nb::arg("sensors"), nb::arg("ideal"), nb::arg("seed"), nb::arg("pieces"),
           nb::arg("path_end"), nb::arg("view"));
  m.def("planar_rollout", &run_law, nb::arg("setup"), nb::arg("law"), nb::arg("gains"),
        "Runs a compiled law. Releases the GIL.");
  m.def("planar_rollout_python", &run_callback, nb::arg("setup"), nb::arg("law"),
        "Runs a law written in Python, law(t, q, q_dot, saturated) -> (u1, u2, u3, u4).");
}

}  // namespace multilift::bindings
