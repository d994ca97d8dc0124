"""The figure of a bound: its move beside the same move under laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from multilift.limit.bound import Bound
from multilift.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(bound: Bound, beside: Sequence[Run] = ()) -> Figure:
    """The model's overview of the bound's run and the laws', with the bound as a line.

    Args:
        bound: whose check is drawn, held at the goal after the move.
        beside: runs of the same scenario.
    """
    figure = bound.scenario.model.overview([bound.run, *beside])
    for ax in figure.axes:
        if ax.get_xlim()[1] > bound.time:
            ax.axvline(bound.time, color="0.4", lw=0.8, ls=":")
    settled = [run.metrics["combined_settling"] for run in beside]
    # What comes after everything has settled would squeeze the move into a corner.
    if beside and all(map(math.isfinite, settled)):
        end = 1.15 * max(bound.time, *settled)
        for ax in figure.axes:
            ax.set_xlim(0.0, min(ax.get_xlim()[1], end))
    return figure
