// A whole spatial run in one call: flat numbers in, a table of samples, metrics and audit out; and
// the tables of what there is.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/unique_ptr.h>

#include "cursor.hpp"
#include "multilift/sim/spatial/recorded.hpp"
#include "spatial_problem.hpp"

namespace multilift::bindings {

namespace {

using Row = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

template <class T>
nb::ndarray<nb::numpy, double> vectors(const std::vector<T>& x) {
  auto* copy = new std::vector<double>();
  for (const T& v : x) copy->insert(copy->end(), {v.x, v.y, v.z});
  nb::capsule owner(copy, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return nb::ndarray<nb::numpy, double>(copy->data(), {x.size(), 3}, owner);
}

std::array<double, 13> flat(const sp::RigidBody<double>& b) {
  return {b.position.x, b.position.y, b.position.z, b.attitude.w, b.attitude.x,
          b.attitude.y, b.attitude.z, b.velocity.x, b.velocity.y, b.velocity.z,
          b.rate.x,     b.rate.y,     b.rate.z};
}

/// A law written in Python: called with time, vehicles' positions and velocities, the payload's 13
/// numbers, the vehicles' targets and their velocities, the payload's target, and which commands
/// hit limits; it answers the forces, shape (n, 3).
class CallbackLaw : public sp::Law<double> {
 public:
  CallbackLaw(nb::callable law, std::size_t n) : sp::Law<double>(n), law_(std::move(law)) {}

  void step(const sp::Measurement<double>& m, const sp::Target<double>& target,
            std::vector<Vec3<double>>& force) override {
    nb::gil_scoped_acquire gil;
    std::vector<bool> saturated;
    for (const auto& mask : m.saturated) saturated.push_back(mask.is);
    const std::array<double, 11> payload{target.payload.x,
                                         target.payload.y,
                                         target.payload.z,
                                         target.payload_velocity.x,
                                         target.payload_velocity.y,
                                         target.payload_velocity.z,
                                         target.payload_acceleration.x,
                                         target.payload_acceleration.y,
                                         target.payload_acceleration.z,
                                         target.yaw,
                                         target.yaw_rate};
    const nb::object answer =
        law_(m.time, vectors(m.vehicle), vectors(m.vehicle_velocity), flat(m.payload),
             vectors(target.vehicle), vectors(target.vehicle_velocity), payload, saturated);
    const auto f = nb::cast<std::vector<std::array<double, 3>>>(answer);
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = {f.at(i)[0], f[i][1], f[i][2]};
  }

 private:
  nb::callable law_;
};

nb::dict run(const Frame& frame, const Row& row, std::uint64_t seed, const nb::object& callback) {
  auto* numbers = new std::vector<double>();
  nb::capsule owner(numbers, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  std::size_t columns = 0;
  nb::dict d;
  with_kinds<double>(frame, [&]<class Vehicles, class Cables>() {
    const Rows rows{row.data(), row.shape(0), 1};
    auto problem = problem_from<double, Vehicles, Cables>(frame, rows, {seed});
    std::unique_ptr<sp::Law<double>> own;
    if (!callback.is_none())
      own = std::make_unique<CallbackLaw>(nb::cast<nb::callable>(callback), frame.n);
    sp::Law<double>* law = own ? own.get() : problem.law.get();
    if (law == nullptr)
      throw std::invalid_argument("no compiled law is called '" + frame.law + "'");
    std::vector<std::pair<const char*, double>> metrics, audit;
    Status status{};
    double end_time = 0.0;
    {
      nb::gil_scoped_release unlock;
      run_problem(
          frame, problem, *law,
          [&](const auto& sample, bool) {
            const std::size_t before = numbers->size();
            sp::visit_columns(sample, [&](const std::string&, const char*, const std::string&,
                                          double x) { numbers->push_back(x); });
            columns = numbers->size() - before;
          },
          [&](int k, Status how, double time, const auto&, const auto& m, const auto& a) {
            status = how;
            end_time = time;
            m.report(k, [&](const Field& f, double x) { metrics.emplace_back(f.name, x); });
            a.visit([&](const Field& f, double x) { audit.emplace_back(f.name, x); });
          });
    }
    nb::dict metric_dict, audit_dict;
    for (const auto& [name, x] : metrics) metric_dict[name] = x;
    for (const auto& [name, x] : audit) audit_dict[name] = x;
    d["status"] = multilift::name_of(status);
    d["end_time"] = end_time;
    d["metrics"] = metric_dict;
    d["audit"] = audit_dict;
  });
  d["samples"] = nb::ndarray<nb::numpy, double, nb::ndim<2>>(
      numbers->data(), {numbers->size() / columns, columns}, owner);
  return d;
}

/// A measured flight, told as a run: each row holds time | the reference's time | payload (13) | of
/// each vehicle position, attitude, velocity, rate, rotor speeds (17) | forces commanded (3n) |
/// drag estimates (3n).
nb::dict recorded(const Frame& frame, const Row& row, const Table& flown, bool complete) {
  const std::size_t n = frame.n, width = 15 + 23 * n;
  if (!frame.quadrotors) throw std::invalid_argument("only quadrotors fly");
  if (flown.shape(0) == 0 || flown.shape(1) != width)
    throw std::invalid_argument("a flight's rows take " + std::to_string(width) + " numbers");
  auto* numbers = new std::vector<double>();
  nb::capsule owner(numbers, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  auto problem = problem_from<double, sp::Quadrotors<double>, sp::RigidCables<double>>(
      frame, Rows{row.data(), row.shape(0), 1}, {0});
  if (!problem.law) throw std::invalid_argument("no compiled law is called '" + frame.law + "'");
  const auto& setup = problem.setup;
  sp::Recorded<double> told(setup.plant, setup.vehicles, setup.formation, setup.reference,
                            problem.law->storage_gains());
  sp::State<double, sp::Craft<double>> x(n);
  std::vector<Vec3<double>> commanded(n), d_hat(n);
  for (std::size_t k = 0; k < flown.shape(0); ++k) {
    Reader in(flown.data() + k * width);
    const double time = in.number(), planned = in.number();
    x.payload.position = in.vector(), x.payload.attitude = in.quaternion();
    x.payload.velocity = in.vector(), x.payload.rate = in.vector();
    for (auto& craft : x.vehicle) {
      craft.position = in.vector(), craft.attitude = in.quaternion();
      craft.velocity = in.vector(), craft.rate = in.vector();
      for (double& speed : craft.rotor_speed) speed = in.number();
    }
    for (auto& force : commanded) force = in.vector();
    for (auto& d : d_hat) d = in.vector();
    told.add(time, planned, x, commanded, d_hat, [&](const auto& sample) {
      sp::visit_columns(sample, [&](const std::string&, const char*, const std::string&,
                                    double number) { numbers->push_back(number); });
    });
  }
  told.finish(complete);
  nb::dict d, metrics, audit;
  told.metrics().report(0, [&](const Field& f, double number) { metrics[f.name] = number; });
  told.audit().visit([&](const Field& f, double number) { audit[f.name] = number; });
  d["metrics"] = metrics;
  d["audit"] = audit;
  d["samples"] = nb::ndarray<nb::numpy, double, nb::ndim<2>>(
      numbers->data(), {flown.shape(0), numbers->size() / flown.shape(0)}, owner);
  return d;
}

/// Tables of names, units, ranges, shapes, defaults and meanings.
nb::dict fields() {
  nb::dict d;
  d["plant"] = field_table<sp::Parameters<double>>();
  d["quadrotor"] = field_table<sp::Quadrotors<double>::Parameters>();
  d["autopilot"] = field_table<sp::AutopilotParameters<double>>();
  d["ground"] = field_table<sp::Ground<double>>();
  d["formation"] = field_table<sp::Formation<double>>();
  d["link"] = field_table<sp::LinkParameters<double>>();
  d["limits"] = field_table<sp::LimitParameters<double>>();
  d["motion_capture"] = field_table<sp::MotionCaptureParameters<double>>();
  d["wind"] = field_table<sp::WindParameters<double>>();
  d["safety"] = field_table<sp::SafetyParameters<double>>();
  return d;
}

nb::dict laws() {
  nb::dict d;
  sp::for_each_law<double>(
      [&]<class L>() { d[L::name] = nb::make_tuple(L::title, field_table<typename L::Gains>()); });
  return d;
}

template <class V>
nb::list columns_of(std::size_t n) {
  nb::list table;
  const sp::Parameters<double> p(n);
  const sp::Plant<double> plant(p);
  const sp::State<double, V> x(n);
  const sp::Instant<double> now(n);
  const sp::Target<double> target(n);
  const Masks<double> taut(n);
  const std::vector<Vec3<double>> zero(n);
  const sp::Sample<double, V> sample{0.0, plant, x, now, target, taut, zero, zero, 0.0};
  sp::visit_columns(sample, [&](const std::string& name, const char* unit, const std::string& doc,
                                double) { table.append(nb::make_tuple(name, unit, doc)); });
  return table;
}

/// Columns, metrics and audit entries of runs with n vehicles: (name, unit, meaning) each.
nb::dict describe(std::size_t n, bool quadrotors) {
  nb::dict d;
  d["columns"] =
      quadrotors ? columns_of<sp::Craft<double>>(n) : columns_of<sp::PointMass<double>>(n);
  nb::list metrics, audit;
  sp::Metrics<double>().report(
      0, [&](const Field& f, double) { metrics.append(nb::make_tuple(f.name, f.unit, f.doc)); });
  const sp::Plant<double> plant{sp::Parameters<double>(n)};
  sp::Audit<double, sp::PointMass<double>>(plant, sp::StorageGains<double>(n))
      .visit([&](const Field& f, double) { audit.append(nb::make_tuple(f.name, f.unit, f.doc)); });
  d["metrics"] = metrics;
  d["audit"] = audit;
  return d;
}

}  // namespace

void bind_spatial_rollout(nb::module_& m) {
  bind_frame(m);
  m.def("spatial_run", &run, nb::arg("frame"), nb::arg("row"), nb::arg("seed"),
        nb::arg("law").none() = nb::none(),
        "One run: samples, metrics, audit, status, end time. `law` is a Python callable in place "
        "of the compiled one.");
  m.def("spatial_recorded", &recorded, nb::arg("frame"), nb::arg("row"), nb::arg("flown"),
        nb::arg("complete"), "A measured flight told as a run: samples, metrics, audit.");
  m.def("spatial_fields", &fields,
        "Tables of fields: (name, unit, range, shape, defaults, meaning) each; \"n\" in a shape is "
        "the number of vehicles.");
  m.def("spatial_laws", &laws, "Of each compiled law its title and the table of its gains.");
  m.def("spatial_describe", &describe, nb::arg("n"), nb::arg("quadrotors"),
        "Columns, metrics and audit entries: (name, unit, meaning) each.");
}

}  // namespace multilift::bindings
