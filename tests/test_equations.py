"""The paper's equations of motion and the core's against SymPy's own derivation."""

import numpy as np
import planar_lagrange as lagrange
import pytest
import sympy as sp
from hypothesis import given
from multilift import _core
from planar_lagrange import J, a, g, l0, l1, l2, l3, m1, m2, m3, q, v, vanishes
from planar_random import gravity_shares, laws, loads, plants, states
from sympy import cos, sin
from sympy.polys.matrices import DomainMatrix

EPS = np.finfo(float).eps

C1, C2, C3 = (cos(angle) for angle in q[4:])
S1, S2, S3 = (sin(angle) for angle in q[4:])
kappa = 4 / m3 + 1 / m1 + 1 / m2

# Directions of the cables from the bar's ends up, and the levers of their tensions about the
# bar's centre of mass.
directions = sp.Matrix([-S1, C1]), sp.Matrix([S2, C2])
arms = [l3 * sp.Matrix([-S3, C3]) - side * l0 / 2 * sp.Matrix([C3, S3]) for side in (1, -1)]
levers = [
    arm[0] * direction[1] - arm[1] * direction[0]
    for arm, direction in zip(arms, directions, strict=True)
]


def printed_rows():
    """The left sides of (7)-(13), in which u holds each vehicle's gravity share."""
    s_y = l1 * C1 * v[4] - l2 * C2 * v[5] + 2 * l3 * C3 * v[6]
    s_z = l1 * S1 * v[4] + l2 * S2 * v[5] + 2 * l3 * S3 * v[6]
    sum_y = a[0] + a[2] + lagrange.rate(s_y)
    sum_z = a[1] + a[3] + lagrange.rate(s_z)
    return [
        m1 * a[0] + m3 / 4 * sum_y,
        m1 * a[1] + m3 / 4 * sum_z,
        m2 * a[2] + m3 / 4 * sum_y,
        m2 * a[3] + m3 / 4 * sum_z,
        m3 / 4 * l1 * (C1 * sum_y + S1 * sum_z) + m3 / 2 * g * l1 * S1,
        m3 / 4 * l2 * (-C2 * sum_y + S2 * sum_z) + m3 / 2 * g * l2 * S2,
        m3 / 2 * l3 * (C3 * sum_y + S3 * sum_z) + m3 * g * l3 * S3,
    ]


@pytest.mark.parametrize("row", range(7), ids=[f"({k})" for k in range(7, 14)])
def test_printed_equations_are_the_euler_lagrange_equations(row):
    # The generalised force of thrust f is u + (m_i + m3/2) g along z; a bar with inertia adds
    # J theta3_ddot to (13).
    share = {1: (m1 + m3 / 2) * g, 3: (m2 + m3 / 2) * g}.get(row, 0)
    turning = J * a[6] if row == 6 else 0
    assert vanishes(lagrange.momentum_rate[row] - share - turning - printed_rows()[row])


def test_gravity_vector_is_what_16_says():
    at_rest = dict.fromkeys((*v, *a), 0)
    printed = [0, 0, 0, 0, m3 * g * l1 * S1 / 2, m3 * g * l2 * S2 / 2, m3 * g * l3 * S3]
    rows = [row.subs(at_rest) for row in printed_rows()]
    assert all(vanishes(row - entry) for row, entry in zip(rows, printed, strict=True))


def test_mass_matrix_has_at_most_rank_six():
    # Eliminating the vehicles leaves 4/kappa times the Gram matrix of d(bar)/d(theta), 2x3, so
    # that for J = 0 the rank of M is 4 plus the rank of that matrix: never 7, and 5 where its
    # columns are parallel, theta1 = -theta2 = theta3, hover included.
    mass = lagrange.mass.subs(J, 0)
    swing = lagrange.bar_jacobian[:, 4:]
    complement = mass[4:, 4:] - mass[4:, :4] * mass[:4, :4].inv() * mass[:4, 4:]
    assert all(vanishes(entry) for entry in complement - 4 / kappa * swing.T * swing)
    parallel = swing.subs({q[5]: -q[4], q[6]: q[4]})
    assert sp.simplify(parallel[:, 0].row_join(parallel[:, 1]).det()) == 0
    assert sp.simplify(parallel[:, 0].row_join(parallel[:, 2]).det()) == 0


