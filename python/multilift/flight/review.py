"""What a flight was like, from its log alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.flight.log import read
from multilift.flight.supervisor import State

Array = NDArray[np.float64]

#: What counts as still, rad, and as there, m: as the metrics of simulated runs have it.
STILL = math.radians(1.0)
THERE = 0.02


@dataclass(frozen=True)
class Flown:
    """The part of a flight in which the scenario's law flew its reference.

    Attributes:
        t: since its beginning, shape (m,), s.
        vehicle: positions by motion capture, shape (m, n, 3), m.
        payload: shape (m, 3), m.
        vehicle_wanted: shape (m, n, 3), m.
        payload_wanted: shape (m, 3), m.
        swing: of each cable from the vertical, shape (m, n), rad.
        tension: as estimated, shape (m, n), N.
    """

    t: Array
    vehicle: Array
    payload: Array
    vehicle_wanted: Array
    payload_wanted: Array
    swing: Array
    tension: Array


@dataclass(frozen=True)
class Review:
    """A flight.

    Attributes:
        states: that it went through, with the times at which they began, s.
        troubles: what was wrong in the air, in words, each once.
        flown: with the load, by the scenario; None if it did not come to that.
        separation: least distance between two vehicles while any was armed, m.
        timing: what the loop last said of itself; empty without.
        records: how many.
    """

    states: tuple[tuple[float, str], ...]
    troubles: tuple[str, ...]
    flown: Flown | None
    separation: float
    timing: Mapping[str, Any]
    records: int

    @property
    def is_regular(self) -> bool:
        """Whether it took the whole course and had no trouble on the way."""
        names = [name for _time, name in self.states]
        return State.LAND.value in names and not self.troubles and names[-1] == State.IDLE.value


def review(path: Path) -> Review:
    """Reads a log.

    Raises:
        OutputError: if the file cannot be read.
    """
    states: list[tuple[float, str]] = []
    troubles: dict[str, None] = {}
    rows: list[tuple[float, Any, Any]] = []
    timing: Mapping[str, Any] = {}
    separation, records, first = math.inf, 0, None
    estimate: Any = None
    supervisor: Any = None
    for entry in read(path):
        records += 1
        first = entry.time if first is None else first
        time = (entry.time - first) * 1e-9
        if entry.topic == "estimate":
            estimate = entry.data
        elif entry.topic == "supervisor":
            supervisor = entry.data
            if not states or states[-1][1] != supervisor["state"]:
                states.append((time, supervisor["state"]))
            if any(supervisor["armed"]) and estimate is not None:
                separation = min(separation, _least_distance(estimate))
                troubles |= dict.fromkeys(supervisor["problems"])
        elif entry.topic == "wanted" and supervisor["state"] == State.FLY.value:
            rows.append((supervisor["lasted"], estimate, entry.data))
        elif entry.topic == "timing":
            timing = entry.data
    flown = _flown(rows) if rows else None
    return Review(tuple(states), tuple(troubles), flown, separation, timing, records)


def metrics(flown: Flown) -> dict[str, float]:
    """Numbers of the part that the scenario's law flew; SI, swing in degrees.

    Those that end in ``_after`` are the time since its beginning from which on something holds to
    its end, infinite if it never does.
    """
    worst = flown.swing.max(axis=1)
    off = np.linalg.norm(flown.vehicle - flown.vehicle_wanted, axis=2).max(axis=1)
    load = np.linalg.norm(flown.payload - flown.payload_wanted, axis=1)
    last = flown.vehicle_wanted[-1], flown.payload_wanted[-1]
    far = np.linalg.norm(flown.vehicle - last[0], axis=2).max(axis=1)
    load_far = np.linalg.norm(flown.payload - last[1], axis=1)
    return {
        "peak_swing": math.degrees(float(worst.max())),
        "still_after": settled(flown.t, worst, STILL),
        "vehicles_there_after": settled(flown.t, far, THERE),
        "payload_there_after": settled(flown.t, load_far, THERE),
        "vehicles_off_at_end": float(off[-1]),
        "payload_off_at_end": float(load[-1]),
        "least_tension": float(flown.tension.min()),
        "greatest_tension": float(flown.tension.max()),
    }


def settled(t: Array, value: Array, bound: float) -> float:
    """From when on a value stays within a bound, s; infinite if it ends outside."""
    beyond = np.flatnonzero(value > bound)
    if beyond.size == 0:
        return float(t[0])
    return float(t[beyond[-1] + 1]) if beyond[-1] + 1 < t.size else math.inf


def _least_distance(estimate: Any) -> float:
    places = [b[:3] for name, b in estimate["bodies"].items() if name != "payload"]
    return min((math.dist(a, b) for a, b in itertools.combinations(places, 2)), default=math.inf)


def _flown(rows: list[tuple[float, Any, Any]]) -> Flown:
    names = [name for name in rows[0][1]["bodies"] if name != "payload"]
    return Flown(
        np.array([t for t, _e, _w in rows]),
        np.array([[e["bodies"][name][:3] for name in names] for _t, e, _w in rows]),
        np.array([e["bodies"]["payload"][:3] for _t, e, _w in rows]),
        np.array([w["vehicle"] for _t, _e, w in rows]),
        np.array([w["payload"] for _t, _e, w in rows]),
        np.array([e["swing"] for _t, e, _w in rows]),
        np.array([e["tension"] for _t, e, _w in rows]),
    )
