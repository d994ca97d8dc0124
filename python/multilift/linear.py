"""The closed loop near its goal as a linear system, and what the integrator can resolve of it."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from multilift import _core, geometry
from multilift.errors import ScenarioError


class ClosedLoop(Protocol):
    """What the linearisation needs of a scenario."""

    values: dict[str, Any]

    @property
    def law(self) -> str:
        """Name of the compiled law."""

    def plant_values(self) -> list[float]:
        """The plant's numbers in the core's order."""

    def assumed_values(self) -> list[float]:
        """The plant as the law assumes it."""

    def gain_values(self) -> list[float]:
        """The law's gains."""

    def goal_vector(self) -> NDArray[np.float64]:
        """[y1d, z1d, y2d, z2d], m."""

    def control_period(self) -> float:
        """Time between two steps of the law, s."""


def closed_loop_matrix(scenario: ClosedLoop) -> NDArray[np.float64]:
    """The closed loop's 10x10 state matrix where the load hangs at rest at the goal.

    State: the bar's centre of mass (y, z), theta1..3, and their rates. The plant is differentiated
    exactly (dual numbers), the law by central differences. The law acts continuously and at once,
    its estimates and integrals resting: delay, lag and sampling are left out.

    Raises:
        ValueError: if the load cannot hang at rest at the goal.
    """
    plant = scenario.plant_values()
    angle = geometry.rest_angles(plant, scenario.goal_vector().reshape(2, 2))
    q = np.concatenate([scenario.goal_vector(), angle])
    x = np.array(_core.planar_free_coordinates(plant, q.tolist(), [0.0] * 7))

    def law(state: NDArray[np.float64]) -> NDArray[np.float64]:
        seven, rates = _core.planar_seven(
            plant, state[0:2].tolist(), state[2:5].tolist(), state[5:7].tolist(),
            state[7:10].tolist(),
        )  # fmt: skip
        fresh = _core.PlanarLaw(
            scenario.law,
            scenario.gain_values(),
            scenario.assumed_values(),
            scenario.goal_vector().tolist(),
            scenario.control_period(),
        )
        return np.array(fresh.step(seven, rates))

    jacobian = np.array(_core.planar_jacobian(plant, x.tolist(), law(x).tolist()))
    h = 1e-6
    feedback = np.empty((4, 10))
    for k in range(10):
        d = np.zeros(10)
        d[k] = h
        feedback[:, k] = (law(x + d) - law(x - d)) / (2 * h)
    matrix: NDArray[np.float64] = jacobian[:, :10] + jacobian[:, 10:] @ feedback
    return matrix


def rk4_growth(z: NDArray[np.complex128]) -> NDArray[np.float64]:
    """|R(z)|, by which one Runge-Kutta step of order 4 multiplies a mode with h * eigenvalue z."""
    return np.abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)


def largest_stable_step(matrix: NDArray[np.float64]) -> float:
    """The largest step, s, at which RK4 damps every mode that the system itself damps.

    Args:
        matrix: state matrix, shape (n, n).
    """
    modes = np.linalg.eigvals(matrix)
    damped = modes[modes.real < -1e-9]
    if damped.size == 0:
        return float("inf")
    # Along each mode's ray the growth leaves 1 once, before |z| = 3.5.
    sizes = np.linspace(0.0, 3.5, 3501)[1:]
    rays = np.exp(1j * np.angle(damped))
    stable = rk4_growth(sizes[:, None] * rays[None, :]) <= 1.0
    first_bad = np.where(stable.all(axis=0), sizes.size, np.argmin(stable, axis=0))
    limits = np.concatenate([[0.0], sizes])[first_bad] / np.abs(damped)
    return float(limits.min())


def check_step(scenario: ClosedLoop, where: str) -> None:
    """Refuses an integration step that is too large for the stiffest mode near the goal.

    Raises:
        ScenarioError: naming the step and the largest permitted one.
    """
    try:
        with np.errstate(all="ignore"):
            matrix = closed_loop_matrix(scenario)
        limit = largest_stable_step(matrix) if np.isfinite(matrix).all() else math.nan
    except ValueError:
        return  # no rest at the goal: nothing to linearise about
    step = float(scenario.values["simulation"]["step"])
    if math.isnan(limit):
        raise ScenarioError(
            "makes numbers that no computer holds: some plant or gain is out of all proportion",
            where=where,
            key="plant",
            advice="check masses, lengths and gains, and their units",
        )
    if step > limit:
        raise ScenarioError(
            "is too large for the stiffest mode of the closed loop, which RK4 would blow up",
            where=where,
            key="simulation.step",
            value=step,
            permitted=f"0 < step <= {limit:.4g} s",
            advice="0.001 s suits most scenarios; lower a very large gain or damping otherwise",
        )
