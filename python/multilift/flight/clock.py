"""The clock of all processes of a flight: the system's monotonic one, or that times a speed."""

from __future__ import annotations

import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Clock:
    """A clock that every process of this machine reads alike.

    Attributes:
        speed: how many of its seconds a real one has; 1 with hardware.
    """

    speed: float = 1.0

    def now(self) -> float:
        """Its time, s."""
        return time.monotonic() * self.speed

    def of(self, monotonic: float) -> float:
        """Its time when the system's monotonic clock said so, s."""
        return monotonic * self.speed

    def real(self, seconds: float) -> float:
        """How long so many of its seconds really take, s."""
        return seconds / self.speed
