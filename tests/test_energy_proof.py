"""How the storage function (49) changes, proved by SymPy for vehicles and cables of any size.

The rows of the equations of motion times chi = [xi_dot + eta_dot, (1 + k kappa) theta_dot], k for
k_lambda, add up to d/dt E_k, whatever q, q_dot and q_ddot are. What the rows are equal to decides
the rest: with the paper's right sides U + F_r it is (57), exactly; with the closure's forces J' mu
beside them, chi' J' mu remains, the term that (57) lacks.
"""

import planar_lagrange as lagrange
import pytest
import sympy as sp
from planar_lagrange import (
    J,
    a,
    added_energy,
    g,
    k,
    kappa,
    l1,
    l2,
    l3,
    m1,
    m2,
    m3,
    mechanical_energy,
    q,
    rate,
    swing,
    swing_rate,
    v,
    vanishes,
)
from sympy import cos, sin

C1, C2, C3 = (cos(angle) for angle in q[4:])
S1, S2, S3 = (sin(angle) for angle in q[4:])
w1, w2, w3 = v[4:]
alpha1, alpha2, alpha3 = a[4:]
lam = -k  # (45)

xi_dot, theta_dot = sp.Matrix(v[:4]), sp.Matrix(v[4:])
s_y, s_z = swing_rate
eta = -k * (swing / m1).col_join(swing / m2)  # (47)
eta_dot = rate(eta)

# The rows of (7)-(13): what must equal U + F_r, plus whatever else acts.
weights = [0, (m1 + m3 / 2) * g, 0, (m2 + m3 / 2) * g, 0, 0, 0]
rows = sp.Matrix([row - w for row, w in zip(lagrange.momentum_rate, weights, strict=True)])
angle_rows = rows[4:, :].subs(J, 0)
chi = (xi_dot + eta_dot).col_join((1 + k * kappa) * theta_dot)


@pytest.mark.parametrize("row", range(4), ids=[f"({n})" for n in range(33, 37)])
def test_rate_of_eta_is_the_swing_rate_over_the_mass(row):
    y = l1 * C1 * w1 - l2 * C2 * w2 + 2 * l3 * C3 * w3
    z = l1 * S1 * w1 + l2 * S2 * w2 + 2 * l3 * S3 * w3
    printed = [lam / m1 * y, lam / m1 * z, lam / m2 * y, lam / m2 * z]
    assert vanishes(eta_dot[row] - printed[row])


def test_31_and_32_are_the_derivatives_they_claim():
    y = l1 * C1 * alpha1 - l2 * C2 * alpha2 + 2 * l3 * C3 * alpha3
    y += -l1 * S1 * w1**2 + l2 * S2 * w2**2 - 2 * l3 * S3 * w3**2
    z = l1 * S1 * alpha1 + l2 * S2 * alpha2 + 2 * l3 * S3 * alpha3
    z += l1 * C1 * w1**2 + l2 * C2 * w2**2 + 2 * l3 * C3 * w3**2
    assert vanishes(rate(s_y**2) / 2 - s_y * y)
    assert vanishes(rate(s_z**2) / 2 - s_z * z)


@pytest.mark.parametrize("row", range(4), ids=[f"({n})" for n in range(37, 41)])
def test_power_of_each_signal_splits_as_37_to_40_say(row):
    m, s = (m1, m1, m2, m2)[row], (s_y, s_z)[row % 2]
    both = a[row % 2] + a[row % 2 + 2]
    printed = lam / m * s * (m * a[row] + m3 / 4 * both) + lam * m3 / (8 * m) * rate(s**2)
    assert vanishes(eta_dot[row] * rows[row] - printed)


