"""The capture system's clock against ours.

A frame arrives later than it was captured by the clocks' offset and a latency that varies. The
least difference so far, raised by no more than clocks drift apart, is the offset with the least
latency. A frame that arrives earlier than that by more than the slack shows a clock that went
ahead, and so do times that went back; either is believed once it has lasted. A frame that is only
late was held up, and however long that lasts it stays late: what is old must never look new.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

#: How fast two quartz clocks drift apart at most.
_DRIFT = 2e-4

#: Frames in a row after which a clock has jumped, besides the time.
_LEAST_FRAMES = 5


@dataclass(slots=True)
class _Run:
    """Frames in a row whose times fit one another but not what was before."""

    start: float
    difference: float
    count: int = 1


class CaptureClock:
    """Where the capture clock stands.

    Attributes:
        offset: arrival minus capture at its least, s.
    """

    def __init__(self, slack: float, patience: float) -> None:
        self._slack = slack
        self._patience = patience
        self.offset = math.nan
        self._capture = -math.inf
        self._received = -math.inf
        self._run: _Run | None = None

    def fits(self, capture: float, received: float) -> bool:
        """Whether a frame's times go with the clock; learns from them."""
        difference = received - capture
        if math.isnan(self.offset):
            self._set(difference, capture, received)
            return True
        expected = self.offset + _DRIFT * (received - self._received)
        early = difference < expected - self._slack
        late = difference > expected + self._slack
        if not (early or late):
            self._run = None
            self._set(min(difference, expected), max(capture, self._capture), received)
            return True
        run = self._run
        if run is not None and abs(difference - run.difference) <= self._slack:
            run.count += 1
            run.difference = min(run.difference, difference)
        else:
            jumped = early or capture < self._capture
            self._run = _Run(received, difference) if jumped else None
        return False

    def jumped(self, capture: float, received: float) -> float | None:
        """By how much the capture clock went ahead, if it did; the clock is then set anew."""
        run = self._run
        if run is None or run.count < _LEAST_FRAMES or received - run.start < self._patience:
            return None
        ahead = self.offset - run.difference
        self._set(run.difference, capture, received)
        self._run = None
        return ahead

    def _set(self, offset: float, capture: float, received: float) -> None:
        self.offset, self._capture, self._received = offset, capture, received
