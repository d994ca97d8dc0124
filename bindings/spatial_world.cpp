// A spatial world stepped from outside.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/unique_ptr.h>

#include <memory>

#include "cursor.hpp"
#include "multilift/model/spatial/energy.hpp"
#include "multilift/sim/spatial/stepped_world.hpp"
#include "spatial_problem.hpp"

namespace multilift::bindings {

namespace {

using Flags = nb::ndarray<bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Incident = std::tuple<double, std::string, int>;

/// A world whatever its vehicles and cables.
class SpatialWorld {
 public:
  virtual ~SpatialWorld() = default;
  virtual void step_forces(const FlatIn& force, std::optional<double> yaw, long steps) = 0;
  virtual void step_set_points(const FlatIn& wanted, long steps) = 0;
  virtual void step_motors(const FlatIn& part, long steps) = 0;
  virtual void fail(const std::string& what, std::size_t vehicle, std::size_t rotor) = 0;
  virtual void show(const FlatOut& numbers, const Flags& flags) const = 0;
  virtual std::string status() const = 0;
  virtual std::vector<Incident> incidents(std::size_t first) const = 0;
};

template <class Vehicles, class Cables>
class SpatialWorldOf final : public SpatialWorld {
 public:
  using World = sp::SteppedWorld<Vehicles, Cables>;

  SpatialWorldOf(const typename World::W::S& setup, typename World::Drive drive)
      : world_(setup, std::move(drive)), n_(setup.start.size()) {}

  void step_forces(const FlatIn& force, std::optional<double> yaw, long steps) override {
    check_length(force, 3 * n_, "forces");
    Reader in(force);
    std::vector<Vec3<double>> forces;
    for (std::size_t i = 0; i < n_; ++i) forces.push_back(in.vector());
    world_.step_forces(forces, yaw, steps);
  }

  void step_set_points(const FlatIn& wanted, long steps) override {
    check_length(wanted, 5 * n_, "set-points");
    Reader in(wanted);
    std::vector<sp::AttitudeThrust<double>> points;
    for (std::size_t i = 0; i < n_; ++i) points.push_back({in.quaternion(), in.number()});
    if constexpr (World::turning)
      world_.step_set_points(points, steps);
    else
      refuse();
  }

  void step_motors(const FlatIn& part, long steps) override {
    check_length(part, sp::rotors * n_, "motor commands");
    Reader in(part);
    std::vector<std::array<double, sp::rotors>> parts(n_);
    for (auto& motors : parts)
      for (double& motor : motors) motor = in.number();
    if constexpr (World::turning)
      world_.step_motors(parts, steps);
    else
      refuse();
  }

  void fail(const std::string& what, std::size_t vehicle, std::size_t rotor) override {
    if (vehicle >= n_ || rotor >= sp::rotors) throw std::invalid_argument("no such vehicle");
    world_.fail(failure_from(what), vehicle, rotor);
  }

