"""What a log says of a flight, as arrays, and the runs that are made of it."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import OutputError, ScenarioError
from multilift.flight import log
from multilift.flight.supervisor import State
from multilift.models.spatial import FlyingLaw
from multilift.models.spatial.measured import Measured, run_of
from multilift.models.spatial.run import SpatialRun
from multilift.models.spatial.scenario import SpatialScenario
from multilift.saved import SavedLaw
from multilift.scenario import Scenario

Array = NDArray[np.float64]

#: Of a body: position, velocity, attitude, rate, as logs have them, in the order of a row here.
_ORDER = [0, 1, 2, 6, 7, 8, 9, 3, 4, 5, 10, 11, 12]

#: What numbers and tables raise that are not what they should be.
_NONSENSE = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError)

#: How much earlier than planned the course of a flight may end: two ticks of the slowest loop, s.
_NEARLY = 0.05


@dataclass(frozen=True)
class Change:
    """A state that began.

    Attributes:
        time: since the log's first tick, s.
        state: in words.
        problems: what was wrong then, in words.
    """

    time: float
    state: str
    problems: tuple[str, ...]


@dataclass(frozen=True)
class Flown:
    """A whole flight, a row a tick.

    Attributes:
        path: of the log.
        scenario: that was to be flown.
        began: time of day at the first row, s.
        t: since then, shape (rows,), s.
        state: of the supervisor.
        course: the scenario's time where its reference is flown, else NaN, shape (rows,), s.
        bodies: payload and vehicles: position, attitude, velocity, rate, shape (rows, 1 + n, 13).
        force: asked of the rotors, world; 0 where nothing was, shape (rows, n, 3), N.
        wanted: attitudes sent to the vehicles; NaN where none, shape (rows, n, 4).
        drag_estimate: of the law, shape (rows, n, 3), N s/m.
        changes: the states in order.
        unread: ticks that were not of numbers, and are left out.
    """

    path: Path
    scenario: SpatialScenario
    began: float
    t: Array
    state: Sequence[str]
    course: Array
    bodies: Array
    force: Array
    wanted: Array
    drag_estimate: Array
    changes: Sequence[Change]
    unread: int

    @property
    def complete(self) -> bool:
        """Whether the scenario's whole course was flown."""
        end = float(self.scenario["simulation.duration"])
        return bool(np.nanmax(self.course, initial=-np.inf) >= end - _NEARLY)

    def course_run(self) -> SpatialRun:
        """The part in which the scenario was flown, on its own time.

        Raises:
            OutputError: if there is none.
        """
        rows = np.flatnonzero(np.isfinite(self.course))
        # After a pause the course goes on where it was: a time is there once.
        rows = rows[np.diff(self.course[rows], prepend=-1.0) > 0.0]
        if len(rows) < 2:
            raise OutputError(
                f"{self.path}: the scenario was not flown; the flight's states: "
                + (", ".join(c.state for c in self.changes) or "none")
            )
        course = self.course[rows]
        return self._run(rows, course, course, "flight", complete=self.complete)

    def whole_run(self) -> SpatialRun:
        """The whole flight on the log's time; before and after its course the targets stand."""
        known = np.where(np.isfinite(self.course), self.course, -1.0)
        planned = np.maximum(np.maximum.accumulate(known), 0.0)
        return self._run(np.arange(len(self.t)), self.t, planned, "whole flight", complete=True)

    def _run(
        self, rows: NDArray[np.intp], t: Array, planned: Array, name: str, *, complete: bool
    ) -> SpatialRun:
        measured = Measured(
            t, planned, self.bodies[rows, 0], self.bodies[rows, 1:], self.force[rows],
            self.drag_estimate[rows],
        )  # fmt: skip
        return run_of(self.scenario, measured, SavedLaw(name.replace(" ", "_"), name),
                      complete=complete)  # fmt: skip


def read(path: Path) -> Flown:
    """The flight that a log holds, as far as it is whole.

    Raises:
        OutputError: if it cannot be read, or is no log of a flight.
    """
    scenario: SpatialScenario | None = None
    ticks: list[_Tick] = []
    unread = 0
    for entry in log.read(path):
        if entry.topic == "lab":
            scenario = _scenario(path, entry.data)
        elif scenario is not None and entry.topic in _TOPICS:
            try:
                _TOPICS[entry.topic](ticks, entry, scenario.count)
            except _NONSENSE:
                unread += 1
    if scenario is None:
        raise OutputError(
            f"{path}: no lab is in it\n  permitted: a log of 'multilift fly', damaged at its end "
            "at most"
        )
    ticks = [tick for tick in ticks if tick.state]
    if not ticks:
        raise OutputError(f"{path}: no tick of a flight is in it")
    return _flown(path, scenario, ticks, unread)


