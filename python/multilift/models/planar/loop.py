"""The planar feedback loop about its rest under the law, to first order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multilift import _core
from multilift.loop import Loop, StateSpace
from multilift.models.planar import geometry

if TYPE_CHECKING:
    from multilift.models.planar.scenario import PlanarScenario

Array = NDArray[np.float64]

COORDINATES = ("y_p", "z_p", "theta1", "theta2", "theta3")
CHANNELS = ("vehicle 1, y", "vehicle 1, z", "vehicle 2, y", "vehicle 2, z")


#: How well a rest is found, m/s^2 and rad/s^2, and how often Newton's method may try.
_AT_REST, _TRIES = 1e-11, 30


def jacobian(plant: Mapping[str, Any], angle: Array) -> Array:
    """The seven coordinates along the five free ones, shape (7, 5).

    Args:
        plant: normalised ``[plant]`` table.
        angle: theta1..3, rad.
    """
    l1, l2 = plant["cable_length"]
    (s1, s2, s3), (c1, c2, c3) = np.sin(angle), np.cos(angle)
    half, l3 = 0.5 * plant["bar_length"], plant["bar_half_thickness"]
    rows = np.zeros((7, 5))
    rows[0:2, 0:2] = rows[2:4, 0:2] = np.eye(2)
    # An arm (a_y, a_z) from the bar's centre of mass to the cable's end moves by (-a_z, a_y).
    rows[0:2, 4] = half * s3 - l3 * c3, -half * c3 - l3 * s3
    rows[2:4, 4] = -half * s3 - l3 * c3, half * c3 - l3 * s3
    rows[0:2, 2] = -l1 * c1, -l1 * s1
    rows[2:4, 3] = l2 * c2, -l2 * s2
    rows[4:7, 2:5] = np.eye(3)
    return rows


def _pose(scenario: PlanarScenario, x: Array) -> tuple[list[float], Array]:
    """Seven coordinates, and the law's forces there at rest, shape (4,), N."""
    seven, rates = _core.planar_seven(
        scenario.plant_values(), x[:2].tolist(), x[2:5].tolist(), [0.0] * 2, [0.0] * 3
    )
    law = _core.PlanarLaw(
        scenario.law, scenario.gain_values(), scenario.assumed_values(),
        scenario.goal_vector().tolist(), scenario.control_period(),
    )  # fmt: skip
    return list(seven), np.array(law.step(seven, rates))


def _derivatives(scenario: PlanarScenario, x: Array) -> tuple[list[float], Array, Array, Array]:
    """At rest at x (5): the coordinates, a (10, 10), b (10, 4) and the feedback (4, 10)."""
    plant, goal = scenario.plant_values(), scenario.goal_vector().tolist()
    seven, u = _pose(scenario, x)
    both = np.array(_core.planar_jacobian(plant, [*x.tolist(), *[0.0] * 5], u.tolist()))
    law = np.array(
        _core.planar_law_jacobian(
            scenario.law, scenario.gain_values(), scenario.assumed_values(), goal,
            scenario.control_period(), seven, [0.0] * 7,
        )
    )  # fmt: skip
    along = jacobian(scenario.values["plant"], x[2:5])
    feedback = np.hstack([law[:, :7] @ along, law[:, 7:] @ along])
    return seven, both[:, :10], both[:, 10:], feedback


def rest(scenario: PlanarScenario) -> Array:
    """Where the load comes to rest under the law, nearest to the goal: y_p, z_p, theta1..3.

    For goals that satisfy (17) it is the goal. The law's estimates and integrals stay as at the
    start.

    Raises:
        ValueError: if the load cannot hang at the goal, or no rest is found near it.
    """
    plant, goal = scenario.plant_values(), scenario.goal_vector()
    angle = geometry.rest_angles(plant, goal.reshape(2, 2))
    q = np.concatenate([goal, angle])
    x = np.array(_core.planar_free_coordinates(plant, q.tolist(), [0.0] * 7))[:5]
    for _ in range(_TRIES):
        seven, a, b, feedback = _derivatives(scenario, x)
        u = _pose(scenario, x)[1]
        motion = _core.planar_motion(plant, seven, [0.0] * 7, [*u.tolist(), *[0.0] * 7])
        residual = np.array([*motion["bar_acceleration"], *motion["theta_ddot"]])
        if not np.isfinite(residual).all():
            break
        if np.abs(residual).max() < _AT_REST:
            return x
        step: Array = np.linalg.solve((a + b @ feedback)[5:, :5], residual)
        x = x - step * min(1.0, 0.3 / float(np.abs(step).max()))
    raise ValueError("no rest was found near the goal")


def _vehicles(scenario: PlanarScenario, u: Array) -> StateSpace:
    """Thrust and attitude that follow with first-order lags, about the rotors' forces at rest."""
    actuators, plant = scenario.values["actuators"], scenario.values["plant"]
    lags = (actuators["thrust_time_constant"], actuators["attitude_time_constant"])
    step = scenario["simulation.step"]
    poles, into, out, through = [], [], [], np.zeros((4, 4))
    for i in range(2):
        weight = (plant["vehicle_mass"][i] + 0.5 * plant["bar_mass"]) * plant["gravity"]
        force = u[2 * i : 2 * i + 2] + np.array([0.0, weight])
        along = force / np.hypot(*force)
        for direction, lag in ((along, lags[0]), (np.array([along[1], -along[0]]), lags[1])):
            channel = np.zeros(4)
            channel[2 * i : 2 * i + 2] = direction
            if lag < step:  # as the simulation has it
                through += np.outer(channel, channel)
                continue
            poles.append(-1.0 / lag)
            into.append(channel / lag)
            out.append(channel)
    shape = np.reshape
    return StateSpace(np.diag(poles), shape(into, (-1, 4)), shape(out, (-1, 4)).T, through)


def loop(scenario: PlanarScenario) -> Loop:
    """The feedback loop about its rest, by dual numbers through plant and law.

    Raises:
        ValueError: as `rest`.
    """
    x = rest(scenario)
    _, a, b, feedback = _derivatives(scenario, x)
    sensors, hold = scenario.values["sensors"], 0.5 * scenario.control_period()
    stale = max(0.0, 0.5 * sensors["period"] - hold)
    delay = hold + stale + sensors["delay"] + scenario["actuators.command_delay"]
    names = (*COORDINATES, *(f"rate of {name}" for name in COORDINATES))
    vehicles = _vehicles(scenario, _pose(scenario, x)[1])
    return Loop(names, CHANNELS, a, b, feedback, vehicles, delay, hold)
