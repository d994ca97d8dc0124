"""The closed loop near its goal: modes, and the step that the integrator can take."""

import multilift as ml
import numpy as np
import pytest
from multilift import _core, linear

NAMES = ["sim1", "sim2", "exp1_1", "exp1_2", "exp2"]


def rk4_matrix(a, h):
    power, result = np.eye(len(a)), np.eye(len(a))
    for k in (1, 2, 3, 4):
        power = power @ (h * a) / k
        result = result + power
    return result


@pytest.mark.parametrize("law", ["energy_coupled", "pd"])
@pytest.mark.parametrize("name", NAMES)
def test_the_laws_are_locally_stable_on_the_papers_tests(name, law):
    modes = np.linalg.eigvals(linear.closed_loop_matrix(ml.load(name).with_law(law)))
    assert modes.real.max() < 0


@pytest.mark.parametrize("name", NAMES)
def test_the_step_limit_is_where_rk4_stops_damping(name):
    matrix = linear.closed_loop_matrix(ml.load(name))
    limit = linear.largest_stable_step(matrix)

    def radius(step):
        return np.abs(np.linalg.eigvals(rk4_matrix(matrix, step))).max()

    assert radius(0.99 * limit) < 1.0 < radius(1.01 * limit)


def test_known_limits():
    # RK4 on a decaying mode: |R(z)| = 1 at z = -2.785293563...; a growing one has no limit.
    assert linear.largest_stable_step(np.array([[-1.0]])) == pytest.approx(2.7852935634, abs=1e-3)
    assert linear.largest_stable_step(np.array([[1.0]])) == np.inf


def test_jacobian_is_the_derivative_of_the_motion():
    scenario = ml.load("sim1")
    plant = scenario.plant_values()
    rng = np.random.default_rng(1)
    x, u = rng.uniform(-0.4, 0.4, 10), rng.uniform(-2, 2, 4)

    def rate(x, u):
        q, q_dot = _core.planar_seven(
            plant, x[:2].tolist(), x[2:5].tolist(), x[5:7].tolist(), x[7:].tolist()
        )
        motion = _core.planar_motion(plant, q, q_dot, [*u.tolist(), *[0.0] * 7])
        return np.concatenate([x[5:], motion["bar_acceleration"], motion["theta_ddot"]])

    exact = np.array(_core.planar_jacobian(plant, x.tolist(), u.tolist()))
    h = 1e-5
    for k in range(14):
        dx, du = np.zeros(10), np.zeros(4)
        (dx if k < 10 else du)[k % 10 if k < 10 else k - 10] = h
        slope = (rate(x + dx, u + du) - rate(x - dx, u - du)) / (2 * h)
        # Central differences: truncation h^2 times third derivatives of order 10^2.
        assert exact[:, k] == pytest.approx(slope, abs=2e-7, rel=2e-7)
