"""What counts as trouble.

Every comparison is written so that a value that is no number fails it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from multilift.flight.lab import Limits
from multilift.flight.supervisor.seen import Seen, VehicleSeen
from multilift.flight.supervisor.states import FLYING, State

#: Beyond these nothing that we send helps a vehicle: past level by far, or this far outside, m.
_OVERTURNED = math.radians(100.0)
_FLOWN_AWAY = 1.5


def outside(vehicle: VehicleSeen, limits: Limits) -> float:
    """How far a vehicle is beyond the fence, m; 0 within."""
    beyond = [
        max(low - x, x - high) if math.isfinite(x) else math.inf
        for x, low, high in zip(vehicle.position, limits.fence_low, limits.fence_high, strict=True)
    ]
    return max(0.0, *beyond)


def is_fresh(seen: Seen, limits: Limits) -> bool:
    """Whether set-points may be computed and sent now."""
    return 0.0 <= seen.state_age <= limits.state_age


def is_blind(seen: Seen, limits: Limits) -> bool:
    """Whether motion capture is not to be believed."""
    return bool(seen.mocap_fault) or not 0.0 <= seen.mocap_age <= limits.mocap_age


def separation(seen: Seen) -> float:
    """Least distance between two vehicles, m; infinite for one, not a number where unknown."""
    pairs = itertools.combinations((v.position for v in seen.vehicles), 2)
    distances = [math.dist(a, b) for a, b in pairs]
    return math.nan if any(map(math.isnan, distances)) else min(distances, default=math.inf)


def is_past_saving(vehicle: VehicleSeen, seen: Seen, limits: Limits) -> bool:
    """Whether cutting a vehicle's thrust is better than leaving it; only on good evidence."""
    if is_blind(seen, limits) or not vehicle.armed:
        return False
    finite = all(map(math.isfinite, (*vehicle.position, vehicle.tilt)))
    return finite and (vehicle.tilt > _OVERTURNED or outside(vehicle, limits) > _FLOWN_AWAY)


@dataclass(frozen=True)
class Check:
    """One pre-flight check.

    Attributes:
        name: what is looked at.
        trouble: what speaks against arming, in words; "" where it is passed.
    """

    name: str
    trouble: str


def checks(seen: Seen, limits: Limits) -> Iterator[Check]:
    """All pre-flight checks."""
    captured = "; ".join(_captured(seen, limits))
    yield Check("motion capture", captured)
    for k, v in enumerate(seen.vehicles, 1):
        told = [
            ("heartbeat", not 0.0 <= v.link_age <= limits.link_age, "no heartbeat"),
            ("round trip", not v.round_trip <= limits.round_trip, "link too slow"),
            ("disarmed", v.armed, "is armed already"),
            ("takes set-points", not v.follows, "does not take set-points yet"),
            ("no failsafe", v.failsafe, "is in a failsafe"),
            ("on the ground", v.landed is False, "is not on the ground"),
            ("battery", not v.charge >= limits.battery, "battery low"),
            ("inside the fence", outside(v, limits) > 0.0, "outside the fence"),
            ("level", not v.tilt <= limits.tilt, "not level"),
        ]
        for name, is_so, text in told:
            yield Check(f"vehicle {k}: {name}", f"vehicle {k}: {text}" if is_so else "")
        told_by_link = "; ".join(f"vehicle {k}: {text}" for text in v.problems)
        yield Check(f"vehicle {k}: parameters and clock", told_by_link)
    close = not separation(seen) > limits.separation
    yield Check("separation", "vehicles too close" if close else "")


def before_flight(seen: Seen, limits: Limits) -> Iterator[str]:
    """What speaks against arming, in words."""
    return (check.trouble for check in checks(seen, limits) if check.trouble)


def in_flight(seen: Seen, limits: Limits, state: State, boots: tuple[int, ...]) -> Iterator[str]:
    """What is wrong now, in words.

    Args:
        seen: now.
        limits: of the lab.
        state: what is being done: landing, vehicles may disarm and leave our mode.
        boots: how often each had begun anew when it was armed.
    """
    yield from _captured(seen, limits)
    if not is_fresh(seen, limits):
        yield "state too old for set-points"
    in_air = state in FLYING
    for k, (v, before) in enumerate(zip(seen.vehicles, boots, strict=True), 1):
        told = [
            (not 0.0 <= v.link_age <= limits.link_age, "link lost"),
            (not v.round_trip <= limits.round_trip, "link too slow"),
            (v.boots != before, "began anew"),
            (v.failsafe, "is in a failsafe"),
            (in_air and not v.armed, "disarmed"),
            (in_air and not v.follows, "left our mode"),
            (not v.tilt <= limits.tilt, "tilted"),
            (not v.speed <= limits.speed, "too fast"),
            (in_air and not v.saturated <= limits.saturation, "at its limit of thrust"),
            (outside(v, limits) > 0.0, "outside the fence"),
        ]
        yield from (f"vehicle {k}: {text}" for is_so, text in told if is_so)
    if in_air and not seen.swing <= limits.swing:
        yield "load swings too far"
    if not separation(seen) >= limits.separation:
        yield "vehicles too close"


def makes_hold_useless(seen: Seen, limits: Limits) -> bool:
    """Whether holding cannot help: nothing can be sent in time, or someone does not follow."""
    lost = any(
        not v.round_trip <= limits.round_trip
        or not (v.follows and v.armed and 0.0 <= v.link_age <= limits.link_age)
        for v in seen.vehicles
    )
    close = not separation(seen) >= limits.separation
    return lost or close or is_blind(seen, limits) or not is_fresh(seen, limits)


def _captured(seen: Seen, limits: Limits) -> Iterator[str]:
    if seen.mocap_fault:
        yield f"motion capture: {seen.mocap_fault}"
    if not 0.0 <= seen.mocap_age <= limits.mocap_age:
        yield "motion capture: lost"
