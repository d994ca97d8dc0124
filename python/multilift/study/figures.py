"""A study's figures: outcomes, distributions, influence of what varies, maps over two numbers."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from multilift.plot import RC, LineStyle, line_styles
from multilift.study import binning
from multilift.study.binning import Bins
from multilift.study.columns import Columns
from multilift.study.spec import Map, Study
from multilift.study.statistics import wilson
from multilift.study.store import Store
from multilift.study.summary import Summary
from multilift.study.vary import Array, Vary

from matplotlib import rc_context  # isort: skip - after multilift.plot, which says what is missing
from matplotlib.figure import Figure  # isort: skip

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MET, _MISSED = "#3B7F5C", "#B9C7BF"
_DIVERGED = "#444444"
#: Of other early ends, in the model's order; the light one is written on in black.
_ENDED = ("#E69F00", "#CC79A7", "#0072B2", "#56B4E9", "#D55E00")
_LIGHT = (_MISSED, "#E69F00", "#56B4E9")


@dataclass(frozen=True)
class Drawing:
    """One figure with its words."""

    stem: str
    title: str
    caption: str
    alt: str
    png: bytes


def draw_all(store: Store, summary: Summary) -> list[Drawing]:
    """Every figure of the report, in its order."""
    columns = Columns(store)
    drawings = [_outcomes(summary), _distributions(columns)]
    wide = [v for v in store.study.vary if not v.crossed or len(v.values) > 1]
    if wide:
        drawings.append(_influence(columns, wide))
    maps = store.study.maps or _default_maps(columns, wide)
    drawings += [_map(columns, m, k) for k, m in enumerate(maps)]
    return drawings


def style(laws: Sequence[str], law: str) -> LineStyle:
    """A law's colour, dash and name, the same as in the figures of runs."""
    return line_styles(laws)[law]


def _png(figure: Figure) -> bytes:
    # Laid out once; savefig would do it again, twice.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def _outcomes(summary: Summary) -> Drawing:
    laws = summary.laws
    names = [law.law for law in laws]
    with rc_context(RC):
        figure = Figure(figsize=(5.6, 0.95 + 0.34 * len(laws)), layout="constrained")
        ax = figure.subplots()
        left = np.zeros(len(laws))
        parts: list[tuple[str, str, list[int]]] = [
            ("success", _MET, [law.successes for law in laws]),
            ("ran to the end, missed a criterion", _MISSED,
             [law.outcomes["finished"] - law.successes for law in laws]),
            *((name.replace("_", " "), colour, [law.outcomes[name] for law in laws])
              for name, colour in _ended(summary.study).items()),
        ]  # fmt: skip
        for label, colour, counts in parts:
            if not any(counts):
                continue
            widths = np.array(counts) / summary.study.worlds
            ax.barh(range(len(laws)), widths, left=left, color=colour, label=label, height=0.62)
            for k, (width, count) in enumerate(zip(widths, counts, strict=True)):
                if width > 0.08:
                    light = colour in _LIGHT
                    ax.text(left[k] + width / 2, k, f"{count:,}", ha="center", va="center",
                            fontsize=7, color="black" if light else "white")  # fmt: skip
            left += widths
        ax.set_yticks(range(len(laws)), [style(names, name).label for name in names])
        ax.invert_yaxis()
        ax.set_xlim(0.0, 1.0)
        ax.set_xlabel("share of worlds")
        ax.grid(False)
        figure.legend(loc="outside upper center", ncols=3, frameon=False, fontsize=7)
        png = _png(figure)
    return Drawing("outcomes", "Outcomes", "How the worlds ended under each law.",
                   "Stacked bars of outcomes, one for each law", png)  # fmt: skip


def _ended(study: Study) -> dict[str, str]:
    """A colour for each way to end early."""
    others = [name for name in study.outcomes[1:] if name != "diverged"]
    colours = dict(zip(others, itertools.cycle(_ENDED), strict=False))
    return {name: colours.get(name, _DIVERGED) for name in study.outcomes[1:]}


