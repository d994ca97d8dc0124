"""The bar's way to its goal, as polynomials in time relative to where it hangs there.

A piece is (start, coefficients of y and z), coefficients of (t - start)^0 to ^9, in m. Vehicles,
cables and forces follow from it in the core (`control/planar/reference.hpp`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import _core, planning, splines
from multilift.errors import ScenarioError
from multilift.models.planar import geometry, swing_mode
from multilift.models.references import waypoints
from multilift.planning import Limits, Pendulum, State
from multilift.splines import Piece

Array = NDArray[np.float64]
#: Positions and rates below this count as none: round-off of starts that are worked out.
_NOTHING = 1e-9


@dataclass(frozen=True)
class Problem:
    """What a way is planned from.

    Attributes:
        values: the scenario's tables.
        where: the scenario, for errors.
        assumed: the plant as whoever plans believes it to be, in the core's order.
        start: the bar relative to its goal, with its velocity, and what the mean lean of the cables
            and its rate make of its acceleration and jerk, at rest vertically.
        lean: the mean lean of the cables from the vertical, rad, positive towards +y at the top.
        lean_rate: rad/s.
    """

    values: dict[str, Any]
    where: str
    assumed: list[float]
    start: State
    lean: float
    lean_rate: float

    @property
    def reference(self) -> dict[str, Any]:
        """The table [reference]."""
        table: dict[str, Any] = self.values["reference"]
        return table

    @property
    def limits(self) -> Limits:
        """The limits that the scenario gives."""
        return Limits(*(self.reference[f"{name}_max"] for name in Limits.names))

    @property
    def rests(self) -> bool:
        """Whether nothing moves at the start."""
        return bool(np.abs(self.start[:, 1:]).max() < _NOTHING)


def pieces(
    values: dict[str, Any],
    plant: list[float],
    assumed: list[float],
    q: Array,
    q_dot: Array,
    where: str,
) -> tuple[list[Piece], float]:
    """A scenario's way and when it ends, s; no pieces for a step.

    Args:
        values: normalised tables.
        plant: the plant's numbers in the core's order.
        assumed: the same as whoever plans believes them to be.
        q: the seven coordinates at the start.
        q_dot: their rates.
        where: for errors.

    Raises:
        ScenarioError: for a reference that lacks what its kind needs, or that cannot be planned.
        MissingExtraError: without SciPy where the kind needs it.
    """
    reference = values["reference"]
    if reference["kind"] == "step":
        return [], 0.0
    if reference["damping"]:
        _require_smooth(values, where)
    problem = _problem(values, plant, assumed, q, q_dot, where)
    if reference["start"] > 0.0 and not problem.rests:
        raise ScenarioError(
            "is later than the run's start, at which the load moves",
            where=where,
            key="reference.start",
            value=reference["start"],
            permitted="0, or a start at rest",
        )
    way, end = _KINDS[reference["kind"]](problem)
    if reference["start"] == 0.0:
        return way, end
    later = [(reference["start"] + begin, rows) for begin, rows in way]
    return splines.wait(later), reference["start"] + end


def _require_smooth(values: dict[str, Any], where: str) -> None:
    """Of a way that counts damping: its snap gives the cables' rate, and the law no drag twice."""
    kind = values["reference"]["kind"]
    if kind not in ("flat", "waypoints"):
        raise ScenarioError(
            "needs a way whose snap does not jump",
            where=where,
            key="reference.damping",
            value=True,
            permitted="with reference.kind flat or waypoints",
            advice=f"leave it out with {kind}",
        )
    if np.any(np.array(values["controller"].get("d_hat_start", 0.0)) != 0.0):
        raise ScenarioError(
            "would count the drag twice: the law's estimate begins with some already",
            where=where,
            key="reference.damping",
            value=True,
            permitted="with controller.d_hat_start = 0",
        )


def _problem(
    values: dict[str, Any],
    plant: list[float],
    assumed: list[float],
    q: Array,
    q_dot: Array,
    where: str,
) -> Problem:
    goal = np.array(values["goal"]["vehicle_position"])
    if max(map(abs, geometry.goal_mismatch(values["plant"], goal))) > 1e-6:
        raise ScenarioError(
            "breaks (17): no way with a level bar leads there",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
            permitted="y2 - y1 = plant.bar_length and z1 - l1 = z2 - l2",
            advice='mend the goal, or set reference.kind = "step"',
        )
    gravity = values["controller"]["assumed"]["gravity"]
    if gravity <= 0.0:
        raise ScenarioError(
            "lets no load hang",
            where=where,
            key="plant.gravity",
            value=gravity,
            permitted="> 0 m/s^2",
            advice='set reference.kind = "step"',
        )
    at_goal = np.concatenate([goal.ravel(), np.zeros(3)])
    target = np.array(_core.planar_free_coordinates(plant, at_goal.tolist(), [0.0] * 7))
    now = np.array(_core.planar_free_coordinates(plant, q.tolist(), q_dot.tolist()))
    lean, rate = 0.5 * (q[5] - q[4]), 0.5 * (q_dot[5] - q_dot[4])
    start = np.zeros((2, 5))
    start[:, 0] = now[0:2] - target[0:2]
    start[:, 1] = now[5:7]
    start[0, 2] = gravity * math.tan(lean)
    start[0, 3] = gravity * rate / math.cos(lean) ** 2
    start[np.abs(start) < _NOTHING] = 0.0
    return Problem(values, where, assumed, start, lean, rate)


