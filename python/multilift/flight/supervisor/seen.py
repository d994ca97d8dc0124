"""What the supervisor is told at each step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

Vector = tuple[float, float, float]


class Word(Enum):
    """What the pilot can say."""

    START = "start"
    GO = "go"
    HOLD = "hold"
    LAND = "land"
    KILL = "kill"


@dataclass(frozen=True)
class VehicleSeen:
    """One vehicle, as its link and motion capture show it.

    Attributes:
        link_age: since its last heartbeat, s.
        armed: whether it says that it is.
        follows: whether it is in the mode that takes our set-points.
        failsafe: whether it says that it is in one.
        landed: what it believes; None while unknown.
        position: world, m.
        speed: m/s.
        tilt: of its thrust axis from the vertical, rad.
        saturated: how long its command has lain on a bound, s.
        charge: of its battery, 0 to 1.
        boots: how often it has begun anew.
        problems: what else speaks against arming, in words.
        round_trip: to it and back, s.
    """

    link_age: float
    armed: bool
    follows: bool
    failsafe: bool
    landed: bool | None
    position: Vector
    speed: float
    tilt: float
    saturated: float = 0.0
    charge: float = 1.0
    boots: int = 0
    problems: tuple[str, ...] = ()
    round_trip: float = 0.0


@dataclass(frozen=True)
class Seen:
    """Everything at one instant.

    Attributes:
        vehicles: in the lab's order.
        mocap_age: of the oldest last pose of any body, s.
        mocap_fault: what is wrong with motion capture besides its age, in words; "" if nothing.
        state_age: of what set-points are computed from now, s.
        swing: largest angle of a cable, rad.
        done: whether the plan of the present state has been flown.
        word: what the pilot says now.
    """

    vehicles: tuple[VehicleSeen, ...]
    mocap_age: float = math.inf
    mocap_fault: str = ""
    state_age: float = math.inf
    swing: float = 0.0
    done: bool = False
    word: Word | None = None