def _distributions(columns: Columns) -> Drawing:
    study = columns.study
    metrics = study.metrics
    across = min(len(metrics), 3)
    down = -(-len(metrics) // across)
    with rc_context(RC):
        figure = Figure(figsize=(2.6 * across, 1.9 * down + 0.3), layout="constrained")
        axes = np.ravel(figure.subplots(down, across, squeeze=False, sharey=True))
        for ax, name in zip(axes, metrics, strict=False):
            values = columns.metric(name)
            top = -np.inf
            for k, law in enumerate(study.controllers):
                there = np.sort(values[k][np.isfinite(values[k])])
                if not len(there):
                    continue
                picked = np.unique(np.linspace(0, len(there) - 1, 600).round().astype(int))
                look = style(study.controllers, law)
                ax.plot(there[picked], (picked + 1) / values.shape[1], color=look.colour,
                        ls=look.dash, label=look.label)  # fmt: skip
                top = max(top, there[int(0.995 * (len(there) - 1))])
            if np.isfinite(top):
                low = min(ax.dataLim.x0, top)
                pad = 0.04 * (top - low) or 0.5
                ax.set_xlim(low - pad, top + pad)
            ax.set_xlabel(_axis(study, name))
            ax.set_ylim(0.0, 1.02)
        for ax in axes[len(metrics) :]:
            ax.set_visible(False)
        for ax in axes[::across]:
            ax.set_ylabel("share of worlds")
        handles = {
            t: h for ax in axes for h, t in zip(*ax.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="outside upper center",
                      ncols=len(handles) or 1, frameon=False)  # fmt: skip
        png = _png(figure)
    return Drawing(
        "distributions", "Distributions",
        "Share of all worlds in which the metric is at most the value below. A curve that stays "
        "below 1 leaves out worlds that ended early or have no value. The axis ends where half a "
        "percent of the values lie beyond.",
        "Cumulative distributions of each metric, one curve for each law", png,
    )  # fmt: skip


def _influence(columns: Columns, varied: Sequence[Vary]) -> Drawing:
    study = columns.study
    metrics = study.metrics[:3]
    shown = varied[:8]
    with rc_context(RC):
        figure = Figure(figsize=(max(2.0 * len(shown), 3.6), 1.5 * (1 + len(metrics)) + 0.3),
                        layout="constrained")  # fmt: skip
        axes = figure.subplots(1 + len(metrics), len(shown), squeeze=False, sharex="col",
                               sharey="row")  # fmt: skip
        for column, v in enumerate(shown):
            sorted_in = binning.bins(v, columns.drawn(v), 12)
            for k, law in enumerate(study.controllers):
                look = style(study.controllers, law)
                _success_curve(axes[0, column], sorted_in, columns.success[k], look)
                for row, name in enumerate(metrics, start=1):
                    values = columns.metric(name)[k]
                    _metric_curve(axes[row, column], sorted_in, values[columns.finished[k]],
                                  columns.finished[k], look)  # fmt: skip
            axes[-1, column].set_xlabel(v.label)
            if binning.is_logarithmic(v):
                axes[-1, column].set_xscale("log")
        axes[0, 0].set_ylabel("success rate")
        axes[0, 0].set_ylim(-0.03, 1.03)
        for row, name in enumerate(metrics, start=1):
            axes[row, 0].set_ylabel(_axis(study, name).replace(" (", "\n("))
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels) or 1,
                      frameon=False)  # fmt: skip
        png = _png(figure)
    left_out = f" The first {len(shown)} of {len(varied)} are shown." * (len(varied) > len(shown))
    return Drawing(
        "influence", "What matters",
        "Each column sorts all worlds by one varied number. Top: success rate with its 95 % "
        "interval. Below: median and the middle 90 % over worlds that ran to their end; a curve "
        f"ends where the median world has no value.{left_out}",
        "Success rate and metrics against each varied number, one curve for each law", png,
    )  # fmt: skip


def _success_curve(ax: Any, sorted_in: Bins, met: NDArray[np.bool_], look: LineStyle) -> None:
    worlds, successes_there = binning.shares(sorted_in.index, len(sorted_in), met)
    intervals = [wilson(int(s), int(n)) for s, n in zip(successes_there, worlds, strict=True)]
    x = sorted_in.centres
    ax.plot(x, [i.estimate for i in intervals], color=look.colour, ls=look.dash, label=look.label)
    ax.fill_between(x, [i.low for i in intervals], [i.high for i in intervals],
                    color=look.colour, alpha=0.18, lw=0)  # fmt: skip


