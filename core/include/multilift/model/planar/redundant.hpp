// Equations of motion of the planar plant, the readable way: the paper's (7)-(16) as printed, in
// the seven redundant coordinates, closed by the bar's geometry.
//
//     [ M  J^T ] [ q_ddot ]   [ U + F_r + F_push - C q_dot - G ]
//     [ J   0  ] [  -mu   ] = [ -J_dot q_dot                   ]
//
// M alone has rank 6 at most (5 where theta1 = -theta2 = theta3, as at hover), since the angles
// enter the kinetic energy (5) only through the bar's two velocity components; with the closure
// c(q) = 0 and its multipliers mu the system is regular. mu is the bar's internal force: R1 - R2 =
// 2 mu, with R_i the force of cable i on the bar, where the bar has no inertia and is not pushed.
// Used as the reference that the fast formulation (dynamics.hpp) is tested against.
#pragma once

#include "multilift/math/dense.hpp"
#include "multilift/model/planar/dynamics.hpp"

namespace multilift::planar {

/// Jacobian of the bar's centre of mass (1), 2x7, and the part of its acceleration that holds
/// without q_ddot.
template <Real R>
struct BarJacobian {
  std::array<Vec2<R>, 7> column;
  Vec2<R> bias;
};

template <Real R>
BarJacobian<R> bar_jacobian(const Plant<R>& p, const Seven<R>& q, const Seven<R>& q_dot) {
  const R half(0.5), zero(0.0);
  const auto [s1, c1] = sincos(q[4]);
  const auto [s2, c2] = sincos(q[5]);
  const auto [s3, c3] = sincos(q[6]);
  const R l1 = p.cable_length[0], l2 = p.cable_length[1], l3 = p.bar_half_thickness;
  const R w1 = square(q_dot[4]), w2 = square(q_dot[5]), w3 = square(q_dot[6]);
  return {{{{half, zero},
            {zero, half},
            {half, zero},
            {zero, half},
            {half * l1 * c1, half * l1 * s1},
            {-half * l2 * c2, half * l2 * s2},
            {l3 * c3, l3 * s3}}},
          {half * (-l1 * s1 * w1 + l2 * s2 * w2) - l3 * s3 * w3,
           half * (l1 * c1 * w1 + l2 * c2 * w2) + l3 * c3 * w3}};
}

/// M(q) of (15), kg, kg m and kg m^2.
template <Real R>
Matrix<R, 7> mass_matrix(const Plant<R>& p, const BarJacobian<R>& jacobian) {
  Matrix<R, 7> m{};
  for (std::size_t i = 0; i < 7; ++i)
    for (std::size_t j = 0; j < 7; ++j)
      m[i][j] = p.bar_mass * dot(jacobian.column[i], jacobian.column[j]);
  for (std::size_t i = 0; i < 4; ++i) m[i][i] += p.vehicle_mass[i / 2];
  m[6][6] += p.bar_inertia;
  return m;
}

/// G(q) of (16), N and N m.
template <Real R>
Seven<R> gravity_vector(const Plant<R>& p, const Seven<R>& q) {
  const R weight = p.bar_mass * p.gravity;
  const R zero(0.0), half(0.5);
  return {zero,
          zero,
          zero,
          zero,
          half * weight * p.cable_length[0] * sincos(q[4]).sin,
          half * weight * p.cable_length[1] * sincos(q[5]).sin,
          weight * p.bar_half_thickness * sincos(q[6]).sin};
}

template <Real R>
struct RedundantMotion {
  Seven<R> q_ddot;
  Vec2<R> mu;                // the bar's internal force, N
  std::array<R, 2> tension;  // N
  bool regular;              // false where the system cannot be solved
};

template <Real R>
RedundantMotion<R> redundant_motion(const Plant<R>& p, const Seven<R>& q, const Seven<R>& q_dot,
                                    const Loads<R>& loads) {
  const BarJacobian<R> jacobian = bar_jacobian(p, q, q_dot);
  const Matrix<R, 7> m = mass_matrix(p, jacobian);
  const Seven<R> g = gravity_vector(p, q);
  const auto [s1, c1] = sincos(q[4]);
  const auto [s2, c2] = sincos(q[5]);
  const auto [s3, c3] = sincos(q[6]);
  const R l0 = p.bar_length, l1 = p.cable_length[0], l2 = p.cable_length[1];
  const R one(1.0), zero(0.0);

  // J = dc/dq, row by row, and J_dot q_dot.
  const std::array<Seven<R>, 2> closure_jacobian{
      Seven<R>{-one, zero, one, zero, -l1 * c1, -l2 * c2, l0 * s3},
      Seven<R>{zero, -one, zero, one, -l1 * s1, l2 * s2, -l0 * c3}};
  const R w1 = square(q_dot[4]), w2 = square(q_dot[5]), w3 = square(q_dot[6]);
  const std::array<R, 2> closure_bias{l1 * s1 * w1 + l2 * s2 * w2 + l0 * c3 * w3,
                                      -l1 * c1 * w1 + l2 * c2 * w2 + l0 * s3 * w3};

  const Seven<R> damping{p.vehicle_drag[0].y, p.vehicle_drag[0].z, p.vehicle_drag[1].y,
                         p.vehicle_drag[1].z, p.swing_damping[0],  p.swing_damping[1],
                         p.swing_damping[2]};
  const Seven<R> applied{loads.u[0].y + loads.vehicle_push[0].y,
                         loads.u[0].z + loads.vehicle_push[0].z,
                         loads.u[1].y + loads.vehicle_push[1].y,
                         loads.u[1].z + loads.vehicle_push[1].z,
                         zero,
                         zero,
                         loads.bar_torque};

  Matrix<R, 9> a{};
  std::array<R, 9> b{};
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t j = 0; j < 7; ++j) a[i][j] = m[i][j];
    for (std::size_t k = 0; k < 2; ++k) {
      a[i][7 + k] = closure_jacobian[k][i];
      a[7 + k][i] = closure_jacobian[k][i];
    }
    b[i] = applied[i] + dot(jacobian.column[i], loads.bar_push) - damping[i] * q_dot[i] - g[i] -
           p.bar_mass * dot(jacobian.column[i], jacobian.bias);
  }
  for (std::size_t k = 0; k < 2; ++k) b[7 + k] = -closure_bias[k];

  RedundantMotion<R> result{};
  std::array<R, 9> x{};
  result.regular = solve_dense(a, b, x);
  for (std::size_t i = 0; i < 7; ++i) result.q_ddot[i] = x[i];
  result.mu = {-x[7], -x[8]};

  // The tension is what vehicle i's own balance leaves along its cable.
  const std::array<Vec2<R>, 2> direction{Vec2<R>{-s1, c1}, Vec2<R>{s2, c2}};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec2<R> acceleration{x[2 * i], x[2 * i + 1]};
    const Vec2<R> force{applied[2 * i] - damping[2 * i] * q_dot[2 * i],
                        applied[2 * i + 1] - damping[2 * i + 1] * q_dot[2 * i + 1] +
                            R(0.5) * p.bar_mass * p.gravity};
    result.tension[i] = dot(direction[i], force - p.vehicle_mass[i] * acceleration);
  }
  return result;
}

}  // namespace multilift::planar
