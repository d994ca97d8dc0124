// Where the load hangs at rest below vehicles that stand still.
#pragma once

#include <algorithm>
#include <numbers>

#include "multilift/math/dense.hpp"
#include "multilift/model/planar/state.hpp"

namespace multilift::planar {

/// Finds the angles by Newton's method on the stationarity of the load's potential energy under the
/// closure, with the closure's two multipliers, from cables that point straight down and, failing
/// that, from the inclination that the vehicles' distance suggests. Returns false, and leaves theta
/// unspecified, where no rest with all angles inside +-pi/2 was found.
inline bool rest_angles(const Plant<double>& plant, const std::array<Vec2<double>, 2>& vehicle,
                        std::array<double, 3>& theta) {
  using D = Dual<5>;
  const double l0 = plant.bar_length, l1 = plant.cable_length[0], l2 = plant.cable_length[1];
  const Vec2<double> apart = vehicle[1] - vehicle[0];

  // Potential energy per bar weight, differentiated along the angles, less J^T mu; then c(q).
  const auto stationarity = [&](const std::array<D, 5>& x) {
    const auto [s1, c1] = sincos(x[0]);
    const auto [s2, c2] = sincos(x[1]);
    const auto [s3, c3] = sincos(x[2]);
    const D &mu_y = x[3], &mu_z = x[4];
    return std::array<D, 5>{
        0.5 * l1 * s1 - (-l1 * c1 * mu_y - l1 * s1 * mu_z),
        0.5 * l2 * s2 - (-l2 * c2 * mu_y + l2 * s2 * mu_z),
        plant.bar_half_thickness * s3 - (l0 * s3 * mu_y - l0 * c3 * mu_z),
        apart.y - l2 * s2 - l1 * s1 - l0 * c3,
        apart.z - l2 * c2 + l1 * c1 - l0 * s3,
    };
  };

  const double tilt = apart.y != 0.0 ? std::atan2(apart.z, apart.y) : 0.0;
  const double lean =
      std::asin(std::clamp((apart.y - l0 * std::cos(tilt)) / (l1 + l2), -0.99, 0.99));
  for (const auto& start :
       {std::array<double, 3>{0.0, 0.0, 0.0}, {lean, lean, tilt}, {lean, lean, 0.5 * tilt}}) {
    std::array<double, 5> x{start[0], start[1], start[2], 0.0, 0.0};
    double residual = unlimited;
    for (int iteration = 0; iteration < 100; ++iteration) {
      std::array<D, 5> variable;
      for (int k = 0; k < 5; ++k)
        variable[static_cast<std::size_t>(k)] = D::variable(x[static_cast<std::size_t>(k)], k);
      const std::array<D, 5> f = stationarity(variable);
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
    theta = {x[0], x[1], x[2]};
    const bool inside = std::all_of(theta.begin(), theta.end(), [](double angle) {
      return std::fabs(angle) < std::numbers::pi / 2;
    });
    if (residual < 1e-9 && inside) return true;
  }
  return false;
}

}  // namespace multilift::planar
