// How the spatial plant and its law answer to small departures from rest at the goal: exact
// derivatives, by dual numbers.
#include "cursor.hpp"
#include "multilift/scalar/dual.hpp"
#include "spatial_problem.hpp"

namespace multilift::bindings {

namespace {

constexpr int directions = 2;
using D = Dual<directions>;
using Rows = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// A row of plain numbers read as dual ones without derivatives.
struct PlainRow {
  const double* values;
  std::size_t stride;

  template <Real R>
  R at(std::size_t column) const {
    return R(values[column]);
  }
};

/// Departures from rest, in the order of `numbers`: of the payload's position (W), attitude (turned
/// about its own axes), velocity and rate, of the vehicles' positions and velocities, and of the
/// rotors' forces.
std::size_t departures(std::size_t n) { return 12 + 9 * n; }

/// Writes for each departure the change of the payload's acceleration and angular acceleration, of
/// the vehicles' accelerations, and of the law's forces.
template <class Vehicles, class Cables>
void differentiate(const Frame& frame, const FlatIn& row, const Rows& out) {
  const std::size_t n = frame.n;
  for (std::size_t first = 0; first < departures(n); first += directions) {
    auto problem =
        problem_from<D, Vehicles, Cables>(frame, PlainRow{row.data(), row.shape(0)}, {0});
    if (!problem.law) throw std::invalid_argument("no compiled law is called '" + frame.law + "'");
    const auto& setup = problem.setup;
    sp::Target<D> target(n);
    setup.reference.at(setup.reference.stands() ? 0.0 : frame.path.end, target);

    std::size_t at = 0;
    const auto depart = [&](D& x) {
      for (std::size_t k = 0; k < directions; ++k) x.d[k] += at == first + k ? 1.0 : 0.0;
      ++at;
    };
    using Points = sp::IdealVehicles<D>;
    sp::State<D, sp::PointMass<D>> x(n);
    std::vector<Vec3<D>> force(n);
    Vec3<D> turned{};
    const SinCos<D> half = sincos(D(0.5) * target.yaw);
    x.payload.position = target.payload;
    sp::zip(depart, x.payload.position);
    sp::zip(depart, turned);
    x.payload.attitude =
        Quaternion<D>{half.cos, D(0.0), D(0.0), half.sin} *
        Quaternion<D>{D(1.0), D(0.5) * turned.x, D(0.5) * turned.y, D(0.5) * turned.z};
    sp::zip(depart, x.payload.velocity);
    sp::zip(depart, x.payload.rate);
    for (std::size_t i = 0; i < n; ++i) {
      x.vehicle[i].position = target.vehicle[i];
      sp::zip(depart, x.vehicle[i].position);
    }
    for (std::size_t i = 0; i < n; ++i) sp::zip(depart, x.vehicle[i].velocity);
    for (std::size_t i = 0; i < n; ++i) {
      force[i] = target.cable_force[i];
      force[i].z += setup.plant.vehicle_mass[i] * setup.plant.gravity;
      sp::zip(depart, force[i]);
    }

    const sp::Dynamics<D, Points, Cables> dynamics(setup.plant, Points(Points::Parameters(n)), {});
    sp::Instant<D> now(n);
    sp::Surroundings<D> outside(n);
    Masks<D> taut(n);
    for (auto& each : taut) each.is = true;
    dynamics.evaluate(x, force, outside, taut, now);
    sp::State<D, sp::PointMass<D>> rate(n);
    dynamics.rate(x, force, now, rate);

    sp::Measurement<D> measured(n);
    for (std::size_t i = 0; i < n; ++i) {
      measured.vehicle[i] = x.vehicle[i].position;
      measured.vehicle_velocity[i] = x.vehicle[i].velocity;
    }
    measured.payload = x.payload;
    std::vector<Vec3<D>> answer(n);
    problem.law->step(measured, target, answer);

    std::size_t column = 0;
    const auto put = [&](const D& number) {
      for (std::size_t k = 0; k < directions && first + k < departures(n); ++k)
        out.data()[(first + k) * out.shape(1) + column] = number.d[k];
      ++column;
    };
    sp::zip(put, rate.payload.velocity);
    sp::zip(put, rate.payload.rate);
    for (auto& vehicle : rate.vehicle) sp::zip(put, vehicle.velocity);
    for (auto& each : answer) sp::zip(put, each);
  }
}

void linearise(const Frame& frame, const FlatIn& row, const Rows& out) {
  if (out.shape(0) != departures(frame.n) || out.shape(1) != 6 + 6 * frame.n)
    throw std::invalid_argument("the derivatives take (12 + 9n) rows of (6 + 6n) numbers");
  with_kinds<D>(frame, [&]<class Vehicles, class Cables>() {
    differentiate<Vehicles, Cables>(frame, row, out);
  });
}

}  // namespace

void bind_spatial_linear(nb::module_& m) {
  m.def("spatial_linearise", &linearise, nb::arg("frame"), nb::arg("row"), nb::arg("out"),
        "Derivatives at rest at the goal. Row by row along payload's position, attitude (its own "
        "axes), velocity, rate (3 each), vehicles' positions (3n), velocities (3n), rotors' forces "
        "(3n): of payload's acceleration, angular acceleration, vehicles' accelerations (3n), the "
        "law's forces (3n).");
}

}  // namespace multilift::bindings
