"""What a loop measures of itself, in bounded memory and time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

#: Bins of a spread: from the first, s, each so much longer than the one before.
_FIRST = 1e-6
_RATIO = 1.02
_BINS = 1024


class Spread:
    """How often which durations came, to 2 %; everything beyond a few minutes is one bin.

    Attributes:
        count: how many.
        most: the longest, s.
    """

    def __init__(self) -> None:
        self.count = 0
        self.most = 0.0
        self._bins = [0] * _BINS

    def add(self, seconds: float) -> None:
        """Counts one; those below a microsecond count as that."""
        self.count += 1
        self.most = max(self.most, seconds)
        place = math.log(max(seconds, _FIRST) / _FIRST) / math.log(_RATIO)
        self._bins[min(int(place), _BINS - 1)] += 1

    def quantile(self, part: float) -> float:
        """What a part of all did not pass, s, to 2 % upwards and at most `most`; 0 without any."""
        wanted, passed = part * self.count, 0
        for place, number in enumerate(self._bins):
            passed += number
            if passed >= wanted and passed:
                return float(min(_FIRST * _RATIO ** (place + 1), self.most))
        return 0.0


@dataclass
class LoopTimes:
    """A loop at a fixed rate.

    Attributes:
        rate: that it is to keep, Hz.
        missed: periods in which nothing began.
        late: from when a tick was due to when it began.
        work: how long a tick took.
        latency: from capture to the command that was computed from it.
    """

    rate: float
    missed: int = 0
    late: Spread = field(default_factory=Spread)
    work: Spread = field(default_factory=Spread)
    latency: Spread = field(default_factory=Spread)

    def ticked(self, due: float, began: float, ended: float) -> float:
        """Counts a tick; what could not begin in its period is left out, not made up for.

        Args:
            due: when it was to begin, s.
            began: when it did, s.
            ended: when it was over, s.

        Returns:
            When the next is due, s.
        """
        period = 1.0 / self.rate
        self.late.add(max(began - due, 0.0))
        self.work.add(ended - began)
        behind = max(math.ceil((ended - due) / period - 1.0), 0)
        self.missed += behind
        return due + (1 + behind) * period
