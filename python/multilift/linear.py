"""The closed loop near its goal as a linear system, and what the integrator can resolve of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ScenarioError

if TYPE_CHECKING:
    from multilift.scenario import Scenario


def closed_loop_matrix(scenario: Scenario) -> NDArray[np.float64]:
    """The closed loop's state matrix where the load hangs at rest at the goal.

    Of a planar scenario 10x10, state: the bar's centre of mass (y, z), theta1..3, and their rates.
    The plant is differentiated exactly (dual numbers), the law by central differences. The law acts
    continuously and at once, its estimates and integrals resting: delay, lag and sampling are left
    out.

    Raises:
        ValueError: if the load cannot hang at rest at the goal.
        ScenarioError: if the scenario's model has no linearisation.
    """
    return scenario.model.closed_loop_matrix(scenario)


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


def refuse_large_step(matrix: NDArray[np.float64], step: float, where: str) -> None:
    """Refuses an integration step that is too large for the stiffest mode of a closed loop.

    Args:
        matrix: state matrix, shape (n, n).
        step: s.
        where: for errors.

    Raises:
        ScenarioError: naming the step and the largest permitted one.
    """
    with np.errstate(all="ignore"):
        limit = largest_stable_step(matrix) if np.isfinite(matrix).all() else math.nan
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
