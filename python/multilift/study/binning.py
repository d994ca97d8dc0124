"""Worlds sorted into bins of one or two varied numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.study.vary import Array, Vary

#: A list or grid of more values than this is binned like a drawn number.
_SHOWN_AS_THEY_ARE = 64


@dataclass(frozen=True)
class Bins:
    """Bins along one varied number.

    Attributes:
        edges: of the bins, one more than there are bins.
        centres: where their value is drawn.
        index: the bin of each world.
    """

    edges: Array
    centres: Array
    index: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.centres)


def bins(varied: Vary, values: Array, wanted: int) -> Bins:
    """Bins for one varied number: its own values where it has few, else equal steps.

    Args:
        varied: what varies.
        values: what each world drew.
        wanted: how many bins for drawn numbers.
    """
    log = _logarithmic(varied)
    if varied.crossed and len(varied.values) <= _SHOWN_AS_THEY_ARE:
        centres = np.array(sorted(varied.values))
        scale = np.log(centres) if log else centres
        gaps = np.diff(scale)
        first, last = (gaps[0], gaps[-1]) if len(gaps) else (1.0, 1.0)
        edges = np.concatenate(
            [[scale[0] - first / 2], 0.5 * (scale[1:] + scale[:-1]), [scale[-1] + last / 2]]
        )
        edges = np.exp(edges) if log else edges
        return Bins(edges, centres, np.searchsorted(edges[1:-1], values, side="right"))
    low, high = float(values.min()), float(values.max())
    if low == high:
        low, high = low - 0.5, high + 0.5
    edges = np.geomspace(low, high, wanted + 1) if log else np.linspace(low, high, wanted + 1)
    centres = np.sqrt(edges[1:] * edges[:-1]) if log else 0.5 * (edges[1:] + edges[:-1])
    return Bins(edges, centres, np.searchsorted(edges[1:-1], values, side="right"))


def is_logarithmic(varied: Vary) -> bool:
    """Whether axes over this number are logarithmic."""
    return _logarithmic(varied)


def shares(index: NDArray[np.intp], count: int, met: NDArray[np.bool_]) -> tuple[Any, Any]:
    """Worlds in each bin, and how many of them `met` marks."""
    return np.bincount(index, minlength=count), np.bincount(index[met], minlength=count)


def grouped_quantiles(
    index: NDArray[np.intp], count: int, values: Array, probabilities: tuple[float, ...]
) -> Array:
    """Quantiles of `values` in each bin, shape (count, probabilities); NaN where none falls.

    No value (NaN) counts as greater than every value.
    """
    result = np.full((count, len(probabilities)), np.nan)
    order = np.argsort(index, kind="stable")
    ordered = np.where(np.isfinite(values), values, np.inf)[order]
    ends = np.searchsorted(index[order], np.arange(count + 1))
    for k in range(count):
        if ends[k] < ends[k + 1]:
            piece = ordered[ends[k] : ends[k + 1]]
            found = np.quantile(piece, probabilities, method="higher")
            result[k] = np.where(np.isfinite(found), found, np.nan)
    return result


def _logarithmic(varied: Vary) -> bool:
    if varied.distribution == "log_uniform":
        return True
    values = np.array(varied.values)
    if len(values) < 3 or values.min() <= 0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.allclose(ratios, ratios[0]) and ratios[0] > 1.0)
