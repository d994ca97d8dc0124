"""Intervals and quantiles, each from its definition."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: 97.5 % point of the standard normal distribution: intervals hold 95 %.
Z = 1.959963984540054

_REPLICATES = 2000
_BLOCKS = 10_000
_SEED = 20220501


@dataclass(frozen=True)
class Interval:
    """An estimate with its 95 % confidence interval."""

    estimate: float
    low: float
    high: float


def wilson(successes: int, trials: int) -> Interval:
    """A proportion with Wilson's score interval, which stays inside 0 to 1.

    Args:
        successes: of the trials.
        trials: at least one; without any, everything is NaN.
    """
    if trials == 0:
        return Interval(math.nan, math.nan, math.nan)
    p = successes / trials
    shrink = 1.0 + Z * Z / trials
    middle = (p + Z * Z / (2 * trials)) / shrink
    half = Z / shrink * math.sqrt(p * (1 - p) / trials + Z * Z / (4.0 * trials * trials))
    low = 0.0 if successes == 0 else max(0.0, middle - half)
    high = 1.0 if successes == trials else min(1.0, middle + half)
    return Interval(p, low, high)


def paired_mean(differences: Array) -> Interval:
    """The mean of paired differences with its bootstrap percentile interval.

    2000 resamples with a fixed seed. Of more than 10 000 differences, 10 000 random blocks of equal
    size (a few left over) are averaged and resampled, which has the same spread.
    """
    if len(differences) == 0:
        return Interval(math.nan, math.nan, math.nan)
    rng = np.random.default_rng(_SEED)
    values = differences
    if len(values) > _BLOCKS:
        size = len(values) // _BLOCKS
        order = rng.permutation(len(values))[: size * _BLOCKS]
        values = values[order].reshape(_BLOCKS, size).mean(axis=1)
    means = np.array([values[rng.integers(0, len(values), len(values))].mean()
                      for _ in range(_REPLICATES)])  # fmt: skip
    low, high = np.quantile(means, (0.025, 0.975))
    return Interval(float(differences.mean()), float(low), float(high))


def paired_share(only_first: int, only_second: int, both_or_neither: int) -> Interval:
    """The difference of two success rates on the same worlds, with its bootstrap interval.

    Resampling worlds is drawing the three counts from a multinomial distribution, done exactly.
    """
    total = only_first + only_second + both_or_neither
    if total == 0:
        return Interval(math.nan, math.nan, math.nan)
    rng = np.random.default_rng(_SEED)
    shares = np.array([only_first, only_second, both_or_neither]) / total
    counts = rng.multinomial(total, shares / shares.sum(), size=_REPLICATES)
    low, high = np.quantile((counts[:, 0] - counts[:, 1]) / total, (0.025, 0.975))
    return Interval((only_first - only_second) / total, float(low), float(high))


def quantiles(values: Array, probabilities: tuple[float, ...]) -> list[float]:
    """Quantiles where no value counts as greater than every value: NaN where one falls on those."""
    if len(values) == 0:
        return [math.nan] * len(probabilities)
    ordered = np.where(np.isfinite(values), values, np.inf)
    found = np.quantile(ordered, probabilities, method="higher")
    return [float(q) if math.isfinite(q) else math.nan for q in found]
