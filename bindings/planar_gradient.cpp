// Exact derivatives of a run: the same rollout over dual numbers, some directions at a time.
//
// Compiled once for each instruction set, like planar_batch.cpp.
#include <optional>

#include "planar_rows.hpp"

namespace multilift::bindings {

namespace {

using planar::Seven;

/// Directions in one rollout: as many as a vector register holds.
constexpr int directions = MULTILIFT_LANES;
using D = Dual<directions>;

/// The run's numbers, each with its derivatives along one group of directions.
class SeededRow {
 public:
  SeededRow(const Array1<const double>& values, const Array2<const double>& tangents,
            std::size_t first)
      : values_(values), tangents_(tangents), first_(first) {}

  D next() {
    D x(values_.data()[column_]);
    for (std::size_t k = 0; k < directions && first_ + k < tangents_.shape(0); ++k)
      x.d[k] = tangents_.data()[(first_ + k) * tangents_.shape(1) + column_];
    ++column_;
    return x;
  }

  template <class P>
  P next_struct() {
    P parameters;
    P::visit(parameters, [&](const Field&, auto& member) {
      for_each_scalar(member, [&](auto& scalar) { scalar = next(); });
    });
    return parameters;
  }

 private:
  const Array1<const double>& values_;
  const Array2<const double>& tangents_;
  std::size_t first_;
  std::size_t column_{0};
};

/// The run, less its numbers.
struct Frame {
  std::vector<PushShapes> pushes;
  Timing timing;
  bool at_rest;  // the angles follow from the vehicles' positions; those of the row are not read
  bool ideal;
  std::uint64_t seed;
};

template <class Law>
planar::Outcome<D> run_along(const Frame& frame, SeededRow row) {
  const planar::Plant<D> plant(row.next_struct<planar::Parameters<D>>());
  const planar::Plant<D> assumed(row.next_struct<planar::Parameters<D>>());
  const auto gains = row.next_struct<typename Law::Gains>();
  const auto actuator_parameters = row.next_struct<planar::ActuatorParameters<D>>();
  const auto sensor_parameters = row.next_struct<planar::SensorParameters<D>>();
  Seven<D> q, q_dot;
  for (D& x : q) x = row.next();
  for (D& x : q_dot) x = row.next();
  if (frame.at_rest) {
    std::array<D, 3> theta;
    if (!rest_angles(plant, {Vec2<D>{q[0], q[1]}, Vec2<D>{q[2], q[3]}}, theta))
      throw std::invalid_argument("the start has no rest that can be differentiated");
    std::copy(theta.begin(), theta.end(), q.begin() + 4);
  }
  const planar::State<D> start = state_from_seven(plant, q, q_dot);
  planar::PerAxis<D> goal;
  for (Vec2<D>& g : goal) g = {row.next(), row.next()};
  const auto pushes = pushes_from(frame.pushes, [&] { return row.next(); });

  Law law(gains, assumed, goal, frame.timing.control_period());
  const auto ignore = [](const planar::Sample<D>&, bool) {};
  if (frame.ideal) {
    planar::IdealActuators<D> actuators(assumed, plant);
    planar::IdealSensors<D> sensors;
    return planar::rollout<true>(plant, start, goal, law, actuators, sensors, pushes, frame.timing,
                                 ignore)[0];
  }
  planar::TestbedActuators<D> actuators(actuator_parameters, assumed, plant, frame.timing.step);
  planar::TestbedSensors<D> sensors(sensor_parameters, frame.timing.control_steps,
                                    frame.timing.step, {frame.seed}, start, pose_of(plant, start));
  return planar::rollout<true>(plant, start, goal, law, actuators, sensors, pushes, frame.timing,
                               ignore)[0];
}

/// Every number of an outcome, in the order final state (10), metrics, audit.
std::vector<D> numbers_of(const planar::Outcome<D>& outcome) {
  const std::array<D, 10> state = outcome.state.flat();
  std::vector<D> numbers(state.begin(), state.end());
  const auto add = [&](const Field&, const D& x) { numbers.push_back(x); };
  outcome.metrics.visit(add);
  outcome.audit.visit(add);
  return numbers;
}

nb::dict gradient(const std::string& name, const Array1<const double>& values,
                  const Array2<const double>& tangents, const std::vector<PushTuple>& pushes,
                  bool at_rest, double step, long steps, long control_steps, bool ideal,
                  std::uint64_t seed) {
  const Frame frame{
      shapes_from(pushes), {step, steps, control_steps, steps + 1}, at_rest, ideal, seed};
  const std::size_t keys = tangents.shape(0);
  if (tangents.shape(1) != values.shape(0))
    throw std::invalid_argument("tangents have another number of columns than values");
  std::optional<planar::Outcome<D>> outcome;
  std::vector<double> primal, derivative;
  planar::for_each_law<D>([&]<class Law>() {
    if (name != Law::name) return;
    check_columns<typename Law::Gains>(values.shape(0) - 4, pushes.size());  // 14 for 10 start
    nb::gil_scoped_release unlock;
    for (std::size_t first = 0; first < keys || first == 0; first += directions) {
      outcome.emplace(run_along<Law>(frame, SeededRow(values, tangents, first)));
      const std::vector<D> numbers = numbers_of(*outcome);
      primal.resize(numbers.size());
      derivative.resize(numbers.size() * keys);
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        primal[i] = numbers[i].x;
        for (std::size_t k = 0; k < directions && first + k < keys; ++k)
          derivative[i * keys + first + k] = numbers[i].d[k];
      }
    }
  });
  if (!outcome) throw std::invalid_argument("no compiled law is called '" + name + "'");
  nb::dict d;
  d["status"] = multilift::name_of(outcome->status);
  d["culprit"] = outcome->culprit;
  d["end_time"] = outcome->end_time;
  d["values"] = primal;
  d["derivatives"] = derivative;
  return d;
}

}  // namespace

void bind_planar_gradient(nb::module_& m) {
  m.def("gradient", &gradient, nb::arg("law"), nb::arg("values"), nb::arg("tangents"),
        nb::arg("pushes"), nb::arg("at_rest"), nb::arg("step"), nb::arg("steps"),
        nb::arg("control_steps"), nb::arg("ideal"), nb::arg("seed"),
        "A run's final state (10), metrics and audit, and row by row their derivatives along each "
        "row of tangents. values: plant | assumed plant | gains | actuators | sensors | q (7) | "
        "q_dot (7) | goal (4) | pushes (6 each). Releases the GIL.");
}

}  // namespace multilift::bindings
