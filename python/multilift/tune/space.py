"""What tuning varies: a box of numbers, seen as the unit cube by those that search it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift.scenario import Scenario
from multilift.study.draws import transform
from multilift.study.vary import Array, Vary

#: Significant digits of a tuned number: files that people read, and no sharper than any gain is.
DIGITS = 4


@dataclass(frozen=True)
class Space:
    """Numbers between bounds, uniform or uniform in their logarithms.

    Attributes:
        varied: each "uniform" or "log_uniform".
        digits: significant digits to which numbers are rounded; None for none.
    """

    varied: Sequence[Vary]
    digits: int | None = DIGITS

    @classmethod
    def of_ranges(cls, ranges: Mapping[str, tuple[float, float]]) -> Space:
        """Numbers that set no keys themselves, uniform in their logarithms, not rounded."""
        return cls(
            [Vary(name, name, "", (), "set", "log_uniform", low=low, high=high)
             for name, (low, high) in ranges.items()],
            digits=None,
        )  # fmt: skip

    @property
    def dimensions(self) -> int:
        """How many numbers."""
        return len(self.varied)

    def numbers(self, unit: Array) -> dict[str, Array]:
        """The numbers at points of the unit cube, shape (N, dimensions), by name, N each."""
        return {v.name: self._number(v, unit[:, k]) for k, v in enumerate(self.varied)}

    def unit(self, numbers: Mapping[str, float]) -> Array:
        """The point of the unit cube at which numbers lie; what is outside is moved to its edge."""
        point = []
        for v in self.varied:
            x = float(np.clip(numbers[v.name], v.low, v.high))
            share = (
                np.log(x / v.low) / np.log(v.high / v.low)
                if v.distribution == "log_uniform"
                else (x - v.low) / (v.high - v.low)
            )
            point.append(float(np.clip(share, 0.0, 1.0)))
        return np.array(point)

    def overrides(self, scenario: Scenario, numbers: Mapping[str, Array]) -> dict[str, Array]:
        """The scenario keys that numbers set, as `multilift.simulate_batch` takes them."""
        result: dict[str, Array] = {}
        for v in self.varied:
            result |= v.overrides(scenario, numbers[v.name])
        return result

    def _number(self, varied: Vary, share: NDArray[np.float64]) -> Array:
        x = transform(varied, np.asarray(share))
        if self.digits is not None:
            x = np.array([float(f"{value:.{self.digits - 1}e}") for value in x])
        return np.asarray(np.clip(x, varied.low, varied.high), dtype=float)