def _require_rest(problem: Problem) -> None:
    if not problem.rests:
        raise ScenarioError(
            "does not begin with a load that moves",
            where=problem.where,
            key="reference.kind",
            value=problem.reference["kind"],
            permitted="a start at rest",
            advice='use "flat" or "antiswing"',
        )


def _result(problem: Problem, way: planning.Way) -> tuple[list[Piece], float]:
    if not way.pieces:
        raise ScenarioError(
            "cannot be kept: the start's own motion exceeds a limit, or is bound to",
            where=problem.where,
            key="reference",
            value={f"{n}_max": problem.reference[f"{n}_max"] for n in Limits.names},
            advice="raise the limits or start with less swing",
        )
    return list(way.pieces), way.end


def _flat(problem: Problem) -> tuple[list[Piece], float]:
    duration = problem.reference["duration"]
    goal = np.zeros(2)
    if problem.reference["points"]:
        return _jumping(problem)
    if duration is not None:
        return _result(problem, planning.timed_move(problem.start, goal, duration))
    return _result(problem, planning.move(problem.start, goal, problem.limits))


def _jumping(problem: Problem) -> tuple[list[Piece], float]:
    """Towards each goal from where the way is when it is told; limits hold across jumps."""
    goal = np.array(problem.values["goal"]["vehicle_position"][0])
    told, goals = waypoints(problem.reference, problem.start[:, 0], goal, "y and z", problem.where)
    _require_rest(problem)
    if problem.reference["duration"] is not None:
        raise ScenarioError(
            "does not go with goals that jump",
            where=problem.where,
            key="reference.duration",
            value=problem.reference["duration"],
            permitted="left out, where reference.points are given",
        )
    way: list[Piece] = []
    now, end = problem.start, 0.0
    for begin, until, place in zip(told[1:], [*told[2:], np.inf], goals[1:], strict=True):
        toward, end = _result(problem, planning.move(now, place, problem.limits))
        still: Piece = (end, [[x, *[0.0] * planning.DEGREE] for x in place])
        way += [(float(begin) + t, rows) for t, rows in [*toward, still] if begin + t < until]
        if np.isfinite(until):
            now = planning.move(now, place, problem.limits).at(until - begin)
        end += float(begin)
    return splines.wait(way), end


def _least_snap(problem: Problem) -> tuple[list[Piece], float]:
    _require_rest(problem)
    way = planning.least_snap_move(
        problem.start[:, 0], np.zeros(2), problem.limits, problem.reference["duration"]
    )
    return _result(problem, way)


def _shaped(problem: Problem) -> tuple[list[Piece], float]:
    _require_rest(problem)
    mode = _mode(problem)
    impulses = planning.shaper(problem.reference["kind"], mode, problem.reference["tolerance"])
    way = planning.shaped_move(
        problem.start[:, 0], np.zeros(2), problem.limits, impulses, _pendulum(problem, mode)
    )
    return _result(problem, way)


def _antiswing(problem: Problem) -> tuple[list[Piece], float]:
    mode = _mode(problem)
    pendulum = _pendulum(problem, mode)
    d = np.array([math.sin(problem.lean), math.cos(problem.lean)])
    d_dot = problem.lean_rate * np.array([d[1], -d[0]])
    top = problem.start[:, 0] + pendulum.length * (d - [0.0, 1.0])
    velocity = problem.start[:, 1] + pendulum.length * d_dot
    way = planning.antiswing_move(
        top, velocity, d, d_dot, np.zeros(2), problem.limits,
        problem.reference["damping_ratio"], pendulum,
    )  # fmt: skip
    return _result(problem, way)


def _mode(problem: Problem) -> planning.Mode:
    goal = np.array(problem.values["goal"]["vehicle_position"])
    return swing_mode.of_held_vehicles(problem.assumed, goal)


def _pendulum(problem: Problem, mode: planning.Mode) -> Pendulum:
    """The one that swings as the load does below vehicles that are held."""
    gravity = problem.values["controller"]["assumed"]["gravity"]
    return Pendulum(gravity / mode.frequency**2, gravity, 2.0 * mode.damping * mode.frequency)


def _waypoints(problem: Problem) -> tuple[list[Piece], float]:
    goal = np.array(problem.values["goal"]["vehicle_position"][0])
    time, way = waypoints(problem.reference, problem.start[:, 0], goal, "y and z", problem.where)
    _require_rest(problem)
    return splines.least_snap(time, way), float(time[-1])


_KINDS: dict[str, Callable[[Problem], tuple[list[Piece], float]]] = {
    "flat": _flat,
    "least_snap": _least_snap,
    "zv": _shaped,
    "zvd": _shaped,
    "ei": _shaped,
    "antiswing": _antiswing,
    "waypoints": _waypoints,
}