def _metric_curve(
    ax: Any, sorted_in: Bins, values: Array, usable: NDArray[np.bool_], look: LineStyle
) -> None:
    q = binning.grouped_quantiles(sorted_in.index[usable], len(sorted_in), values,
                                  (0.05, 0.5, 0.95))  # fmt: skip
    ax.plot(sorted_in.centres, q[:, 1], color=look.colour, ls=look.dash)
    ax.fill_between(sorted_in.centres, q[:, 0], q[:, 2], color=look.colour, alpha=0.15, lw=0)


def _default_maps(columns: Columns, varied: Sequence[Vary]) -> list[Map]:
    """The two numbers on which the success rate hangs most."""
    if len(varied) < 2:
        return []

    def spread(v: Vary) -> float:
        sorted_in = binning.bins(v, columns.drawn(v), 12)
        rates = []
        for met in columns.success:
            worlds, successes_there = binning.shares(sorted_in.index, len(sorted_in), met)
            rates.append(np.std((successes_there + 0.5) / (worlds + 1.0)))
        return float(max(rates))

    first, second = sorted(varied, key=spread, reverse=True)[:2]
    everywhere_alike = columns.success.all() or not columns.success.any()
    return [
        Map(first.name, second.name, columns.study.metrics[0] if everywhere_alike else "success")
    ]


def _map(columns: Columns, wanted: Map, number: int) -> Drawing:
    study = columns.study
    by_name = {v.name: v for v in study.vary}
    x, y = by_name[wanted.x], by_name[wanted.y]
    fine = int(np.clip(np.sqrt(study.worlds / 25), 6, 40))
    along, up = (binning.bins(v, columns.drawn(v), fine) for v in (x, y))
    place = up.index * len(along) + along.index
    cells = len(along) * len(up)
    grids = []
    for k in range(len(study.controllers)):
        if wanted.show == "success":
            worlds, met = binning.shares(place, cells, columns.success[k])
            grid = np.where(worlds > 0, met / np.maximum(worlds, 1), np.nan)
        else:
            usable = columns.finished[k]
            values = columns.metric(wanted.show)[k][usable]
            grid = binning.grouped_quantiles(place[usable], cells, values, (0.5,))[:, 0]
        grids.append(grid.reshape(len(up), len(along)))
    everything = np.array(grids)
    there = everything[np.isfinite(everything)]
    low, high = (0.0, 1.0) if wanted.show == "success" or not len(there) else (
        float(np.quantile(there, 0.01)), float(np.quantile(there, 0.99))
    )  # fmt: skip
    with rc_context({**RC, "axes.grid": False}):
        figure = Figure(figsize=(2.75 * len(grids) + 0.7, 2.7), layout="constrained")
        axes = figure.subplots(1, len(grids), squeeze=False, sharex=True, sharey=True)[0]
        for ax, grid, law in zip(axes, grids, study.controllers, strict=True):
            ax.set_facecolor("0.88")
            mesh = ax.pcolormesh(along.edges, up.edges, grid, vmin=low, vmax=high,
                                 cmap="viridis", rasterized=True)  # fmt: skip
            ax.set_title(style(study.controllers, law).label, fontsize=8)
            ax.set_xlabel(x.label)
            if binning.is_logarithmic(x):
                ax.set_xscale("log")
            if binning.is_logarithmic(y):
                ax.set_yscale("log")
        axes[0].set_ylabel(y.label)
        what = "success rate" if wanted.show == "success" else f"median {_axis(study, wanted.show)}"
        figure.colorbar(mesh, ax=axes, label=what)
        png = _png(figure)
    grey = "no world lies there" if wanted.show == "success" else (
        "no world ran to its end there, or the median one has no value"
    )  # fmt: skip
    return Drawing(
        f"map_{number + 1}", f"Map: {what}",
        f"{what[0].upper()}{what[1:]} over {x.label} and {y.label}. Grey: {grey}.",
        f"{what} over {x.label} and {y.label}, one map for each law", png,
    )  # fmt: skip


def _axis(study: Study, name: str) -> str:
    unit = study.quantity(name).unit
    return name.replace("_", " ") + (f" ({unit})" if unit else "")
