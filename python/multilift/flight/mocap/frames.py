"""What every source of motion capture gives: frames of poses in SI units and our axes.

World axes x east, y north, z up; body axes x forward, y left, z up; quaternions of unit length,
scalar first, that turn a body's coordinates into the world's. A source converts its own units and
axes into these, and nothing behind it converts again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a body is and how it is turned.

    Attributes:
        position: of the body's origin in world axes, m.
        attitude: unit quaternion, scalar first, body to world.
        residual: of the source's fit to the markers, m; NaN where the source gives none.
    """

    position: Vector
    attitude: Quaternion = IDENTITY
    residual: float = math.nan

    @property
    def is_finite(self) -> bool:
        """Whether position and attitude are numbers and the attitude of unit length to 1 %."""
        length = math.hypot(*self.attitude)
        return all(map(math.isfinite, self.position)) and 0.99 < length < 1.01


@dataclass(frozen=True, slots=True)
class Frame:
    """All bodies at one instant.

    Attributes:
        number: the source's count of frames; None where the source gives none.
        capture_time: when the cameras looked, in the source's own clock, s; None where the source
            does not say.
        received_time: when the frame came in here, `time.monotonic()`, s.
        bodies: by the names in our scenario; a body that the source did not see is not in it.
    """

    number: int | None
    capture_time: float | None
    received_time: float
    bodies: Mapping[str, Pose] = field(default_factory=dict)


class Source(Protocol):
    """Where frames come from.

    A source holds a bounded number of frames, and the oldest go first: who reads late reads new.
    """

    #: Frames that were dropped here because nobody read them in time.
    dropped: int
    #: Messages that were not frames, or not whole.
    malformed: int

    async def open(self, timeout: float = 10.0) -> None:
        """Connect, and wait for the first frame for `timeout` seconds.

        Raises:
            CaptureError: no server, no such body, a version that it does not speak, no frame.
        """

    async def next(self) -> Frame:
        """The oldest frame that waits, or the next to come.

        Raises:
            CaptureError: the source ended.
        """

    def drain(self) -> list[Frame]:
        """All frames that wait, oldest first; never waits itself.

        Raises:
            CaptureError: the source ended, and all of its frames have been given.
        """

    async def close(self) -> None:
        """Let go of everything; more than once does no harm."""