def test_closed_system_is_regular_unless_both_cables_point_at_the_centre_of_an_inertialess_bar():
    # By Cauchy and Binet, a sum of terms none of which is negative.
    lever_1, lever_2 = levers
    spread = lever_2 * directions[0] - lever_1 * directions[1]
    crossing = directions[0][0] * directions[1][1] - directions[0][1] * directions[1][0]
    expected = (m1 * m2 * (l1 * l2) ** 2) * (
        m3**2 * (m1 * lever_1**2 + m2 * lever_2**2)
        + m1 * m2 * m3 * spread.dot(spread)
        + J * (m3**2 + m3 * (m1 + m2) + m1 * m2 * crossing**2)
    )
    jacobian = lagrange.closure_jacobian
    rows = lagrange.mass.row_join(jacobian.T).col_join(jacobian.row_join(sp.zeros(2)))
    system = DomainMatrix.from_Matrix(rows.xreplace(lagrange.algebraic))
    determinant = system.domain.to_sympy(system.det())
    assert vanishes(determinant - expected)


unknowns = (lagrange.parameters, q, v)
bias = sp.Matrix(lagrange.momentum_rate).subs(dict.fromkeys(a, 0))
closure_bias = lagrange.rate(lagrange.rate(lagrange.closure)).subs(dict.fromkeys(a, 0))
mass_of = sp.lambdify(unknowns, lagrange.mass)
bias_of = sp.lambdify(unknowns, bias, cse=True)
bar_jacobian_of = sp.lambdify(unknowns, lagrange.bar_jacobian)
closure_jacobian_of = sp.lambdify(unknowns, lagrange.closure_jacobian)
closure_bias_of = sp.lambdify(unknowns, closure_bias, cse=True)


def arguments(plant, q_now, q_dot):
    """The numbers behind `unknowns`."""
    p = plant
    numbers = (*p.vehicle_mass, p.bar_mass, p.bar_length, *p.cable_length)
    return (*numbers, p.bar_half_thickness, p.bar_inertia, p.gravity), q_now, q_dot


@laws
@given(plants(), states)
def test_core_mass_matrix_is_the_hessian_of_the_kinetic_energy(plant, state):
    q_now, q_dot = state.seven(plant)
    expected = mass_of(*arguments(plant, q_now, q_dot))
    # Entries are sums of a few products of the same numbers.
    error = np.array(_core.planar_mass_matrix(plant.values, q_now)) - expected
    assert np.abs(error).max() <= 4 * EPS * np.abs(expected).max()


@laws
@given(plants(bar_inertia=0.0))
def test_core_mass_matrix_without_bar_inertia_has_rank_six_aslant_and_five_at_hover(plant):
    for angle, rank in ((0.3, 6), (0.0, 5)):
        aslant = (0.0, 0.0, angle, angle, angle)
        q_now, _ = _core.planar_seven(plant.values, aslant[:2], aslant[2:], (0, 0), (0, 0, 0))
        matrix = np.array(_core.planar_mass_matrix(plant.values, q_now))
        assert np.linalg.matrix_rank(matrix) == rank


@laws
@given(plants(), states, loads)
def test_core_motion_satisfies_the_derived_equations_and_the_closure(plant, state, load):
    q_now, q_dot = state.seven(plant)
    motion = _core.planar_redundant_motion(plant.values, q_now, q_dot, load)
    assert motion["regular"]
    q_ddot, mu = np.array(motion["q_ddot"]), np.array(motion["mu"])
    numbers = arguments(plant, q_now, q_dot)
    closure_jacobian, bar_jacobian = closure_jacobian_of(*numbers), bar_jacobian_of(*numbers)
    thrust_and_push = load[:4] + gravity_shares(plant) + load[4:8]
    forces = [
        -mass_of(*numbers) @ q_ddot,
        -bias_of(*numbers).ravel(),
        -np.hstack([plant.vehicle_drag, plant.swing_damping]) * q_dot,
        np.hstack([thrust_and_push, [0, 0, load[10]]]),
        bar_jacobian.T @ load[8:10],
        closure_jacobian.T @ mu,
    ]
    accelerations = [closure_jacobian @ q_ddot, closure_bias_of(*numbers).ravel()]
    for terms in (forces, accelerations):
        # Elimination of 9 unknowns leaves rounding errors of the largest term by the ten; the
        # worst of 4000 examples driven towards it left 75.
        assert np.abs(sum(terms)).max() <= 400 * EPS * (1 + np.abs(terms).max())
