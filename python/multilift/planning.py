"""Moves that leave no swing, planned in microseconds: for a law's own loop, or once for a run.

All works in two coordinates, y and z, or three, x, y and z; the last one is up. A move of the load
from rest to rest takes its vehicles along by flatness (`docs/planning`)::

    limits = planning.Limits(speed=1.5, acceleration=2.0, jerk=8.0, snap=60.0)
    way = planning.move(planning.state([0.0, 0.0]), [1.2, 0.3], limits)
    position, velocity, acceleration, jerk, snap = way.at(0.5).T
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import _core
from multilift.errors import PlanningError

#: The highest power of time in a piece.
DEGREE = 9

#: A move over no distance takes this time, s.
SHORTEST = 1e-3

#: Each coordinate with its first four time derivatives, shape (coordinates, 5).
State = NDArray[np.float64]

#: When, s, and how much of a move comes then.
Impulses = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Limits:
    """What a move keeps to, as sizes of vectors.

    Attributes:
        speed: m/s.
        acceleration: m/s^2.
        jerk: m/s^3.
        snap: m/s^4; infinite for none.
    """

    names: ClassVar[tuple[str, ...]] = ("speed", "acceleration", "jerk", "snap")

    speed: float
    acceleration: float
    jerk: float
    snap: float = math.inf

    def __post_init__(self) -> None:
        for name, value in zip(self.names, self.numbers, strict=True):
            if not value > 0.0:
                raise PlanningError(f"{name} = {value!r} is no limit", "a number above 0")

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """In the order of derivatives."""
        return self.speed, self.acceleration, self.jerk, self.snap


@dataclass(frozen=True)
class Mode:
    """A mode of swing: frequency without damping, rad/s, and damping as a part of the critical."""

    frequency: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        if not (self.frequency > 0.0 and 0.0 <= self.damping < 1.0):
            raise PlanningError(f"{self} does not swing", "frequency > 0 and 0 <= damping < 1")


@dataclass(frozen=True)
class Pendulum:
    """What hangs below vehicles: length, m; gravity, m/s^2; damping of the swing's rate, 1/s."""

    length: float
    gravity: float = 9.81
    damping: float = 0.0

    def __post_init__(self) -> None:
        if not (self.length > 0.0 and self.gravity > 0.0 and self.damping >= 0.0):
            raise PlanningError(f"{self} does not hang", "length > 0, gravity > 0 and damping >= 0")

    @property
    def numbers(self) -> tuple[float, float, float]:
        """As the core takes them."""
        return self.length, self.gravity, self.damping


class Way:
    """A planned way; with no pieces where no move keeps to the limits.

    Attributes:
        end: when it stands still, s; infinite behind a goal that moves.
    """

    def __init__(self, planned: Any) -> None:
        self._planned = planned
        self.end: float = planned.end

    @property
    def pieces(self) -> list[tuple[float, list[list[float]]]]:
        """Start, s, and for each coordinate the coefficients of (t - start)^0 to ^9."""
        return list(self._planned.pieces)

    def at(self, time: float) -> State:
        """Each coordinate with four derivatives, shape (coordinates, 5)."""
        return np.array(self._planned.at(time))


def state(position: ArrayLike, *derivatives: ArrayLike) -> State:
    """A place with as many of its derivatives as are given, the others zero."""
    first = np.asarray(position, dtype=float)
    result = np.zeros((len(first), 5))
    for order, value in enumerate((first, *derivatives)):
        result[:, order] = value
    return result


def move(
    start: State,
    goal: ArrayLike,
    limits: Limits,
    *,
    goal_velocity: ArrayLike | None = None,
    remaining: float = 0.0,
) -> Way:
    """The shortest polynomial move from a state to a goal within limits, in one piece or two.

    From rest to rest its duration has a closed form. From any other state durations are tried in a
    fixed series; where none will do, the move comes to rest first.

    Args:
        start: shape (coordinates, 5).
        goal: shape (coordinates,), m, now.
        limits: of the way's own speed, acceleration, jerk and snap.
        goal_velocity: of a goal that moves evenly, m/s.
        remaining: where the start is on a way planned before, what is left of its time, s: that is
            kept to where the limits permit it, so that a goal that stays leaves the way as it is.

    Raises:
        PlanningError: for numbers that are no state or goal.
    """
    begin, to, velocity = _checked(start, goal, goal_velocity)
    return Way(_way_in(to).move(begin, to, velocity, limits.numbers, remaining))


def timed_move(
    start: State, goal: ArrayLike, duration: float, *, goal_velocity: ArrayLike | None = None
) -> Way:
    """One piece from a state to a goal in a given time, whatever it takes.

    Raises:
        PlanningError: for numbers that are no state, goal or duration.
    """
    _check_duration(duration)
    begin, to, velocity = _checked(start, goal, goal_velocity)
    return Way(_way_in(to).timed(begin, to, velocity, duration))


