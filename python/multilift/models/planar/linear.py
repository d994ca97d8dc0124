"""The planar closed loop near its goal as a linear system."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from multilift import _core
from multilift.linear import refuse_large_step
from multilift.models.planar import geometry

if TYPE_CHECKING:
    from multilift.models.planar.scenario import PlanarScenario


def closed_loop_matrix(scenario: PlanarScenario) -> NDArray[np.float64]:
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


def check_step(scenario: PlanarScenario, where: str) -> None:
    """Refuses an integration step that is too large for the stiffest mode near the goal.

    Raises:
        ScenarioError: naming the step and the largest permitted one.
    """
    try:
        with np.errstate(all="ignore"):
            matrix = closed_loop_matrix(scenario)
    except ValueError:
        return  # no rest at the goal: nothing to linearise about
    refuse_large_step(matrix, float(scenario.values["simulation"]["step"]), where)
