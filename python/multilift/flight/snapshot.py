"""All that a screen shows of a flight, at one instant: for the terminal, a web page, the log.

A snapshot is numbers, texts and tuples of them, made by the flight loop and read by whoever shows
it: `to_dict` and `from_dict` carry it between processes as JSON. What the pilot says goes the other
way, as a `multilift.flight.supervisor.Word`.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from typing import Any, TypeVar

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
_Record = TypeVar("_Record")


@dataclass(frozen=True)
class VehicleShown:
    """One vehicle; world ENU, body FLU, SI and radians. Numbers that are not known are None.

    Attributes:
        name: its name in the scenario, "vehicle_1", ...
        system: its MAVLink id.
        firmware: "px4" or "ardupilot".
        link_age: since its last heartbeat, s.
        armed: whether it says so.
        mode: in words.
        failsafe: whether it says that it is in one.
        landed: what it believes.
        voltage: of its battery, V.
        charge: of its battery, 0 to 1.
        order: what the supervisor wants of it, in words.
        position: by motion capture.
        velocity: by motion capture.
        attitude: by motion capture, scalar first.
        error: from where the plan wants it, m.
        tilt: of its thrust axis from the vertical.
        thrust: asked for by the last set-point, N.
        command: the same as the normalised thrust on the wire.
        swing: of its cable from the vertical; None where the cable is slack.
        tension: of its cable, from thrust and motion, N.
        said: the last texts of the autopilot, newest last.
        dropped: messages of its link that were refused, by reason.
    """

    name: str
    system: int
    firmware: str
    link_age: float | None
    armed: bool
    mode: str
    failsafe: bool
    landed: bool | None
    voltage: float | None
    charge: float | None
    order: str
    position: Vector
    velocity: Vector
    attitude: Quaternion
    error: float | None
    tilt: float
    thrust: float | None
    command: float | None
    swing: float | None
    tension: float | None
    said: tuple[str, ...]
    dropped: Mapping[str, int]


@dataclass(frozen=True)
class PayloadShown:
    """The load.

    Attributes:
        position: by motion capture, m.
        attitude: by motion capture, scalar first.
        target: where the plan wants it, m; None while it stands.
        error: between the two, m.
    """

    position: Vector
    attitude: Quaternion
    target: Vector | None
    error: float | None


@dataclass(frozen=True)
class CaptureShown:
    """Motion capture.

    Attributes:
        age: of the oldest last pose of any body, s.
        quality: of the worst body, in words.
        fault: why it is not good; "" where it is.
        frames: taken in so far.
        refused: frames that were not taken in, by reason.
    """

    age: float | None
    quality: str
    fault: str
    frames: int
    refused: Mapping[str, int]


@dataclass(frozen=True)
class Margin:
    """How near something is to the limit that ends the flight.

    Attributes:
        name: of the limit in the lab file.
        value: now.
        limit: of the lab file.
        unit: of both.
        used: 0 far from it, 1 at it; None while it is not watched.
    """

    name: str
    value: float | None
    limit: float
    unit: str
    used: float | None


@dataclass(frozen=True)
class Timing:
    """The loop, since it began; times in s.

    Attributes:
        rate: that it is to keep, Hz.
        ticks: done.
        missed: periods in which there was no tick.
        late_median, late_most: from when a tick was due to when it began.
        work_median, work_most: how long a tick took.
        latency_median, latency_999: from capture to the command, and what 99.9 % do not pass;
            None before the first command.
    """

    rate: float
    ticks: int
    missed: int
    late_median: float
    late_most: float
    work_median: float
    work_most: float
    latency_median: float | None
    latency_999: float | None


@dataclass(frozen=True)
class Happening:
    """Something worth a line: a state that began, an order that was refused.

    Attributes:
        time: since the start of the program, s.
        text: in words.
        bad: whether it is trouble.
    """

    time: float
    text: str
    bad: bool


@dataclass(frozen=True)
class Snapshot:
    """Everything at one instant.

    Attributes:
        time: since the start of the program, s.
        title: of the lab.
        scenario: name of what is flown.
        twin: whether nothing is real.
        state: of the supervisor, in words.
        lasted: how long the state has, s.
        words: what the pilot may say now: values of `Word`.
        problems: what speaks against arming, or is wrong in flight.
        checks: the pre-flight checks in words, and whether each is passed; none in the air and
            after a flight.
        vehicles: in the lab's order.
        payload: the load.
        capture: motion capture.
        margins: to the limits.
        timing: of the loop.
        happenings: newest last.
        log: path of the log; "" without.
        unlogged: records that the log could not take.
    """

    time: float
    title: str
    scenario: str
    twin: bool
    state: str
    lasted: float
    words: tuple[str, ...]
    problems: tuple[str, ...]
    checks: tuple[tuple[str, bool], ...]
    vehicles: tuple[VehicleShown, ...]
    payload: PayloadShown
    capture: CaptureShown
    margins: tuple[Margin, ...]
    timing: Timing
    happenings: tuple[Happening, ...]
    log: str
    unlogged: int


def to_dict(snapshot: Snapshot) -> dict[str, Any]:
    """A snapshot as JSON has it."""
    return asdict(snapshot)


def from_dict(values: Mapping[str, Any]) -> Snapshot:
    """What `to_dict` made, back from JSON.

    Raises:
        KeyError: for a part that is missing.
    """
    return _record(Snapshot, values)


def _record(kind: type[_Record], values: Mapping[str, Any]) -> _Record:
    hints = typing.get_type_hints(kind)
    return kind(**{f.name: _value(hints[f.name], values[f.name]) for f in fields(kind)})  # type: ignore[arg-type]


def _value(hint: Any, value: Any) -> Any:
    """Lists become tuples and tables records, as the hint says."""
    if value is None:
        return None
    if isinstance(hint, types.UnionType):
        hint = next(h for h in typing.get_args(hint) if h is not types.NoneType)
    if is_dataclass(hint) and isinstance(hint, type):
        return _record(hint, value)
    if typing.get_origin(hint) is tuple:
        inner = typing.get_args(hint)
        kinds = [inner[0]] * len(value) if inner[-1] is Ellipsis else inner
        return tuple(_value(h, v) for h, v in zip(kinds, value, strict=True))
    return value