def least_snap_move(
    start: ArrayLike, goal: ArrayLike, limits: Limits | None = None, duration: float | None = None
) -> Way:
    """The move from rest to rest with the least greatest snap: of constant size, changing its sign.

    Vehicles that carry the moved load jump in acceleration where it does.

    Args:
        start: shape (coordinates,), m.
        goal: likewise.
        limits: of the way's own speed, acceleration, jerk and snap; not read with a duration.
        duration: s; left out: the shortest within the limits.

    Raises:
        PlanningError: for numbers that are no places or duration, or with neither limits nor one.
    """
    begin, to, _ = _checked(state(start), goal, None)
    first = [row[0] for row in begin]
    if duration is None:
        if limits is None:
            raise PlanningError("a move has neither limits nor a duration", "one of them")
        distance = math.dist(first, to)
        duration = max(_core.plan_least_snap_duration(distance, limits.numbers), SHORTEST)
    _check_duration(duration)
    return Way(_way_in(to).least_snap(first, to, duration))


def shaper(kind: str, mode: Mode, tolerance: float = 0.05) -> Impulses:
    """The impulses of an input shaper.

    Args:
        kind: "zv", "zvd" or "ei".
        mode: what it shall not excite.
        tolerance: of "ei": the part of the swing that it leaves where the mode is right.

    Raises:
        PlanningError: for another kind or tolerance.
    """
    if kind not in ("zv", "zvd", "ei"):
        raise PlanningError(f"no shaper is called {kind!r}", "zv, zvd, ei")
    if not 0.0 <= tolerance < 1.0:
        raise PlanningError(f"tolerance = {tolerance!r} is no part", "0 <= tolerance < 1")
    return list(_core.shaper_impulses(kind, mode.frequency, mode.damping, tolerance))


def residual(impulses: Impulses, mode: Mode) -> float:
    """What impulses leave of a mode's swing, as a part of what one alone would."""
    return float(_core.shaper_residual(list(impulses), mode.frequency, mode.damping))


def shaped_move(
    start: ArrayLike,
    goal: ArrayLike,
    limits: Limits,
    impulses: Impulses,
    pendulum: Pendulum,
    *,
    load: bool = True,
) -> Way:
    """The move of vehicles from rest to rest within limits, split into copies by a shaper.

    Args:
        start: shape (coordinates,), m.
        goal: likewise.
        limits: of the vehicles' way.
        impulses: of a :func:`shaper`.
        pendulum: the load below.
        load: whether to give the way that the load takes, or the vehicles'.

    Raises:
        PlanningError: for numbers that are no places.
    """
    begin, to, _ = _checked(state(start), goal, None)
    return Way(
        _way_in(to).shaped(
            [row[0] for row in begin], to, limits.numbers, list(impulses), pendulum.numbers, load
        )
    )


def antiswing_move(
    position: ArrayLike,
    velocity: ArrayLike,
    lean: ArrayLike,
    lean_rate: ArrayLike,
    goal: ArrayLike,
    limits: Limits,
    damping_ratio: float,
    pendulum: Pendulum,
    *,
    goal_velocity: ArrayLike | None = None,
    load: bool = True,
) -> Way:
    """A move in two parts, positioning and one that takes swing away, from any state of swing.

    Args:
        position: of the vehicles, or of the one whose load hangs straight there, m.
        velocity: m/s.
        lean: the unit vector from the load to the vehicles.
        lean_rate: its rate, 1/s.
        goal: where the vehicles shall be, m, now.
        limits: of the vehicles' speed, acceleration and jerk.
        damping_ratio: of the swing, as a part of the critical damping; above 0, below 1.
        pendulum: the load below.
        goal_velocity: of a goal that moves evenly, m/s.
        load: whether to give the way that the load takes, or the vehicles'.

    Raises:
        PlanningError: for numbers that are no state, goal or damping.
    """
    if not 0.0 < damping_ratio < 1.0:
        raise PlanningError(f"damping_ratio = {damping_ratio!r}", "0 < damping_ratio < 1")
    begin, to, moving = _checked(state(position, velocity, lean, lean_rate), goal, goal_velocity)
    columns = [[row[k] for row in begin] for k in range(4)]
    return Way(
        _way_in(to).antiswing(
            *columns, to, moving, limits.numbers, damping_ratio, pendulum.numbers, load
        )
    )


def _way_in(place: list[float]) -> Any:
    """The core's planner for as many coordinates."""
    return _core.PlannedWay2 if len(place) == 2 else _core.PlannedWay3


def _check_duration(duration: float) -> None:
    if not 0.0 < duration < math.inf:
        raise PlanningError(f"duration = {duration!r} is no time", "a number above 0, s")


def _checked(
    start: State, goal: ArrayLike, goal_velocity: ArrayLike | None
) -> tuple[list[list[float]], list[float], list[float]]:
    begin, to = np.asarray(start, dtype=float), np.asarray(goal, dtype=float)
    velocity = np.zeros_like(to) if goal_velocity is None else np.asarray(goal_velocity, float)
    size = begin.shape[0] if begin.ndim == 2 else 0
    if size not in (2, 3) or begin.shape != (size, 5) or to.shape != (size,):
        raise PlanningError(
            f"a start of shape {begin.shape} and a goal of shape {to.shape} do not go together",
            "(2, 5) and (2,), or (3, 5) and (3,)",
        )
    if velocity.shape != to.shape:
        raise PlanningError(f"goal_velocity has the shape {velocity.shape}", f"{to.shape}")
    if not all(np.isfinite(x).all() for x in (begin, to, velocity)):
        raise PlanningError("start, goal or goal_velocity is not finite", "finite numbers")
    return begin.tolist(), to.tolist(), velocity.tolist()
