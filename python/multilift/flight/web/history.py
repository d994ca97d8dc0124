"""The last half minute of a flight, for plots and trails."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from multilift.flight.snapshot import Snapshot, VehicleShown

Array = NDArray[np.float64]

#: How far back it goes, s.
SPAN = 30.0


class History:
    """Snapshots of the last `SPAN` seconds of the flight's clock."""

    def __init__(self) -> None:
        self._kept: deque[Snapshot] = deque()

    def add(self, shown: Snapshot) -> None:
        """Takes the next one; one that is older than the last begins anew."""
        if self._kept and shown.time < self._kept[-1].time:
            self._kept.clear()
        self._kept.append(shown)
        while self._kept[0].time < shown.time - SPAN:
            self._kept.popleft()

    @property
    def ago(self) -> Array:
        """When each was, counted from the last: 0 and less, s, shape (rows,)."""
        times = np.array([s.time for s in self._kept])
        return times - times[-1] if len(times) else times

    def of(self, value: Callable[[Snapshot], float | None]) -> Array:
        """A number of each, NaN where it is not known, shape (rows,)."""
        found = (value(s) for s in self._kept)
        return np.array([math.nan if x is None else float(x) for x in found])

    def of_vehicles(self, value: Callable[[VehicleShown], float | None]) -> Sequence[Array]:
        """A number of each vehicle of each."""
        count = len(self._kept[-1].vehicles) if self._kept else 0
        return [self.of(lambda s, k=k: value(s.vehicles[k])) for k in range(count)]  # type: ignore[misc]

    def trail(self, place: Callable[[Snapshot], Sequence[float]]) -> Array:
        """The ways from each place to the next, shape (rows - 1, 2, 3), m."""
        places = np.array([place(s) for s in self._kept]).reshape(-1, 3)
        return np.stack([places[:-1], places[1:]], axis=1)

    def limit(self, name: str) -> float | None:
        """Of a margin, as the last has it."""
        margins = self._kept[-1].margins if self._kept else ()
        return next((m.limit for m in margins if m.name == name), None)
