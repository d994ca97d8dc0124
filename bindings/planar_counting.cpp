// How many operations a step of a rollout is made of, found by running it over counting scalars.
#include "multilift/scalar/counting.hpp"
#include "planar_rows.hpp"

namespace multilift::bindings {

namespace {

/// Operations of a whole run with ideal actuators and sensors; `row` as for batches, no pushes.
nb::dict operations(const std::string& law_name, const std::vector<double>& row, double step,
                    long steps, long control_steps) {
  using R = Counting;
  const Timing timing{step, steps, control_steps, steps};
  nb::dict counted;
  planar::for_each_law<R>([&]<class Law>() {
    if (law_name != Law::name) return;
    check_columns<typename Law::Gains>(row.size(), 0);
    const Rows rows{row.data(), row.size()};
    std::size_t column = 0;
    const planar::Plant<R> plant(unpack<planar::Parameters<R>>(rows, column));
    const planar::Plant<R> assumed(unpack<planar::Parameters<R>>(rows, column));
    const auto gains = unpack<typename Law::Gains>(rows, column);
    unpack<planar::ActuatorParameters<R>>(rows, column);
    unpack<planar::SensorParameters<R>>(rows, column);
    const auto next = [&] { return rows.at<R>(column++); };
    const planar::State<R> start = start_from(next);
    planar::PerAxis<R> goal;
    for (Vec2<R>& g : goal) g = {next(), next()};
    Law law(gains, assumed, goal, timing.control_period());
    planar::IdealActuators<R> actuators(assumed, plant);
    planar::IdealSensors<R> sensors;
    const Operations before = Counting::operations();
    planar::rollout<true>(plant, start, goal, law, actuators, sensors, {}, timing,
                          [](const planar::Sample<R>&, bool) {});
    const Operations found = Counting::operations() - before;
    counted["add"] = found.add;
    counted["multiply"] = found.multiply;
    counted["divide"] = found.divide;
    counted["root"] = found.root;
    counted["other"] = found.other;
  });
  if (counted.empty()) throw std::invalid_argument("no compiled law is called '" + law_name + "'");
  return counted;
}

}  // namespace

void bind_planar_counting(nb::module_& m) {
  m.def("planar_operations", &operations, nb::arg("law"), nb::arg("row"), nb::arg("step"),
        nb::arg("steps"), nb::arg("control_steps"),
        "Operations of one run, by kind: add, multiply, divide, root, and other ones on numbers.");
}

}  // namespace multilift::bindings