def test_42_follows_from_the_angles_equations_once_its_typing_error_is_mended():
    f = sp.Matrix(sp.symbols("f1:4"))
    left = (a[0] + a[2]) * s_y + (a[1] + a[3]) * s_z
    c12, s12 = cos(q[4] + q[5]), sin(q[4] + q[5])
    c13, s13 = cos(q[4] - q[6]), sin(q[4] - q[6])
    c23, s23 = cos(q[5] + q[6]), sin(q[5] + q[6])

    def right(squared_rate):
        return (
            4 / m3 * (w1 * f[0] + w2 * f[1] + w3 * f[2])
            - 2 * g * l1 * S1 * w1
            - l1**2 * w1 * alpha1
            + l1 * l2 * c12 * w1 * alpha2
            - 2 * l1 * l3 * c13 * w1 * alpha3
            - l1 * l2 * s12 * w1 * w2**2
            - 2 * l1 * l3 * s13 * w1 * w3**2
            - l2**2 * w2 * alpha2
            - 2 * g * l2 * S2 * w2
            + l1 * l2 * c12 * alpha1 * w2
            + 2 * l2 * l3 * c23 * w2 * alpha3
            - l1 * l2 * s12 * squared_rate * w2
            - 2 * l2 * l3 * s23 * w2 * w3**2
            - 4 * g * l3 * S3 * w3
            - 4 * l3**2 * w3 * alpha3
            - 2 * l1 * l3 * c13 * alpha1 * w3
            + 2 * l2 * l3 * c23 * alpha2 * w3
            + 2 * l1 * l3 * s13 * w1**2 * w3
            - 2 * l2 * l3 * s23 * w2**2 * w3
        )

    follows = 4 / m3 * (theta_dot.dot(angle_rows) - theta_dot.dot(f))
    assert vanishes(left - right(w1**2) - follows)
    assert not vanishes(left - right(alpha1**2) - follows)


def test_43_is_the_integral_it_claims():
    weight = lam * (1 + m3 / (4 * m1) + m3 / (4 * m2))
    left = weight * ((a[0] + a[2]) * s_y + (a[1] + a[3]) * s_z)
    falling = l1 * (C1 - 1) + l2 * (C2 - 1) + 2 * l3 * (C3 - 1)
    printed = weight * (2 * g * falling - s_y**2 / 2 - s_z**2 / 2)
    shaping = -lam * kappa * theta_dot.dot(angle_rows)  # (23), friction being what the rows equal
    assert vanishes(left + shaping - rate(printed))


def test_20_the_rows_times_the_rates_are_the_power_of_the_mechanical_energy():
    assert vanishes(rate(mechanical_energy) - sp.Matrix(v).dot(rows))


def test_24_the_rows_times_eta_dot_and_23_are_the_power_of_the_added_energy():
    assert vanishes(
        rate(added_energy) - eta_dot.dot(rows[:4]) + lam * kappa * theta_dot.dot(rows[4:])
    )


def test_22_the_rows_times_chi_are_the_power_of_the_shaped_energy():
    assert vanishes(rate(mechanical_energy + added_energy) - chi.dot(rows))


# What (49) adds to E_k, and what the rows are equal to.
xi_d, d, d_hat, k_p, k_d, gamma, u, push = (
    sp.Matrix(sp.symbols(f"{name}1:5"))
    for name in ("xi_d", "d", "d_hat", "k_p", "k_d", "gamma", "u", "push")
)
d_theta = sp.Matrix(sp.symbols("d_theta1:4"))
mu, bar_push = sp.Matrix(sp.symbols("mu_y mu_z")), sp.Matrix(sp.symbols("F_y F_z"))
torque = sp.Symbol("tau")


def times(x, y):
    return x.multiply_elementwise(y)


eps, eps_dot = sp.Matrix(q[:4]) + eta - xi_d, xi_dot + eta_dot  # (48)
law = -times(k_p, eps) - times(k_d, eps_dot) + times(d_hat, xi_dot)  # (55)
adaptation_law = -times(gamma, times(xi_dot, eps_dot))  # (51)
friction = times(d, xi_dot).col_join(times(d_theta, theta_dot))  # -(14)


def storage_rate(estimate_rate):
    """Rate of (49) with the estimate moving at a given rate."""
    estimation = -sum((d[i] - d_hat[i]) * estimate_rate[i] / gamma[i] for i in range(4))
    return rate(mechanical_energy + added_energy + eps.dot(times(k_p, eps)) / 2) + estimation


printed_57 = -eps_dot.dot(times(k_d, eps_dot)) - (1 + k * kappa) * theta_dot.dot(
    times(d_theta, theta_dot)
)


