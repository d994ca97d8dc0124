"""How an autopilot's clock lies beside ours, from TIMESYNC exchanges.

A sample is ``offset = (sent + received) / 2 - theirs``, true to half the time of its way there and
back. It converges when enough samples agree; a jump of the other clock begins it anew.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from statistics import median

#: Samples kept, of which the quickest quarter are believed.
_KEPT = 40

#: How many there must be.
_ENOUGH = 10

#: Longest way there and back that says anything, s.
_SLOW = 0.1

#: How far the believed samples may lie apart, s: a radio's jitter. A pose that is stamped so far
#: off is a few millimetres off.
_AGREE = 0.005

#: So many samples in a row beyond `_JUMP` and the other clock was set anew.
_JUMPS = 5
_JUMP = 0.05


@dataclass
class ClockSync:
    """Estimate of one autopilot's clock.

    Attributes:
        resets: how often the other clock jumped.
    """

    resets: int = 0
    _samples: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_KEPT))
    _beyond: int = 0

    def sees(self, sent: float, theirs: float, received: float) -> None:
        """Takes in one exchange.

        Args:
            sent: by our clock, s.
            theirs: by their clock when they answered, s.
            received: by our clock, s.
        """
        way = received - sent
        if not 0.0 <= way <= _SLOW:
            return
        offset = 0.5 * (sent + received) - theirs
        known = self.offset
        if known is not None and abs(offset - known) > _JUMP:
            self._beyond += 1
            if self._beyond < _JUMPS:
                return
            self._samples.clear()
            self.resets += 1
        self._beyond = 0
        self._samples.append((way, offset))

    def _believed(self) -> list[float]:
        quickest = sorted(self._samples, key=lambda s: s[0])[: max(len(self._samples) // 4, 3)]
        return [offset for _way, offset in quickest]

    @property
    def offset(self) -> float | None:
        """Our clock less theirs, s; None before the first exchange."""
        return median(self._believed()) if self._samples else None

    @property
    def is_converged(self) -> bool:
        """Whether enough exchanges agree."""
        if len(self._samples) < _ENOUGH:
            return False
        believed = self._believed()
        return max(believed) - min(believed) <= _AGREE

    @property
    def quickest(self) -> float | None:
        """Least time there and back, s."""
        return min(self._samples)[0] if self._samples else None

    def to_theirs(self, ours: float) -> float | None:
        """A time of ours by their clock, s; None until it is converged."""
        offset = self.offset if self.is_converged else None
        return None if offset is None else ours - offset