  /// In the order of Python's models/spatial/world.py.
  void show(const FlatOut& numbers, const Flags& flags) const override {
    check_length(numbers, 39 + 34 * n_, "the world's numbers");
    check_length(flags, 3 * n_, "the world's flags");
    const auto& x = world_.world().x();
    const auto& now = world_.now();
    const auto& plant = world_.world().setup().plant;
    const auto& told = world_.measured();
    const auto& events = world_.world().stepper().events();
    const auto clearance = world_.clearance();
    Writer out(numbers.data());
    const auto each = [&](auto&& of) {
      for (std::size_t i = 0; i < n_; ++i) out.put(of(i));
    };
    const auto body = [&](const sp::RigidBody<double>& b) {
      out.put(b.position), out.put(b.attitude), out.put(b.velocity), out.put(b.rate);
    };
    out.put(world_.time());
    body(x.payload);
    out.put(now.payload_contact);
    each([&](std::size_t i) { return x.vehicle[i].position; });
    each([&](std::size_t i) { return x.vehicle[i].velocity; });
    if constexpr (World::turning) {
      each([&](std::size_t i) { return x.vehicle[i].attitude; });
      each([&](std::size_t i) { return x.vehicle[i].rate; });
    } else {
      each([](std::size_t) { return Quaternion<double>{1.0, 0.0, 0.0, 0.0}; });
      each([](std::size_t) { return Vec3<double>{}; });
    }
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t r = 0; r < sp::rotors; ++r) {
        if constexpr (World::turning)
          out.put(x.vehicle[i].rotor_speed[r]);
        else
          out.put(0.0);
      }
    each([&](std::size_t i) { return world_.specific_force(i); });
    each([&](std::size_t i) { return now.thrust[i]; });
    each([&](std::size_t i) { return now.contact[i]; });
    each([&](std::size_t i) { return now.motion.tension[i]; });
    each([&](std::size_t i) { return now.cable[i].length; });
    out.put(world_.world().outside().wind);
    out.put(sp::mechanical_energy(plant, x));
    out.put(events.impacts), out.put(events.energy_lost), out.put(events.hardest_impulse);
    out.put(clearance.vehicles), out.put(clearance.cables);
    each([&](std::size_t i) { return told.vehicle[i]; });
    each([&](std::size_t i) { return told.vehicle_velocity[i]; });
    body(told.payload);
    for (std::size_t i = 0; i < n_; ++i) {
      flags.data()[i] = now.motion.tension[i] > 0.0;
      flags.data()[n_ + i] = now.contact[i].z > 0.0;
      flags.data()[2 * n_ + i] = world_.saturated(i);
    }
  }

  std::string status() const override {
    return world_.running() ? "running" : multilift::name_of(*world_.ended());
  }

  std::vector<Incident> incidents(std::size_t first) const override {
    std::vector<Incident> told;
    const auto& all = world_.incidents();
    for (std::size_t k = first; k < all.size(); ++k)
      told.emplace_back(all[k].time, all[k].what, all[k].vehicle);
    return told;
  }

 private:
  [[noreturn]] static void refuse() {
    throw std::invalid_argument("ideal vehicles take forces only");
  }

  World world_;
  std::size_t n_;
};

std::unique_ptr<SpatialWorld> make_world(const Frame& frame, const FlatIn& row,
                                         std::uint64_t seed) {
  std::unique_ptr<SpatialWorld> world;
  with_kinds<double>(frame, [&]<class Vehicles, class Cables>() {
    auto problem =
        problem_from<double, Vehicles, Cables>(frame, {row.data(), row.shape(0), 1}, {seed});
    with_actuation(frame, problem, [&](auto actuation) {
      world =
          std::make_unique<SpatialWorldOf<Vehicles, Cables>>(problem.setup, std::move(actuation));
    });
  });
  return world;
}

}  // namespace

void bind_spatial_world(nb::module_& m) {
  nb::class_<SpatialWorld>(m, "SpatialWorld", "A spatial world, stepped from outside.")
      .def("step_forces", &SpatialWorld::step_forces, nb::arg("force"), nb::arg("yaw").none(),
           nb::arg("steps"), "Forces (3n), N, held for integration steps.")
      .def("step_set_points", &SpatialWorld::step_set_points, nb::arg("wanted"), nb::arg("steps"),
           "Of each vehicle an attitude (4) and a thrust.")
      .def("step_motors", &SpatialWorld::step_motors, nb::arg("part"), nb::arg("steps"),
           "Of each vehicle four parts of the greatest rotor speed.")
      .def("fail", &SpatialWorld::fail, nb::arg("what"), nb::arg("vehicle"), nb::arg("rotor"),
           "Something breaks.")
      .def("show", &SpatialWorld::show, nb::arg("numbers"), nb::arg("flags"),
           "Fills the arrays with the present state.")
      .def("incidents", &SpatialWorld::incidents, nb::arg("first"),
           "Time, what and whose, from the given one on.")
      .def_prop_ro("status", &SpatialWorld::status);
  m.def("spatial_world", &make_world, nb::arg("frame"), nb::arg("row"), nb::arg("seed"),
        "A world at its start.");
}

}  // namespace multilift::bindings
