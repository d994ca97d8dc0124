"""A flight that was measured, told as a run: with a run's columns, metrics and audit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift import _core
from multilift.errors import ScenarioError
from multilift.models.spatial import rows
from multilift.models.spatial.run import SpatialRun
from multilift.models.spatial.scenario import SpatialScenario
from multilift.saved import SavedLaw

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """What was measured of n vehicles and their load, row by row; world axes, SI and radians.

    Attributes:
        t: ascending, shape (rows,), s.
        planned: the reference's time then, shape (rows,), s.
        payload: position, attitude (w, x, y, z), velocity, rate in its frame, shape (rows, 13).
        vehicle: the same of each vehicle, shape (rows, n, 13).
        force: that the law asked of each vehicle's rotors, shape (rows, n, 3), N.
        drag_estimate: what the law had learnt, shape (rows, n, 3), N s/m.
    """

    t: Array
    planned: Array
    payload: Array
    vehicle: Array
    force: Array
    drag_estimate: Array


def run_of(
    scenario: SpatialScenario, flown: Measured, law: SavedLaw, *, complete: bool
) -> SpatialRun:
    """The run that a flight was.

    Tensions are those of the equations of motion; the rotors follow the forces with their lag. A
    scenario's pushes and failures are not in it: who pushed a real flight is not known. Nor is the
    floor.

    Args:
        scenario: that was flown, of quadrotors.
        flown: what was measured, one row or more.
        law: its name and title.
        complete: whether it lasted as long as the scenario.

    Raises:
        ScenarioError: for ideal vehicles, and a law that is not compiled.
    """
    where = scenario.where
    if scenario["vehicle.kind"] != "quadrotor":
        raise ScenarioError("has ideal vehicles, which nobody flies", where=where)
    if scenario.law not in scenario.model.laws:
        raise ScenarioError(
            "is no compiled law", where=where, key="controller.law", value=scenario.law
        )
    calm = SpatialScenario({**scenario.raw(), "push": [], "event": []}, where)
    frame, row, _seed = rows.problem(calm)
    count = len(flown.t)
    craft = np.concatenate([flown.vehicle, _rotor_speeds(calm, flown)], axis=2)
    table = np.concatenate(
        [
            flown.t[:, None],
            flown.planned[:, None],
            flown.payload,
            craft.reshape(count, -1),
            flown.force.reshape(count, -1),
            flown.drag_estimate.reshape(count, -1),
        ],
        axis=1,
    )
    told = _core.spatial_recorded(
        _core.SpatialFrame(**frame), row, np.ascontiguousarray(table), complete
    )
    result = {
        **told,
        "status": "finished" if complete else "left",
        "culprit": -1,
        "end_time": float(flown.t[-1]),
    }
    return SpatialRun(calm, law, result)


def _rotor_speeds(scenario: SpatialScenario, flown: Measured) -> Array:
    """Of each vehicle four that give the forces with their lag, shape (rows, n, 4), rad/s."""
    rotors = scenario.vehicle
    wanted = np.sqrt(np.linalg.norm(flown.force, axis=2) / (4.0 * rotors.thrust_coefficient))
    wanted = np.clip(wanted, rotors.rotor_speed_min, rotors.rotor_speed_max)
    speed = wanted.copy()
    for k, step in enumerate(np.diff(flown.t)):
        part = -np.expm1(-step / rotors.rotor_time_constant)
        speed[k + 1] = speed[k] + part * (wanted[k] - speed[k])
    return np.repeat(speed[:, :, None], 4, axis=2)
