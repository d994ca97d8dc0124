"""What a log says of a flight, as arrays, and the runs that are made of it."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import OutputError, ScenarioError
from multilift.flight import log, record
from multilift.flight.supervisor import State
from multilift.models.spatial.measured import Measured, run_of
from multilift.models.spatial.run import SpatialRun, rotation_matrices
from multilift.models.spatial.scenario import SpatialScenario
from multilift.saved import SavedLaw
from multilift.scenario import Scenario

Array = NDArray[np.float64]

#: Of each body, in the order of a row.
_PARTS = (("position", 3), ("attitude", 4), ("velocity", 3), ("rate", 3))

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
        lab: its tables; empty where the log has none.
        began: time of day at the first row, s.
        t: since then, shape (rows,), s.
        state: of the supervisor.
        course: the scenario's time where its reference is flown, else NaN, shape (rows,), s.
        bodies: payload and vehicles: position, attitude, velocity, rate, shape (rows, 1 + n, 13).
        age: of what each was estimated from, shape (rows, 1 + n), s.
        wanted: attitudes sent to the vehicles; NaN where none, shape (rows, n, 4).
        thrust: sent with them, shape (rows, n), N.
        drag_estimate: of the law, shape (rows, n, 3), N s/m.
        changes: the states in order.
        unread: ticks that were not of numbers, and are left out.
    """

    path: Path
    scenario: SpatialScenario
    lab: Mapping[str, Any]
    began: float
    t: Array
    state: Sequence[str]
    course: Array
    bodies: Array
    age: Array
    wanted: Array
    thrust: Array
    drag_estimate: Array
    changes: Sequence[Change]
    unread: int

    @property
    def complete(self) -> bool:
        """Whether the scenario's whole course was flown."""
        end = float(self.scenario["simulation.duration"])
        return bool(np.nanmax(self.course, initial=-np.inf) >= end - _NEARLY)

    @property
    def force(self) -> Array:
        """What was asked of the rotors, world; 0 where nothing was sent, shape (rows, n, 3), N."""
        rows, n = self.thrust.shape
        up = rotation_matrices(self.wanted.reshape(-1, 4))[:, :, 2].reshape(rows, n, 3)
        return np.nan_to_num(self.thrust[:, :, None] * up)

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
    scenario, lab = _attached(path)
    names = ["payload", *(f"vehicle_{k + 1}" for k in range(scenario.count))]
    rows: list[_Row] = []
    unread = 0
    for entry in log.read(path):
        if entry.topic != record.TOPIC:
            continue
        try:
            row = _row(entry, names)
        except (LookupError, TypeError, ValueError, AttributeError):
            unread += 1
            continue
        if rows and row.time <= rows[-1].time:
            unread += 1
            continue
        rows.append(row)
    if not rows:
        raise OutputError(
            f"{path}: no tick of a flight is in it\n"
            f"  permitted: a log with the topic {record.TOPIC!r}, as 'multilift fly' writes it"
        )
    began = rows[0].time
    t = np.array([(row.time - began) * 1e-9 for row in rows])
    state = [row.state for row in rows]
    return Flown(
        path,
        scenario,
        lab,
        began * 1e-9,
        t,
        state,
        _course(t, state),
        np.array([row.bodies for row in rows]),
        np.array([row.age for row in rows]),
        np.array([row.wanted for row in rows]),
        np.array([row.thrust for row in rows]),
        np.array([row.drag for row in rows]),
        [Change(t[k], state[k], rows[k].problems)
         for k in range(len(rows)) if k == 0 or state[k] != state[k - 1]],
        unread,
    )  # fmt: skip


@dataclass(frozen=True)
class _Row:
    """One tick: time in ns, and numbers as in `Flown`."""

    time: int
    state: str
    bodies: Array
    age: Array
    wanted: Array
    thrust: Array
    drag: Array
    problems: tuple[str, ...]


def _row(entry: log.Entry, names: Sequence[str]) -> _Row:
    data, n = entry.data, len(names) - 1
    bodies = np.array(
        [np.concatenate([_numbers(data["bodies"][name][part], size) for part, size in _PARTS])
         for name in names]
    )  # fmt: skip
    if not np.isfinite(bodies).all():
        raise ValueError("a state is missing")
    lengths = np.linalg.norm(bodies[:, 3:7], axis=1)
    if np.abs(lengths - 1.0).max() > 0.01:
        raise ValueError("an attitude is none")
    bodies[:, 3:7] /= lengths[:, None]
    age = np.array([_number(data["bodies"][name]["age"]) for name in names])
    points = data["set_points"]
    if len(points) != n:
        raise ValueError("set-points of another team")
    nothing = {"attitude": [None] * 4, "thrust": None}
    wanted = np.array([_numbers((p or nothing)["attitude"], 4) for p in points])
    thrust = np.array([_number((p or nothing)["thrust"]) for p in points])
    drag = data.get("drag_estimate")
    learnt = np.zeros((n, 3)) if drag is None else np.array([_numbers(d, 3) for d in drag])
    if learnt.shape != (n, 3) or not np.isfinite(learnt).all():
        raise ValueError("a drag estimate is none")
    problems = tuple(str(problem) for problem in data.get("problems", ()))
    return _Row(entry.time, str(data["state"]), bodies, age, wanted, thrust, learnt, problems)


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)


def _numbers(values: Any, size: int) -> Array:
    array = np.array([_number(value) for value in values])
    if array.shape != (size,):
        raise ValueError("another number of numbers")
    return array


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


def _attached(path: Path) -> tuple[SpatialScenario, Mapping[str, Any]]:
    """The scenario and the lab's tables."""
    files = log.attachments(path)
    if record.SCENARIO not in files:
        raise OutputError(
            f"{path}: no {record.SCENARIO} is attached to it\n"
            "  permitted: a log of 'multilift fly', damaged at its end at most"
        )
    try:
        scenario = Scenario(tomllib.loads(files[record.SCENARIO]), f"{path}:{record.SCENARIO}")
        lab = tomllib.loads(files.get(record.LAB, ""))
    except tomllib.TOMLDecodeError as error:
        raise OutputError(f"{path}: what is attached to it is no TOML: {error}") from None
    if not isinstance(scenario, SpatialScenario):
        raise ScenarioError("is not of vehicles in space", where=scenario.where, key="plant.model")
    return scenario, lab
