"""How an autopilot comes down by itself: level, at a steady rate, held against drift if it sees."""

from __future__ import annotations

import math
from dataclasses import dataclass

from multilift.flight.link.frames import Quaternion

#: Of an autopilot's landing, m/s, and how it corrects its rate, 1/s and 1/s^2 of hover thrust.
_RATE = 0.5
_PROPORTIONAL = 0.15
_INTEGRAL = 0.15

#: Lean against horizontal velocity, rad per m/s, and at most.
_DAMPING = 0.12
_MOST_LEAN = 0.25


@dataclass
class Descent:
    """Set-points of a vehicle that is on its own.

    Attributes:
        thrust: normalised, that holds it as far as it knows.
        rate: wanted upward speed, m/s.
    """

    thrust: float
    rate: float = -_RATE
    _sum: float = 0.0

    def step(
        self,
        attitude: Quaternion,
        velocity: tuple[float, float, float] | None,
        climb: float,
        elapsed: float,
    ) -> tuple[Quaternion, float]:
        """The attitude and normalised thrust for the next moment.

        Args:
            attitude: now, body FLU in world ENU; its heading stays.
            velocity: world, m/s; None where nothing tells it.
            climb: upward speed by the barometer, m/s.
            elapsed: since the last step, s.
        """
        error = self.rate - climb
        self._sum = min(max(self._sum + _INTEGRAL * error * elapsed, -0.6), 0.6)
        thrust = self.thrust * (1.0 + _PROPORTIONAL * error + self._sum)
        east, north = (0.0, 0.0) if velocity is None else velocity[:2]
        lean = [max(-_MOST_LEAN, min(-_DAMPING * v, _MOST_LEAN)) for v in (east, north)]
        return leaning(attitude, *lean), min(max(thrust, 0.0), 1.0)


def leaning(attitude: Quaternion, east: float, north: float) -> Quaternion:
    """The heading of an attitude with its thrust leaned by small angles, rad."""
    w, x, y, z = attitude
    half = 0.5 * math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    c, s = math.cos(half), math.sin(half)
    # The tilt (1, -north/2, east/2, 0) after the heading (c, 0, 0, s).
    a, b = -0.5 * north, 0.5 * east
    length = math.sqrt(1.0 + a * a + b * b)
    return (c / length, (a * c + b * s) / length, (b * c - a * s) / length, s / length)
