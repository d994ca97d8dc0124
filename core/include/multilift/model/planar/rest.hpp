// Where the load hangs at rest below vehicles that stand still.
#pragma once

#include <algorithm>
#include <numbers>

#include "multilift/math/atan.hpp"
#include "multilift/math/dense.hpp"
#include "multilift/model/planar/state.hpp"

namespace multilift::planar {

/// The load below two vehicles that stand still, as a problem in its three angles and the closure's
/// two multipliers.
template <Real R>
struct Hanging {
  R l0, l1, l2, l3;
  Vec2<R> apart;  // from vehicle 1 to vehicle 2, m

  Hanging(const Plant<R>& plant, const std::array<Vec2<R>, 2>& vehicle)
      : l0(plant.bar_length),
        l1(plant.cable_length[0]),
        l2(plant.cable_length[1]),
        l3(plant.bar_half_thickness),
        apart(vehicle[1] - vehicle[0]) {}

  /// The same numbers as constants of another scalar.
  template <Real S>
  explicit Hanging(const Hanging<S>& h)
      : l0(value(h.l0)),
        l1(value(h.l1)),
        l2(value(h.l2)),
        l3(value(h.l3)),
        apart{R(value(h.apart.y)), R(value(h.apart.z))} {}

  /// Zero at rest: the potential energy per bar weight, differentiated along the angles, less
  /// J^T mu; then c(q).
  std::array<R, 5> stationarity(const std::array<R, 5>& x) const {
    const auto [s1, c1] = sincos(x[0]);
    const auto [s2, c2] = sincos(x[1]);
    const auto [s3, c3] = sincos(x[2]);
    const R &mu_y = x[3], &mu_z = x[4];
    const R half(0.5);
    return {
        half * l1 * s1 - (-l1 * c1 * mu_y - l1 * s1 * mu_z),
        half * l2 * s2 - (-l2 * c2 * mu_y + l2 * s2 * mu_z),
        l3 * s3 - (l0 * s3 * mu_y - l0 * c3 * mu_z),
        apart.y - l2 * s2 - l1 * s1 - l0 * c3,
        apart.z - l2 * c2 + l1 * c1 - l0 * s3,
    };
  }
};

/// Finds the angles, followed by the multipliers, by Newton's method from cables that point
/// straight down and, failing that, from the inclination that the vehicles' distance suggests.
/// Returns false, and leaves x unspecified, where no rest with all angles inside +-pi/2 was found.
inline bool solve_rest(const Hanging<double>& load, std::array<double, 5>& x) {
  using D = Dual<5>;
  const auto& [l0, l1, l2, l3, apart] = load;
  const Hanging<D> differentiated(load);

  const double tilt = apart.y != 0.0 ? atan2(apart.z, apart.y) : 0.0;
  const double sine = std::clamp((apart.y - l0 * sincos(tilt).cos) / (l1 + l2), -0.99, 0.99);
  const double lean = atan2(sine, sqrt((1.0 - sine) * (1.0 + sine)));
  for (const auto& start :
       {std::array<double, 3>{0.0, 0.0, 0.0}, {lean, lean, tilt}, {lean, lean, 0.5 * tilt}}) {
    x = {start[0], start[1], start[2], 0.0, 0.0};
    double residual = unlimited;
    for (int iteration = 0; iteration < 100; ++iteration) {
      std::array<D, 5> variable;
      for (int k = 0; k < 5; ++k)
        variable[static_cast<std::size_t>(k)] = D::variable(x[static_cast<std::size_t>(k)], k);
      const std::array<D, 5> f = differentiated.stationarity(variable);
      Matrix<double, 5> slope;
      std::array<double, 5> minus_f, step;
      residual = 0.0;
      for (std::size_t i = 0; i < 5; ++i) {
        slope[i] = f[i].d;
        minus_f[i] = -f[i].x;
        residual = std::max(residual, std::fabs(f[i].x));
      }
      if (residual < 1e-14 || !solve_dense(slope, minus_f, step)) break;
      // No angle turns by more than half a radian at once.
      const double turn =
          std::max({std::fabs(step[0]), std::fabs(step[1]), std::fabs(step[2]), 0.5});
      double moved = 0.0;
      for (std::size_t i = 0; i < 5; ++i) {
        x[i] += 0.5 / turn * step[i];
        moved = std::max(moved, std::fabs(step[i]));
      }
      if (moved < 1e-16) break;
    }
    const bool inside = std::all_of(x.begin(), x.begin() + 3, [](double angle) {
      return std::fabs(angle) < std::numbers::pi / 2;
    });
    if (residual < 1e-9 && inside) return true;
  }
  return false;
}

/// The angles alone.
inline bool rest_angles(const Plant<double>& plant, const std::array<Vec2<double>, 2>& vehicle,
                        std::array<double, 3>& theta) {
  std::array<double, 5> x{};
  const bool found = solve_rest({plant, vehicle}, x);
  theta = {x[0], x[1], x[2]};
  return found;
}

/// The derivatives of the angles along whatever the plant and the vehicles' positions depend on,
/// by the implicit function theorem: F(x(p), p) = 0 gives F_x dx = -F_p dp. The angles' values are
/// those of rest_angles.
template <int N>
bool rest_angles(const Plant<Dual<N>>& plant, const std::array<Vec2<Dual<N>>, 2>& vehicle,
                 std::array<Dual<N>, 3>& theta) {
  using D = Dual<5>;
  const Hanging<Dual<N>> load(plant, vehicle);
  const Hanging<double> values(load);
  std::array<double, 5> x{};
  if (!solve_rest(values, x)) return false;
  std::array<D, 5> variable;
  std::array<Dual<N>, 5> constant;
  for (int k = 0; k < 5; ++k) {
    const auto i = static_cast<std::size_t>(k);
    variable[i] = D::variable(x[i], k);
    constant[i] = x[i];
  }
  const auto f_x = Hanging<D>(values).stationarity(variable);
  const auto f_p = load.stationarity(constant);
  for (std::size_t direction = 0; direction < N; ++direction) {
    Matrix<double, 5> slope;
    std::array<double, 5> right, dx;
    for (std::size_t i = 0; i < 5; ++i) {
      slope[i] = f_x[i].d;
      right[i] = -f_p[i].d[direction];
    }
    if (!solve_dense(slope, right, dx)) return false;
    for (std::size_t i = 0; i < 3; ++i) theta[i].d[direction] = dx[i];
  }
  for (std::size_t i = 0; i < 3; ++i) theta[i].x = x[i];
  return true;
}

}  // namespace multilift::planar
