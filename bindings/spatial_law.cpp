// A spatial law stepped by whoever flies it.
#include <optional>

#include "cursor.hpp"
#include "multilift/control/spatial/flying_law.hpp"
#include "spatial_problem.hpp"

namespace multilift::bindings {

namespace {

class SpatialLaw {
 public:
  SpatialLaw(const Frame& frame, const FlatIn& row) : n_(frame.n), measured_(frame.n) {
    with_problem(frame, row, [&](auto& problem) {
      auto& setup = problem.setup;
      if (!problem.law)
        throw std::invalid_argument("no compiled law is called '" + frame.law + "'");
      auto hover = sp::hover_forces(setup.assumed, setup.formation);
      if constexpr (requires { setup.vehicles.parameters(); })
        scale_ = sp::thrust_scale(*problem.autopilot, setup.vehicles.parameters(), hover);
      else
        scale_ = {hover, std::vector<double>(n_), std::vector<double>(n_, 1.0),
                  std::vector<double>(n_)};
      for (std::size_t i = 0; i < n_; ++i) {
        const Vec3<double>& pull = setup.formation.cable_force[i];
        rest_direction_.push_back((1.0 / norm(pull)) * pull);
      }
      attachment_ = setup.assumed.attachment;
      law_.emplace(std::move(problem.law), setup.reference, setup.limits, n_);
    });
  }

  /// See Python's FlyingLaw.update.
  void step(double time, const FlatIn& told, const std::vector<bool>& saturated,
            const FlatOut& out) {
    check_length(told, 6 * n_ + 13, "what is measured");
    check_length(out, 8 * n_, "the answer");
    if (saturated.size() != n_) throw std::invalid_argument("saturated: one of each vehicle");
    Reader in(told);
    for (auto& v : measured_.vehicle) v = in.vector();
    for (auto& v : measured_.vehicle_velocity) v = in.vector();
    measured_.payload = {in.vector(), in.quaternion(), in.vector(), in.vector()};
    measured_.time = time;
    for (std::size_t i = 0; i < n_; ++i) measured_.saturated[i].is = saturated[i];
    law_->step(measured_);
    Writer answer(out.data());
    for (const auto& f : law_->force()) answer.put(f);
    for (const auto& f : law_->asked()) answer.put(f);
    for (std::size_t i = 0; i < n_; ++i) answer.put(swing(i));
    for (const auto& cut : law_->cut()) answer.put(cut.is ? 1.0 : 0.0);
  }

  /// The vehicles' targets and their velocities, the payload's with two derivatives, yaw, its rate.
  void target(double time, const FlatOut& out) const {
    check_length(out, 6 * n_ + 11, "the target");
    sp::Target<double> target(n_);
    law_->reference().at(time, target);
    Writer answer(out.data());
    for (const auto& v : target.vehicle) answer.put(v);
    for (const auto& v : target.vehicle_velocity) answer.put(v);
    answer.put(target.payload), answer.put(target.payload_velocity);
    answer.put(target.payload_acceleration);
    answer.put(target.yaw), answer.put(target.yaw_rate);
  }

  void follow(const Frame& frame, const FlatIn& row) {
    if (frame.n != n_) throw std::invalid_argument("a way for another number of vehicles");
    with_problem(frame, row, [&](auto& problem) { law_->follow(problem.setup.reference); });
  }

  /// Attitudes (4 each), then thrusts, for forces (3 each).
  void set_points(const FlatIn& force, double yaw, const FlatIn& hover_force,
                  const FlatIn& hover_thrust, const FlatOut& out) const {
    check_length(force, 3 * n_, "forces"), check_length(out, 5 * n_, "set-points");
    check_length(hover_force, n_, "hover_force"), check_length(hover_thrust, n_, "hover_thrust");
    sp::ThrustScale<double> scale = scale_;
    scale.hover_force.assign(hover_force.data(), hover_force.data() + n_);
    scale.hover_thrust.assign(hover_thrust.data(), hover_thrust.data() + n_);
    const SinCos<double> half_yaw = sincos(0.5 * yaw);
    Reader in(force);
    Writer attitudes(out.data()), thrusts(out.data() + 4 * n_);
    for (std::size_t i = 0; i < n_; ++i) {
      const auto point = sp::set_point(scale, i, in.vector(), half_yaw);
      attitudes.put(point.attitude), thrusts.put(point.thrust);
    }
  }

  std::vector<double> hover_force() const { return scale_.hover_force; }
  std::vector<std::array<double, 3>> drag_estimate() const {
    std::vector<std::array<double, 3>> estimate;
    for (const auto& d : law_->drag_estimate()) estimate.push_back({d.x, d.y, d.z});
    return estimate;
  }

 private:
  template <class F>
  static void with_problem(const Frame& frame, const FlatIn& row, F&& f) {
    with_kinds<double>(frame, [&]<class Vehicles, class Cables>() {
      auto problem =
          problem_from<double, Vehicles, Cables>(frame, {row.data(), row.shape(0), 1}, {0});
      f(problem);
    });
  }

  /// How far cable i, as measured, has turned from its direction at rest, rad.
  double swing(std::size_t i) const {
    const auto& payload = measured_.payload;
    const Vec3<double> tie = payload.position + rotation(payload.attitude).to_world(attachment_[i]);
    const Vec3<double> along = measured_.vehicle[i] - tie;
    const Vec3<double> off = (1.0 / std::fmax(norm(along), 1e-9)) * along -
                             sp::turned(law_->target().heading, rest_direction_[i]);
    return 2.0 * sp::arcsine(std::fmin(0.5 * norm(off), 1.0));
  }

  std::size_t n_;
  sp::Measurement<double> measured_;
  std::optional<sp::FlyingLaw<double>> law_;
  sp::ThrustScale<double> scale_;
  std::vector<Vec3<double>> rest_direction_, attachment_;
};

}  // namespace

void bind_spatial_law(nb::module_& m) {
  nb::class_<SpatialLaw>(m, "SpatialLaw", "A compiled spatial law, stepped by whoever flies it.")
      .def(nb::init<const Frame&, const FlatIn&>(), nb::arg("frame"), nb::arg("row"))
      .def("step", &SpatialLaw::step, nb::arg("time"), nb::arg("told"), nb::arg("saturated"),
           nb::arg("out"),
           "One control period. told: vehicles (3n) | velocities (3n) | payload (13). out: forces "
           "(3n) | before limits (3n) | swing (n) | whether cut (n).")
      .def("target", &SpatialLaw::target, nb::arg("time"), nb::arg("out"),
           "out: vehicles (3n) | velocities (3n) | payload, velocity, acceleration (9) | yaw, its "
           "rate.")
      .def("follow", &SpatialLaw::follow, nb::arg("frame"), nb::arg("row"),
           "Flies to the targets of another row.")
      .def("set_points", &SpatialLaw::set_points, nb::arg("force"), nb::arg("yaw"),
           nb::arg("hover_force"), nb::arg("hover_thrust"), nb::arg("out"),
           "out: attitudes (4n) | normalised thrusts (n).")
      .def_prop_ro("hover_force", &SpatialLaw::hover_force,
                   "Weight of each vehicle and its share of the load, N.")
      .def_prop_ro("drag_estimate", &SpatialLaw::drag_estimate, "N s/m, of each vehicle.");
}

}  // namespace multilift::bindings
