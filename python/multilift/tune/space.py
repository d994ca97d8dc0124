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
        if self.digits is not None:
            # A factor's product has all the digits of a double: files are for people to read.
            result = {key: _rounded(x, self.digits + 1) for key, x in result.items()}
        return result

    def _number(self, varied: Vary, share: NDArray[np.float64]) -> Array:
        x = transform(varied, np.asarray(share))
        if self.digits is not None:
            x = _rounded(x, self.digits)
        return np.asarray(np.clip(x, varied.low, varied.high), dtype=float)


def _rounded(x: Array, digits: int) -> Array:
    """To significant digits, each the double nearest to its decimal number."""
    flat = [float(f"{value:.{digits - 1}e}") for value in np.ravel(x)]
    return np.reshape(np.array(flat, dtype=float), np.shape(x))
