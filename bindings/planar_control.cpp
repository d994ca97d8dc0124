// The compiled control laws, by name, for scenarios and for stepping one at a time from Python.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/unique_ptr.h>

#include <chrono>
#include <memory>
#include <optional>

#include "arrays.hpp"

namespace multilift::bindings {

namespace {

using planar::Measurement;
using planar::Seven;

/// One compiled law behind a virtual step: for tests, references and people's own loops. Rollouts
/// do not go through it.
class SteppedLaw {
 public:
  virtual ~SteppedLaw() = default;
  virtual planar::Command<double> step(const Measurement<double>& measured) = 0;
  virtual std::array<Vec2<double>, 2> d_hat() const = 0;
};

template <class Law>
class SteppedLawOf final : public SteppedLaw {
 public:
  explicit SteppedLawOf(Law law) : law_(std::move(law)) {}
  planar::Command<double> step(const Measurement<double>& m) override { return law_.step(m); }
  std::array<Vec2<double>, 2> d_hat() const override { return law_.d_hat(); }

 private:
  Law law_;
};

std::unique_ptr<SteppedLaw> make_law(const std::string& name, const std::vector<double>& gains,
                                     const std::vector<double>& assumed, const Four& goal,
                                     double period) {
  std::unique_ptr<SteppedLaw> result;
  planar::for_each_law<double>([&]<class Law>() {
    if (name == Law::name)
      result = std::make_unique<SteppedLawOf<Law>>(
          Law(unpack_checked<typename Law::Gains>(gains, Law::name), plant_from(assumed),
              pair_from(goal), period));
  });
  if (!result) throw std::invalid_argument("no compiled law is called '" + name + "'");
  return result;
}

Four step(SteppedLaw& law, const Seven<double>& q, const Seven<double>& q_dot,
          std::pair<bool, bool> saturated) {
  Measurement<double> measured;
  measured.vehicle = pair_from({q[0], q[1], q[2], q[3]});
  measured.vehicle_velocity = pair_from({q_dot[0], q_dot[1], q_dot[2], q_dot[3]});
  measured.theta = {q[4], q[5], q[6]};
  measured.angle = sincos_each(measured.theta);
  measured.theta_dot = {q_dot[4], q_dot[5], q_dot[6]};
  measured.saturated = {saturated.first, saturated.second};
  return four_from(law.step(measured));
}

/// Mean time of one step of a law as rollouts step it, ns. All that the law is told depends on the
/// last command, as in a loop, so that steps cannot overlap and nothing is worked out once.
double law_nanoseconds(const std::string& name, const std::vector<double>& gains,
                       const std::vector<double>& assumed, const Four& goal, double period,
                       long repetitions) {
  double result = 0.0;
  planar::for_each_law<double>([&]<class Law>() {
    if (name != Law::name) return;
    Law law(unpack_checked<typename Law::Gains>(gains, Law::name), plant_from(assumed),
            pair_from(goal), period);
    Measurement<double> measured;
    measured.vehicle = pair_from(goal);
    measured.angle = sincos_each(measured.theta);
    const auto begin = std::chrono::steady_clock::now();
    for (long k = 0; k < repetitions; ++k) {
      const auto u = law.step(measured);
      for (std::size_t i = 0; i < 2; ++i) {
        measured.vehicle[i] += 1e-9 * u[i];
        measured.vehicle_velocity[i] += 1e-9 * u[i];
        measured.theta_dot[i] += 1e-9 * u[i].y;
        measured.angle[i].sin += 1e-12 * u[i].y;
        measured.angle[i].cos += 1e-12 * u[i].z;
      }
    }
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
    if (std::isfinite(measured.vehicle[0].y))  // keeps the loop
      result = spent.count() / static_cast<double>(repetitions);
  });
  return result;
}

/// Row k: derivatives of u_k along the seven coordinates and their rates.
std::array<std::array<double, 14>, 4> law_jacobian(
    const std::string& name, const std::vector<double>& gains, const std::vector<double>& assumed,
    const Four& goal, double period, const Seven<double>& q, const Seven<double>& q_dot) {
  using D = Dual<14>;
  std::optional<planar::Command<D>> u;
  planar::for_each_law<D>([&]<class Law>() {
    if (name != Law::name) return;
    if (gains.size() != count_scalars<typename Law::Gains>())
      throw std::invalid_argument(name + " takes another number of gains");
    plant_from(assumed);  // for its check
    Law law(unpack<typename Law::Gains>(gains.data()),
            planar::Plant<D>(unpack<planar::Parameters<D>>(assumed.data())),
            {Vec2<D>{goal[0], goal[1]}, Vec2<D>{goal[2], goal[3]}}, period);
    std::array<D, 14> v;
    for (int k = 0; k < 14; ++k) {
      const auto i = static_cast<std::size_t>(k);
      v[i] = D::variable(k < 7 ? q[i] : q_dot[i - 7], k);
    }
    Measurement<D> measured;
    measured.vehicle = {Vec2<D>{v[0], v[1]}, Vec2<D>{v[2], v[3]}};
    measured.theta = {v[4], v[5], v[6]};
    measured.angle = sincos_each(measured.theta);
    measured.vehicle_velocity = {Vec2<D>{v[7], v[8]}, Vec2<D>{v[9], v[10]}};
    measured.theta_dot = {v[11], v[12], v[13]};
    u = law.step(measured);
  });
  if (!u) throw std::invalid_argument("no compiled law is called '" + name + "'");
  return {(*u)[0].y.d, (*u)[0].z.d, (*u)[1].y.d, (*u)[1].z.d};
}

}  // namespace

void bind_planar_control(nb::module_& m) {
  m.def(
      "planar_laws",
      [] {
        nb::dict laws;
        planar::for_each_law<double>([&]<class Law>() {
          laws[Law::name] = nb::make_tuple(Law::title, field_table<typename Law::Gains>());
        });
        return laws;
      },
      "{name: (title, gain fields)} of every compiled planar law.");
  m.def("planar_law_nanoseconds", &law_nanoseconds, nb::arg("law"), nb::arg("gains"),
        nb::arg("assumed_plant"), nb::arg("goal"), nb::arg("period"), nb::arg("repetitions"),
        "Mean time of one step of a compiled law, ns, for benchmarks.");
  m.def("planar_law_jacobian", &law_jacobian, nb::arg("law"), nb::arg("gains"),
        nb::arg("assumed_plant"), nb::arg("goal"), nb::arg("period"), nb::arg("q"),
        nb::arg("q_dot"),
        "Row k: derivatives of u_k along the seven coordinates and their rates (dual numbers).");
  nb::class_<SteppedLaw>(m, "PlanarLaw", "A compiled planar control law, stepped by hand.")
      .def(nb::new_(&make_law), nb::arg("name"), nb::arg("gains"), nb::arg("assumed_plant"),
           nb::arg("goal"), nb::arg("period"))
      .def("step", &step, nb::arg("q"), nb::arg("q_dot"),
           nb::arg("saturated") = std::pair(false, false),
           "u1..u4, N, from measured coordinates and rates; advances the law by one period.")
      .def_prop_ro(
          "d_hat", [](const SteppedLaw& law) { return four_from(law.d_hat()); },
          "Drag estimates d_hat_y1, d_hat_z1, d_hat_y2, d_hat_z2, N s/m.");
}

}  // namespace multilift::bindings
