"""A tuning's figures: the flight before and after, progress, sensitivity, the front."""

from __future__ import annotations

import io
import itertools

import numpy as np

from multilift.plot import RC
from multilift.study.vary import Array
from multilift.tune.judge import TOLERATED, Side, Slice
from multilift.tune.search import Found

from matplotlib import rc_context  # isort: skip - after multilift.plot, which says what is missing
from matplotlib.axis import Axis  # isort: skip
from matplotlib.figure import Figure  # isort: skip
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # isort: skip

_AFTER, _SETS = "#0072B2", "#B9C7CF"


def png(figure: Figure) -> bytes:
    """A figure as the pages hold it."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def progress(found: Found) -> Figure:
    """The first objective of every set, and of the best so far."""
    goal = found.tuning.goal
    objective = goal.objectives[0]
    values = goal.values(found.figures)[:, 0]
    allowed = np.where(goal.violations(found.figures) == 0, values, np.nan)
    best = objective.sign * np.fmin.accumulate(objective.sign * allowed)
    with rc_context(RC):
        figure = Figure(figsize=(5.6, 2.6), layout="constrained")
        ax = figure.subplots()
        count = np.arange(1, len(values) + 1)
        ax.plot(count, values, ".", markersize=2, color=_SETS, label="each set", rasterized=True)
        ax.plot(count, best, color=_AFTER, label="best so far that keeps the constraints")
        ax.set_xlabel("sets of numbers flown")
        ax.set_ylabel(_axis(objective.metric, objective.unit))
        if np.isfinite(values).any() and np.nanmin(values) > 0:
            ax.set_yscale("log")
            _plain_ticks(ax.yaxis)
        ax.legend(loc="upper right")
    return figure


def slices(found: Found, slices: list[Slice]) -> Figure:
    """The first objective along each number."""
    objective = found.tuning.goal.objectives[0]
    columns = min(3, len(slices))
    rows = -(-len(slices) // columns)
    labels = {v.name: v.label for v in found.tuning.space.varied}
    logarithmic = {v.name: v.distribution == "log_uniform" for v in found.tuning.space.varied}
    own = found.numbers(found.best)
    with rc_context(RC):
        figure = Figure(figsize=(2.3 * columns + 0.4, 1.9 * rows), layout="constrained")
        axes = np.ravel(figure.subplots(rows, columns, sharey=True, squeeze=False))
        for ax, one in zip(axes, slices, strict=False):
            ax.axvspan(one.low, one.high, color="#E4EDF3", linewidth=0)
            ax.plot(one.numbers, one.values, ".-", markersize=3, color=_AFTER)
            ax.axvline(own[one.name], color="black", linewidth=0.6, linestyle=":")
            ax.set_xlabel(labels[one.name])
            if logarithmic[one.name]:
                ax.set_xscale("log")
                _plain_ticks(ax.xaxis)
        for ax in axes[len(slices) :]:
            ax.set_axis_off()
        figure.supylabel(_axis(objective.metric, objective.unit), fontsize=8)
    return figure


def front(found: Found) -> Figure:
    """Sets of which none is better in all objectives, for each pair of these."""
    goal = found.tuning.goal
    values = goal.values(found.figures)
    allowed = goal.violations(found.figures) == 0
    chosen = found.front()
    pairs = list(itertools.combinations(range(len(goal.objectives)), 2))
    with rc_context(RC):
        figure = Figure(figsize=(3.4 * len(pairs) + 0.6, 3.2), layout="constrained")
        for ax, (a, b) in zip(np.ravel(figure.subplots(1, len(pairs))), pairs, strict=True):
            ax.plot(values[allowed, a], values[allowed, b], ".", markersize=2, color=_SETS,
                    rasterized=True, label="each set")  # fmt: skip
            order = chosen[np.argsort(values[chosen, a])]
            line = "-" if len(pairs) == 1 else ""
            ax.plot(values[order, a], values[order, b], "." + line, color=_AFTER, label="front")
            ax.plot(*values[found.best, [a, b]], "o", markersize=6, markerfacecolor="none",
                    color="black", label="the compromise")  # fmt: skip
            for axis, k in ((ax.xaxis, a), (ax.yaxis, b)):
                axis.set_label_text(_axis(goal.objectives[k].metric, goal.objectives[k].unit))
                near = _near(values[chosen, k])
                (ax.set_xlim if axis is ax.xaxis else ax.set_ylim)(*near)
            ax.legend(loc="upper right")
    return figure


def flights(before: Side, after: Side) -> Figure:
    """The scenario's flight before and after, until both have settled."""
    runs = [before.run, after.run]
    figure = before.scenario.model.overview(runs)
    settled = [run.metrics.get("combined_settling", np.nan) for run in runs]
    if np.isfinite(settled).all():
        for ax in figure.axes:
            ax.set_xlim(0.0, min(ax.get_xlim()[1], 1.15 * max(settled)))
    return figure


def tolerated() -> str:
    """The share by which an objective may become worse in a shaded range."""
    return f"{100 * TOLERATED:.0f} %"


def _near(values: Array) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    room = max(high - low, 1e-9 + 0.02 * abs(high))
    return low - 0.15 * room, high + 0.6 * room


def _axis(metric: str, unit: str) -> str:
    return metric.replace("_", " ") + (f" ({unit})" if unit else "")


def _plain_ticks(axis: Axis) -> None:
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_formatter(NullFormatter())
