"""The covariance of a value, its rate and its acceleration, driven by white jerk.

All three axes of a position share one, and so do those of an attitude: their noise is alike and
they are measured together. See Bar-Shalom, Li, Kirubarajan, Estimation with Applications to
Tracking and Navigation, 6.2.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Chain:
    """Entries of the symmetric covariance: value v, rate r, acceleration a."""

    vv: float
    vr: float
    va: float
    rr: float
    ra: float
    aa: float

    @staticmethod
    def unknown(noise: float, rate: float, acceleration: float) -> Chain:
        """Where the value was measured once and the others are only bounded, all as sigmas."""
        return Chain(noise**2, 0.0, 0.0, rate**2, 0.0, acceleration**2)

    def after(self, dt: float, jerk: float) -> Chain:
        """The covariance dt seconds on, under white jerk of this strength."""
        q, half = jerk * jerk, 0.5 * dt * dt
        vr = self.vr + dt * self.rr + half * self.ra
        va = self.va + dt * self.ra + half * self.aa
        ra = self.ra + dt * self.aa
        return Chain(
            self.vv + dt * (self.vr + vr) + half * (self.va + va) + q * dt**5 / 20,
            vr + dt * va + q * dt**4 / 8,
            va + q * dt**3 / 6,
            self.rr + dt * (self.ra + ra) + q * dt**3 / 3,
            ra + q * dt**2 / 2,
            self.aa + q * dt,
        )

    def gains(self, noise: float) -> tuple[float, float, float]:
        """What part of an innovation goes into value, rate and acceleration."""
        s = self.vv + noise * noise
        return self.vv / s, self.vr / s, self.va / s

    def measured(self, noise: float) -> Chain:
        """The covariance once the value is measured."""
        v, r, a = self.gains(noise)
        return replace(
            self,
            vv=self.vv * (1 - v),
            vr=self.vr * (1 - v),
            va=self.va * (1 - v),
            rr=self.rr - r * self.vr,
            ra=self.ra - r * self.va,
            aa=self.aa - a * self.va,
        )

    def spread(self, noise: float) -> float:
        """Standard deviation of an innovation."""
        return math.sqrt(self.vv + noise * noise)