@dataclass
class _Tick:
    """One period of the loop: time in ns, and numbers as in `Flown`."""

    time: int
    bodies: Array
    state: str = ""
    problems: tuple[str, ...] = ()
    force: Array | None = None
    yaw: float = math.nan
    drag: Array | None = None


def _estimate(ticks: list[_Tick], entry: log.Entry, n: int) -> None:
    names = ["payload", *(f"vehicle_{k + 1}" for k in range(n))]
    bodies = _numbers([entry.data["bodies"][name] for name in names], (1 + n, 13))[:, _ORDER]
    lengths = np.linalg.norm(bodies[:, 3:7], axis=1)
    if np.abs(lengths - 1.0).max() > 0.01:
        raise ValueError("an attitude is none")
    if ticks and entry.time <= ticks[-1].time:
        raise ValueError("no later than the last")
    bodies[:, 3:7] /= lengths[:, None]
    ticks.append(_Tick(entry.time, bodies))


def _supervisor(ticks: list[_Tick], entry: log.Entry, n: int) -> None:
    tick = _tick_of(ticks, entry)
    tick.problems = tuple(str(problem) for problem in entry.data["problems"])
    tick.state = str(entry.data["state"])


def _wanted(ticks: list[_Tick], entry: log.Entry, n: int) -> None:
    tick = _tick_of(ticks, entry)
    force, yaw = _numbers(entry.data["force"], (n, 3)), float(entry.data["yaw"])
    learnt = entry.data.get("drag_estimate")
    tick.drag = None if learnt is None else _numbers(learnt, (n, 3))
    if not math.isfinite(yaw):
        raise ValueError("a heading is none")
    tick.force, tick.yaw = force, yaw


#: What reads the records of a topic.
_TOPICS = {"estimate": _estimate, "supervisor": _supervisor, "wanted": _wanted}


def _tick_of(ticks: list[_Tick], entry: log.Entry) -> _Tick:
    if not ticks or ticks[-1].time != entry.time:
        raise ValueError("of no tick")
    return ticks[-1]


def _numbers(values: Any, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=float)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError("no numbers, or not as many")
    return array


def _flown(path: Path, scenario: SpatialScenario, ticks: list[_Tick], unread: int) -> Flown:
    """Ticks as arrays."""
    n, law = scenario.count, FlyingLaw(scenario)
    t = np.array([(tick.time - ticks[0].time) * 1e-9 for tick in ticks])
    state = [tick.state for tick in ticks]
    nothing, none = np.zeros((n, 3)), np.full((n, 4), np.nan)
    return Flown(
        path,
        scenario,
        ticks[0].time * 1e-9,
        t,
        state,
        _course(t, state),
        np.array([tick.bodies for tick in ticks]),
        np.array([nothing if tick.force is None else tick.force for tick in ticks]),
        np.array([none if tick.force is None else law.set_points(tick.force, tick.yaw)[0]
                  for tick in ticks]),
        np.array([nothing if tick.drag is None else tick.drag for tick in ticks]),
        [Change(t[k], state[k], ticks[k].problems)
         for k in range(len(ticks)) if k == 0 or state[k] != state[k - 1]],
        unread,
    )  # fmt: skip


def _course(t: Array, state: Sequence[str]) -> Array:
    """The scenario's time: it runs in FLY, and goes on after a pause where it was."""
    course = np.full(len(t), np.nan)
    flown, begun = 0.0, math.nan
    for k, name in enumerate(state):
        if name != State.FLY.value:
            begun = math.nan
            continue
        if math.isnan(begun):
            begun = t[k] - flown
        flown = course[k] = t[k] - begun
    return course


def _scenario(path: Path, data: Any) -> SpatialScenario:
    """The scenario of a record of the lab."""
    try:
        raw = tomllib.loads(data["scenario"])
    except (RecursionError, *_NONSENSE) as error:
        raise OutputError(f"{path}: the scenario in it cannot be read: {error!r}") from None
    scenario = Scenario(raw, f"{path}: its scenario")
    if not isinstance(scenario, SpatialScenario):
        raise ScenarioError("is not of vehicles in space", where=scenario.where, key="plant.model")
    return scenario
