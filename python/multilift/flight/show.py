"""A ground station as a snapshot, for those who show it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from multilift.flight.estimate.state import Quality
from multilift.flight.snapshot import (
    CaptureShown,
    Happening,
    Margin,
    PayloadShown,
    Snapshot,
    Timing,
    VehicleShown,
)
from multilift.flight.station import Station, tilt
from multilift.flight.supervisor import Seen, State, Word
from multilift.flight.supervisor.states import WAYS, Event
from multilift.flight.supervisor.trouble import checks, separation
from multilift.flight.timing import LoopTimes

#: How many lines of each kind are shown.
_SAID = 3
_HAPPENINGS = 12

#: What the pilot may say to make something happen, in the order in which it is shown.
_WORDS = {
    Event.START_WORD: Word.START,
    Event.GO_WORD: Word.GO,
    Event.HOLD_WORD: Word.HOLD,
    Event.LAND_WORD: Word.LAND,
    Event.KILL: Word.KILL,
}


def snapshot_of(station: Station, now: float, began: float) -> Snapshot | None:
    """Everything of a station as of its last tick; None before the first.

    Args:
        station: looked at.
        now: s.
        began: when the program did, s.
    """
    estimate, seen, orders = station.estimate, station.seen, station.orders
    if estimate is None or seen is None or orders is None:
        return None
    lab, supervisor = station.lab, station.supervisor
    state = supervisor.state
    words = [word.value for event, word in _WORDS.items() if event in WAYS[state]]
    if state is State.PREFLIGHT and orders.problems:
        words.remove(Word.GO.value)
    checking = state in (State.PREFLIGHT, State.ARMED)
    listed = [(c.trouble or c.name, not c.trouble) for c in checks(seen, lab.limits)]
    standing = estimate.standing
    counts = station.estimator.counts
    log = station.log
    return Snapshot(
        now - began,
        lab.title or lab.name,
        lab.scenario.name,
        lab.is_twin,
        state.value,
        supervisor.lasted,
        tuple(words),
        orders.problems,
        tuple(listed) if checking else (),
        tuple(_vehicle(station, k, now) for k in range(len(station.links))),
        _payload(station),
        CaptureShown(
            _finite(standing.age),
            standing.quality.name.lower(),
            "" if standing.quality is Quality.GOOD else standing.fault.value,
            counts["new"],
            {name: number for name, number in counts.items() if name != "new"},
        ),
        tuple(_margins(station, seen)),
        timing_of(station.times),
        tuple(_happenings(station, began)),
        "" if log is None else str(log.path),
        0 if log is None else log.dropped,
    )


def timing_of(times: LoopTimes) -> Timing:
    """What a loop has measured, as it is shown."""
    latency = times.latency
    return Timing(
        times.rate,
        times.late.count,
        times.missed,
        times.late.quantile(0.5),
        times.late.most,
        times.work.quantile(0.5),
        times.work.most,
        latency.quantile(0.5) if latency.count else None,
        latency.quantile(0.999) if latency.count else None,
    )


def _vehicle(station: Station, k: int, now: float) -> VehicleShown:
    link, lab = station.links[k], station.lab.vehicles[k]
    estimate, orders, wanted = station.estimate, station.orders, station.wanted
    assert estimate is not None
    assert orders is not None
    body, status, cable = estimate.bodies[f"vehicle_{k + 1}"], link.status, estimate.cables[k]
    slack = station.pulls.slack[k]
    error = None
    if wanted is not None:
        error = _finite(math.dist(wanted.vehicle[k].tolist(), body.position))
    steered = wanted is not None
    return VehicleShown(
        f"vehicle_{k + 1}", lab.system, lab.firmware, _finite(link.age(now)), status.armed,
        link.peer.firmware.mode_name(status.mode) if status.mode >= 0 else "unknown",
        status.failsafe, status.landed, _finite(status.voltage), _finite(status.charge),
        orders.vehicles[k].value, body.position, body.velocity, body.attitude, error,
        tilt(body.attitude), station.commanded[k] if steered else None,
        link.thrust.to_command(station.commanded[k])[0] if steered else None,
        None if slack else _finite(cable.swing), 0.0 if slack else station.pulls.tension[k],
        tuple(text.text for text in list(link.texts.said)[-_SAID:]), dict(link.guard.dropped),
    )  # fmt: skip


def _payload(station: Station) -> PayloadShown:
    assert station.estimate is not None
    body = station.estimate.bodies["payload"]
    wanted = station.wanted
    if wanted is None or wanted.payload is None:
        return PayloadShown(body.position, body.attitude, None, None)
    x, y, z = wanted.payload.tolist()
    error = _finite(math.dist((x, y, z), body.position))
    return PayloadShown(body.position, body.attitude, (x, y, z), error)


def _margins(station: Station, seen: Seen) -> Iterator[Margin]:
    limits, vehicles = station.lab.limits, seen.vehicles
    for name, value, unit in (
        ("tilt", max(v.tilt for v in vehicles), "rad"),
        ("swing", seen.swing, "rad"),
        ("speed", max(v.speed for v in vehicles), "m/s"),
        ("saturation", max(v.saturated for v in vehicles), "s"),
        ("state_age", seen.state_age, "s"),
        ("mocap_age", seen.mocap_age, "s"),
        ("link_age", max(v.link_age for v in vehicles), "s"),
        ("round_trip", max(v.round_trip for v in vehicles), "s"),
    ):
        yield _margin(name, value, float(getattr(limits, name)), unit)
    apart, least = separation(seen), limits.separation
    known = math.isfinite(apart)
    yield Margin("separation", _finite(apart), least, "m",
                 min(least / max(apart, 1e-9), 9.0) if known else None)  # fmt: skip
    inside = min(
        min(x - low, high - x)
        for v in vehicles
        for x, low, high in zip(v.position, limits.fence_low, limits.fence_high, strict=True)
    )
    # Half of what the fence is wide is as far as one can be from it.
    half = 0.5 * min(
        high - low for low, high in zip(limits.fence_low, limits.fence_high, strict=True)
    )
    yield Margin("fence", _finite(inside), 0.0, "m", max(1.0 - inside / half, 0.0))


def _margin(name: str, value: float, limit: float, unit: str) -> Margin:
    known = math.isfinite(value)
    return Margin(name, _finite(value), limit, unit, min(value / limit, 9.0) if known else None)


def _happenings(station: Station, began: float) -> Iterator[Happening]:
    for time, state, event, why in station.supervisor.told[-_HAPPENINGS:]:
        bad = event in (Event.TROUBLE, Event.TOO_LONG, Event.KILL)
        text = state.value if event is Event.DONE else f"{state.value}: {event.value}"
        text += f": {why}" if bad and why else ""
        yield Happening(time - began, text, bad)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
