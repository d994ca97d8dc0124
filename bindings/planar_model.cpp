// The planar plant: parameters, both formulations, energies, linearisation.
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include "arrays.hpp"

namespace multilift::bindings {

namespace {

using planar::join_seven;
using planar::Pose;
using planar::Seven;
using planar::State;
using planar::StorageGains;
using Values = std::vector<double>;

StorageGains<double> gains_from(double k_lambda, const Four& k_p, const Four& k_d,
                                const Four& gamma) {
  StorageGains<double> gains{k_lambda, pair_from(k_p), pair_from(k_d), {}};
  for (std::size_t i = 0; i < 2; ++i)
    gains.inverse_gamma[i] = {1.0 / gamma[2 * i], 1.0 / gamma[2 * i + 1]};
  return gains;
}

nb::dict fast_motion(const Values& values, const Seven<double>& q, const Seven<double>& q_dot,
                     const ElevenLoads& loads) {
  const auto plant = plant_from(values);
  const State<double> state = state_from_seven(plant, q, q_dot);
  const Pose<double> pose = pose_of(plant, state);
  const auto result = motion(plant, state, pose, loads_from(loads));
  nb::dict d;
  d["bar_acceleration"] =
      std::array<double, 2>{result.bar_acceleration.y, result.bar_acceleration.z};
  d["theta_ddot"] = result.theta_ddot;
  d["tension"] = result.tension;
  d["cable_force"] = four_from(result.cable_force);
  // Accelerations of the vehicles, by the kinematics of the state's coordinates.
  std::array<Vec2<double>, 2> acceleration;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto &direction = pose.direction[i], &tangent = pose.tangent[i], &arm = pose.arm[i];
    const double w = state.theta_dot[i], w3 = state.theta_dot[2];
    acceleration[i] =
        result.bar_acceleration + result.theta_ddot[2] * perpendicular(arm) - (w3 * w3) * arm -
        plant.cable_length[i] * (result.theta_ddot[i] * tangent + (w * w) * direction);
  }
  d["q_ddot"] = join_seven(acceleration, result.theta_ddot);
  return d;
}

nb::dict redundant(const Values& values, const Seven<double>& q, const Seven<double>& q_dot,
                   const ElevenLoads& loads) {
  const auto plant = plant_from(values);
  const auto result = redundant_motion(plant, q, q_dot, loads_from(loads));
  nb::dict d;
  d["q_ddot"] = result.q_ddot;
  d["mu"] = std::array<double, 2>{result.mu.y, result.mu.z};
  d["tension"] = result.tension;
  d["regular"] = result.regular;
  return d;
}

nb::dict energies(const Values& values, double k_lambda, const Four& k_p, const Four& k_d,
                  const Four& gamma, const Four& goal, const Four& d_hat, const Seven<double>& q,
                  const Seven<double>& q_dot, const ElevenLoads& loads) {
  const auto plant = plant_from(values);
  const auto gains = gains_from(k_lambda, k_p, k_d, gamma);
  const State<double> state = state_from_seven(plant, q, q_dot);
  const Pose<double> pose = pose_of(plant, state);
  const auto given = loads_from(loads);
  const auto now = motion(plant, state, pose, given);
  const planar::Storage<double> storage(plant, gains, pair_from(goal));
  const auto formation = storage.formation(plant, state, pose, nullptr);
  auto powers =
      storage.powers(plant, state, pose, formation, given, now, pair_from(d_hat), nullptr);
  nb::dict d;
  d["mechanical"] = mechanical_energy(plant, state, pose, formation.swing);
  d["shaped"] = shaped_energy(plant, k_lambda, state, pose, formation.swing);
  d["storage"] = storage.motion_energy(plant, state, pose, formation) +
                 storage.estimation_energy(plant, pair_from(d_hat));
  planar::Powers<double>::visit(powers,
                                [&](const Field& field, double power) { d[field.name] = power; });
  return d;
}

/// Row k: derivatives of the rate of free coordinate k along the 10 coordinates and u1..u4.
std::array<std::array<double, 14>, 10> jacobian(const Values& values,
                                                const std::array<double, 10>& x, const Four& u) {
  using D = Dual<14>;
  plant_from(values);  // for its check
  const planar::Plant<D> plant(unpack<planar::Parameters<D>>(values.data()));
  std::array<D, 14> v;
  for (int k = 0; k < 14; ++k) {
    const auto i = static_cast<std::size_t>(k);
    v[i] = D::variable(k < 10 ? x[i] : u[i - 10], k);
  }
  const State<D> state{{v[0], v[1]}, {v[2], v[3], v[4]}, {v[5], v[6]}, {v[7], v[8], v[9]}};
  planar::Loads<D> loads;
  loads.u = {Vec2<D>{v[10], v[11]}, Vec2<D>{v[12], v[13]}};
  const auto rate = motion(plant, state, pose_of(plant, state), loads).rate(state);
  return {rate.bar_velocity.y.d,     rate.bar_velocity.z.d, rate.theta_dot[0].d,
          rate.theta_dot[1].d,       rate.theta_dot[2].d,   rate.bar_acceleration.y.d,
          rate.bar_acceleration.z.d, rate.theta_ddot[0].d,  rate.theta_ddot[1].d,
          rate.theta_ddot[2].d};
}

template <class T>
using Table = nb::ndarray<T, nb::numpy, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// Row by row, for many starts: the ten free coordinates, then by how much the start misses the
/// closure, m, and its rate, m/s; all NaN where the load was to hang at rest and cannot.
Table<double> starts(const Table<const double>& plants, const Table<const double>& vehicles,
                     const Table<const double>& angles, const Table<const double>& velocities,
                     const Table<const double>& angle_rates) {
  const std::size_t n = plants.shape(0);
  auto* free = new double[n * 12];
  nb::capsule owner(free, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  for (std::size_t k = 0; k < n; ++k) {
    const planar::Plant<double> plant(
        unpack<planar::Parameters<double>>(plants.data() + k * plants.shape(1)));
    const double* v = vehicles.data() + 4 * k;
    const double* w = velocities.data() + 4 * k;
    std::array<double, 3> angle{angles(k, 0), angles(k, 1), angles(k, 2)};
    double* row = free + 12 * k;
    if (std::isnan(angle[0]) && !rest_angles(plant, pair_from({v[0], v[1], v[2], v[3]}), angle)) {
      std::fill(row, row + 12, std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const Seven<double> q{v[0], v[1], v[2], v[3], angle[0], angle[1], angle[2]};
    const Seven<double> q_dot{
        w[0], w[1], w[2], w[3], angle_rates(k, 0), angle_rates(k, 1), angle_rates(k, 2)};
    // Along q_dot by dual numbers: the gap and its rate in one evaluation.
    Seven<Dual<1>> moving;
    for (std::size_t i = 0; i < 7; ++i) {
      moving[i] = Dual<1>(q[i]);
      moving[i].d[0] = q_dot[i];
    }
    const planar::Plant<Dual<1>> dual_plant(
        unpack<planar::Parameters<Dual<1>>>(plants.data() + k * plants.shape(1)));
    const auto gap = closure(dual_plant, moving);
    const std::array<double, 10> state = state_from_seven(plant, q, q_dot).flat();
    std::copy(state.begin(), state.end(), row);
    row[10] = std::max(std::fabs(gap.y.x), std::fabs(gap.z.x));
    row[11] = std::max(std::fabs(gap.y.d[0]), std::fabs(gap.z.d[0]));
  }
  return Table<double>(free, {n, 12}, owner);
}

}  // namespace

void bind_planar_model(nb::module_& m) {
  m.def("planar_plant_fields", &field_table<planar::Parameters<double>>,
        "Fields of the planar plant's parameters.");
  m.def("planar_motion", &fast_motion, nb::arg("plant"), nb::arg("q"), nb::arg("q_dot"),
        nb::arg("loads"),
        "Accelerations and tensions by the fast formulation, at seven coordinates that satisfy "
        "the closure. loads: u1..u4, vehicle pushes (4), bar push (2), N, bar torque, N m.");
  m.def("planar_redundant_motion", &redundant, nb::arg("plant"), nb::arg("q"), nb::arg("q_dot"),
        nb::arg("loads"), "The same by equations (7)-(16) with the closure's multipliers.");
  m.def(
      "planar_mass_matrix",
      [](const Values& values, const Seven<double>& q) {
        const auto plant = plant_from(values);
        return mass_matrix(plant, bar_jacobian(plant, q, Seven<double>{}));
      },
      nb::arg("plant"), nb::arg("q"), "M(q) of (15).");
  m.def(
      "planar_closure",
      [](const Values& values, const Seven<double>& q) {
        const auto c = closure(plant_from(values), q);
        return std::array<double, 2>{c.y, c.z};
      },
      nb::arg("plant"), nb::arg("q"), "c(q), m.");
  m.def(
      "planar_rest_angles",
      [](const Values& values, const Four& vehicle) -> std::optional<std::array<double, 3>> {
        std::array<double, 3> theta{};
        if (!rest_angles(plant_from(values), pair_from(vehicle), theta)) return std::nullopt;
        return theta;
      },
      nb::arg("plant"), nb::arg("vehicle_position"),
      "Angles, rad, at which the load hangs at rest below vehicles at (y1, z1, y2, z2), m; None "
      "where there is no rest with all angles inside +-pi/2.");
  m.def(
      "planar_seven",
      [](const Values& values, const std::array<double, 2>& bar, const std::array<double, 3>& theta,
         const std::array<double, 2>& bar_velocity, const std::array<double, 3>& theta_dot) {
        const auto plant = plant_from(values);
        const State<double> state{
            {bar[0], bar[1]}, theta, {bar_velocity[0], bar_velocity[1]}, theta_dot};
        const auto pose = pose_of(plant, state);
        return nb::make_tuple(join_seven(pose.vehicle, theta),
                              join_seven(pose.vehicle_velocity, theta_dot));
      },
      nb::arg("plant"), nb::arg("bar"), nb::arg("theta"), nb::arg("bar_velocity"),
      nb::arg("theta_dot"), "q and q_dot from the five free coordinates and their rates.");
  m.def(
      "planar_free_coordinates",
      [](const Values& values, const Seven<double>& q, const Seven<double>& q_dot) {
        return state_from_seven(plant_from(values), q, q_dot).flat();
      },
      nb::arg("plant"), nb::arg("q"), nb::arg("q_dot"),
      "[bar y, bar z, theta1..3 and their rates] from the seven coordinates and their rates.");
  m.def("planar_starts", &starts, nb::arg("plants"), nb::arg("vehicle_positions"),
        nb::arg("angles"), nb::arg("vehicle_velocities"), nb::arg("angle_rates"),
        "For each row: the ten free coordinates, and how far the start misses the closure (m) and "
        "its rate (m/s). NaN angles mean at rest; a row of NaN, that there is none.");
  m.def("planar_jacobian", &jacobian, nb::arg("plant"), nb::arg("free_coordinates"), nb::arg("u"),
        "Exact derivatives, 10 x 14, of the rates of the free coordinates along themselves and u.");
  m.def("planar_energies", &energies, nb::arg("plant"), nb::arg("k_lambda"), nb::arg("k_p"),
        nb::arg("k_d"), nb::arg("gamma"), nb::arg("goal"), nb::arg("d_hat"), nb::arg("q"),
        nb::arg("q_dot"), nb::arg("loads"),
        "Energies (18), (46), (49), J, and the powers that change (49), W.");
}

}  // namespace multilift::bindings
