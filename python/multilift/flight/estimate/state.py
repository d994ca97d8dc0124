"""What the estimator says: every value with its age, its quality and the reason for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum

from multilift.flight.mocap.frames import Quaternion, Vector


class Quality(IntEnum):
    """What a value is good for; the greater, the better, so that `min` is the worst of many."""

    NONE = 0
    """Never seen: the values are zero and mean nothing."""
    LOST = 1
    """Last seen longer ago than extrapolation reaches: the values are as far as it does."""
    SUSPECT = 2
    """Unseen for longer than extrapolation is sound, or seen under another's name."""
    COASTING = 3
    """Nothing to take in from the last frame; extrapolated, as long as that is sound."""
    CONVERGING = 4
    """Seen, but not long enough for velocity and rate to be sound."""
    GOOD = 5
    """Seen, consistent, recent."""


class Fault(Enum):
    """Why a quality is not GOOD."""

    NONE = "none"
    UNSEEN = "unseen"
    """No frame has had this body yet."""
    STARTING = "starting"
    """Too little time since the first frame."""
    SILENT = "silent"
    """No frames come."""
    FROZEN = "frozen"
    """Frames come, but say the same again: poses to the last bit, or the time of capture."""
    DROPPED = "dropped"
    """Frames come without this body, or with values that are no numbers."""
    JUMP = "jump"
    """Poses that this body cannot have reached."""
    SWAPPED = "swapped"
    """Poses come under another body's name; they are taken in where they belong."""
    CLOCK = "clock"
    """Capture times do not go with the times of arrival."""


@dataclass(frozen=True, slots=True)
class Standing:
    """How far to trust a value.

    Attributes:
        quality: what it is good for.
        fault: why it is not GOOD; NONE where it is.
        since: when this fault was first seen, `time.monotonic()`, s; the time of asking where
            there is none.
        age: since the capture of the last pose that went into the value, s; infinite where
            none did.
    """

    quality: Quality
    fault: Fault
    since: float
    age: float

    @property
    def usable(self) -> bool:
        """Whether a set-point may be computed from it: seen before, and not too long ago."""
        return self.quality >= Quality.SUSPECT


@dataclass(frozen=True, slots=True)
class BodyState:
    """One body, extrapolated to the time that was asked for.

    Attributes:
        standing: how far to trust all of it.
        position: of the body's origin, world axes, m.
        velocity: world axes, m/s.
        acceleration: world axes, m/s^2; noisier by far than the velocity.
        attitude: unit quaternion, scalar first, body to world.
        rate: angular, body axes, rad/s.
        position_sigma: standard deviation of each component of the position, m.
        velocity_sigma: the same of the velocity, m/s.
    """

    standing: Standing
    position: Vector
    velocity: Vector
    acceleration: Vector
    attitude: Quaternion
    rate: Vector
    position_sigma: float
    velocity_sigma: float


@dataclass(frozen=True, slots=True)
class CableState:
    """One cable, from the bodies at its ends.

    Attributes:
        standing: the worse of its two bodies'.
        direction: unit vector from the payload's point to the vehicle's, world axes: d_i.
        direction_rate: its derivative, 1/s; at right angles to it.
        swing: between the direction and up, rad.
        swing_along: of the direction from up in the x-z plane, rad: atan2(d_x, d_z).
        swing_across: the same in the y-z plane, rad: atan2(d_y, d_z).
        distance: between the cable's ends, m; less than its length where it is slack.
    """

    standing: Standing
    direction: Vector
    direction_rate: Vector
    swing: float
    swing_along: float
    swing_across: float
    distance: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """Everything at one time.

    Attributes:
        time: that was asked for, `time.monotonic()`, s.
        standing: the worst of all bodies'.
        bodies: by the names in the scenario.
        cables: in the scenario's order.
    """

    time: float
    standing: Standing
    bodies: Mapping[str, BodyState]
    cables: tuple[CableState, ...]
