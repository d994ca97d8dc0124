"""Set-points for an attitude loop, and what keeps a stale one from being sent."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

#: By how much the squared length of a quaternion may differ from one.
_UNIT = 1e-3


@dataclass(frozen=True)
class SetPoint:
    """What one vehicle shall do next.

    Attributes:
        attitude: body FLU in world ENU, scalar first.
        thrust: along the body's z, N.
        made: when it was computed, s.
        state_time: when what it was computed from was captured, s.
    """

    attitude: tuple[float, float, float, float]
    thrust: float
    made: float
    state_time: float


@dataclass
class Freshness:
    """Decides which set-points may be sent.

    Attributes:
        most_age: of the state that a set-point was computed from, s.
        refused: how many were not sent, by reason.
    """

    most_age: float
    refused: Counter[str] = field(default_factory=Counter)
    _last: float = -math.inf

    def allows(self, point: SetPoint, now: float) -> bool:
        """Whether a set-point may be sent now; each may once."""
        reason = self._reason(point, now)
        if reason:
            self.refused[reason] += 1
            return False
        self._last = point.made
        return True

    def _reason(self, point: SetPoint, now: float) -> str:
        numbers = (*point.attitude, point.thrust, point.made, point.state_time)
        if not all(map(math.isfinite, numbers)):
            return "not finite"
        if abs(sum(c * c for c in point.attitude) - 1.0) > _UNIT:
            return "no attitude"
        if not point.state_time <= point.made <= now:
            return "from the future"
        if now - point.state_time > self.most_age:
            return "stale"
        return "repeated" if point.made <= self._last else ""