def test_57_holds_for_the_papers_equations_as_they_stand():
    right_sides = law.col_join(sp.zeros(3, 1)) - friction
    assert vanishes(storage_rate(adaptation_law) - printed_57 - chi.dot(rows - right_sides))


@pytest.mark.parametrize("estimate_moves", [True, False])
def test_on_the_closed_plant_the_powers_that_the_core_names_change_the_storage_function(
    estimate_moves,
):
    closure_rate = rate(lagrange.closure)
    right_sides = (u + push).col_join(sp.Matrix([0, 0, torque])) - friction
    right_sides += lagrange.closure_jacobian.T * mu + lagrange.bar_jacobian.T * bar_push

    difference = 2 * mu  # of the cables' forces on the bar, see the next test
    closing = sp.Matrix(v[:2]) - sp.Matrix(v[2:4])
    internal = difference.dot(k * kappa * closing + k * (1 / m1 - 1 / m2) * swing_rate) / 2
    pushes = (
        eps_dot.dot(push)
        + bar_push.dot(lagrange.bar_velocity + 2 * k / m3 * swing_rate)
        + (1 + k * kappa) * torque * w3
    )
    actuation = eps_dot.dot(u - law)
    adaptation = 0 if estimate_moves else -eps_dot.dot(times(d - d_hat, xi_dot))
    powers = printed_57 + internal + pushes + actuation + adaptation

    # Zero along every motion: multiples of the rows' residuals and of the closure's rate.
    zero = chi.dot(rows - right_sides) + (1 + k * kappa) * mu.dot(closure_rate)
    estimate_rate = adaptation_law if estimate_moves else sp.zeros(4, 1)
    assert vanishes(storage_rate(estimate_rate) - powers - zero)


def test_a_moving_reference_adds_the_power_that_the_core_names():
    """The tracking law: xi_d + eta_d moves in the place of xi_d, with the forces along the way."""
    moving, moving_rate, feedforward = (
        sp.Matrix(sp.symbols(f"{name}1:5")) for name in ("r", "r_dot", "f")
    )
    error = eps + xi_d - moving
    error_rate = eps_dot - moving_rate
    tracking = -times(k_p, error) - times(k_d, error_rate) + times(d_hat, xi_dot) + feedforward
    stored = mechanical_energy + added_energy + error.dot(times(k_p, error)) / 2
    estimation = times(d - d_hat, xi_dot).dot(error_rate)  # (51) with the tracking error's rate
    change = rate(stored) - times(k_p, error).dot(moving_rate) + estimation

    right_sides = (u + push).col_join(sp.zeros(3, 1)) - friction
    right_sides += lagrange.closure_jacobian.T * mu
    closing = sp.Matrix(v[:2]) - sp.Matrix(v[2:4])
    damping = (1 + k * kappa) * theta_dot.dot(times(d_theta, theta_dot))
    powers = (
        -error_rate.dot(times(k_d, error_rate))
        - damping
        + mu.dot(k * kappa * closing + k * (1 / m1 - 1 / m2) * swing_rate)
        + error_rate.dot(push)
        + error_rate.dot(u - tracking)
        + moving_rate.dot(u - times(d, xi_dot) + push)
        + error_rate.dot(feedforward)
    )
    zero = chi.dot(rows - right_sides) + (1 + k * kappa) * mu.dot(rate(lagrange.closure))
    assert vanishes(change - powers - zero)


def test_multipliers_are_half_the_difference_of_the_cables_forces_on_the_bar():
    # A cable's force on the bar is what its vehicle's own balance leaves of u and pushes: in the
    # first four rows, all but m a, the closure's force and the halves of the push on the bar.
    masses = [m1, m1, m2, m2]
    beside = [row - m * acceleration for row, m, acceleration in zip(rows, masses, a, strict=False)]
    forces = sp.Matrix(beside) - (lagrange.closure_jacobian.T * mu)[:4, :]
    forces -= (lagrange.bar_jacobian.T * bar_push)[:4, :]
    assert all(vanishes(entry) for entry in forces[:2, :] - forces[2:, :] - 2 * mu)
