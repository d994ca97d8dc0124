"""The payload's way to its goal, as polynomials in time relative to the goal.

A piece is (start, coefficients of x, y, z, yaw), coefficients of (t - start)^0 to ^9, in m and rad.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import planning, splines
from multilift.errors import MissingExtraError, ScenarioError
from multilift.models.references import needed, waypoints
from multilift.splines import Piece

Array = NDArray[np.float64]

#: From 0 to 1 with velocity, acceleration and jerk zero at both ends: the least snap there is.
_REST_TO_REST = np.array([0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0, 0.0, 0.0])

#: Between two samples of a curve that no polynomial is, s.
_SAMPLE = 0.05


def pieces(values: dict[str, Any], where: str) -> tuple[list[Piece], float]:
    """A scenario's path and when it ends, s; no pieces for a step.

    Raises:
        ScenarioError: for a reference that lacks what its kind needs.
        MissingExtraError: without SciPy or Ruckig where the kind needs them.
    """
    kind = values["reference"]["kind"]
    return _KINDS[kind](values, where)


def _offset(values: dict[str, Any]) -> Array:
    """Start less goal: x, y, z, yaw."""
    start, goal = values["start"], values["goal"]
    position = np.array(start["payload_position"]) - np.array(goal["payload_position"])
    return np.append(position, start["payload_yaw"] - goal["payload_yaw"])


def _step(_: dict[str, Any], __: str) -> tuple[list[Piece], float]:
    return [], 0.0


def _min_snap(values: dict[str, Any], where: str) -> tuple[list[Piece], float]:
    duration = needed(values["reference"], "duration", where)
    start = values["reference"]["start"]
    shape = -_REST_TO_REST / duration ** np.arange(planning.DEGREE + 1)
    shape[0] += 1.0
    moved = np.outer(_offset(values), shape)
    return splines.wait([(start, moved.tolist())]), start + duration


def _jerk_limited(values: dict[str, Any], where: str) -> tuple[list[Piece], float]:
    try:
        from ruckig import (  # noqa: PLC0415
            InputParameter,
            Ruckig,
            Trajectory,
        )
    except ImportError:
        raise MissingExtraError("ruckig", "plan", "a jerk-limited reference") from None
    offset = _offset(values)
    reference = values["reference"]
    distance = float(np.linalg.norm(offset[:3]))
    if distance == 0.0:
        raise ScenarioError(
            "is the start, so that there is no way to take",
            where=where,
            key="goal.payload_position",
            value=values["goal"]["payload_position"],
            advice="move it, or use another kind of reference",
        )
    problem = InputParameter(1)
    problem.current_position, problem.target_position = [0.0], [distance]
    problem.max_velocity = [reference["speed_max"]]
    problem.max_acceleration = [reference["acceleration_max"]]
    problem.max_jerk = [reference["jerk_max"]]
    found = Trajectory(1)
    Ruckig(1).calculate(problem, found)
    profile = found.profiles[0][0]
    way: list[Piece] = []
    time = reference["start"]
    for k, length in enumerate(profile.t):
        if length <= 0.0:
            continue
        # The way left, from 1 to 0, as a cubic.
        left = -np.array([profile.p[k], profile.v[k], profile.a[k] / 2, profile.j[k] / 6])
        left = left / distance
        left[0] += 1.0
        rows = np.outer(offset, np.append(left, np.zeros(planning.DEGREE - 3)))
        way.append((time, rows.tolist()))
        time += length
    return splines.wait(way), time


def _waypoints(values: dict[str, Any], where: str) -> tuple[list[Piece], float]:
    goal = np.append(values["goal"]["payload_position"], values["goal"]["payload_yaw"])
    time, way = waypoints(values["reference"], _offset(values), goal, "x, y, z, yaw", where)
    return _spline(values, time, way)


def _around(curve: Callable[[Array, float], Array]) -> Callable[..., tuple[list[Piece], float]]:
    def build(values: dict[str, Any], where: str) -> tuple[list[Piece], float]:
        duration = needed(values["reference"], "duration", where)
        reference = values["reference"]
        if np.abs(_offset(values)).max() > 1e-9:
            raise ScenarioError(
                "is not the start",
                where=where,
                key="goal.payload_position",
                value=values["goal"]["payload_position"],
                permitted=f"{values['start']['payload_position']}, with the start's heading",
                advice="a way around begins and ends at one place",
            )
        time = np.linspace(0.0, duration, max(round(duration / _SAMPLE), 16) + 1)
        part = np.polynomial.polynomial.polyval(time / duration, _REST_TO_REST)
        angle = 2.0 * np.pi * reference["laps"] * part
        plane = curve(angle, reference["radius"])
        flat = np.zeros((len(time), 2))
        return _spline(values, time, np.hstack([plane, flat]))

    return build


def _circle(angle: Array, radius: float) -> Array:
    return radius * np.stack([np.cos(angle) - 1.0, np.sin(angle)], axis=1)


def _figure_eight(angle: Array, length: float) -> Array:
    """Gerono's lemniscate from its crossing."""
    return length * np.stack([np.sin(angle), np.sin(angle) * np.cos(angle)], axis=1)


def _spline(values: dict[str, Any], time: Array, way: Array) -> tuple[list[Piece], float]:
    """Through all points with the least snap, at rest at both ends: a spline of degree 7."""
    start = values["reference"]["start"]
    result = [(start + begin, rows) for begin, rows in splines.least_snap(time, way)]
    return splines.wait(result), start + float(time[-1])


_KINDS: dict[str, Callable[[dict[str, Any], str], tuple[list[Piece], float]]] = {
    "step": _step,
    "min_snap": _min_snap,
    "jerk_limited": _jerk_limited,
    "waypoints": _waypoints,
    "circle": _around(_circle),
    "figure_eight": _around(_figure_eight),
}
