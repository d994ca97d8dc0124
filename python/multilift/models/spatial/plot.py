"""The figure of spatial runs: where the payload went, how it hung, what held it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from multilift.models.spatial.run import SpatialRun, rotation_matrices
from multilift.models.spatial.scene import events, shown_swing
from multilift.plot import DESIRED, RC, LineStyle, styles
from multilift.replay.colours import vehicle_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

_DEGREE = 180.0 / np.pi
_BAND = 1.0  # deg: swing within it counts as settled
_ALARM = "#c0392b"
_MANY = 8  # vehicles with a line each; more of them are a band


@dataclass(frozen=True)
class _Panel:
    """Some curves over time in one unit.

    Attributes:
        label: of the axis.
        values: of a run, shape (rows,), or (rows, n) with one column a vehicle.
        least: span that the axis has at least, so that round-off does not fill it.
        desired: the same shape, or a number; drawn dashed.
        zero: whether the axis begins at 0.
    """

    label: str
    values: Callable[[SpatialRun], Array]
    least: float
    desired: Callable[[SpatialRun], Array] | None = None
    zero: bool = False


def overview(runs: Sequence[SpatialRun]) -> Figure:
    """Payload, vehicles' errors, swing, tensions and thrusts of runs of one scenario.

    Of a single run every vehicle has its line. Several runs are told apart by their laws' styles,
    and a band spans what their vehicles do, with a line along the greatest.
    """
    panels = _panels(runs[0])
    alone = len(runs) == 1
    with rc_context(RC):
        figure = Figure(figsize=(6.2, 1.02 * len(panels) + 0.9), layout="constrained")
        axes: list[Axes] = list(figure.subplots(len(panels), 1, sharex=True))
        looks = styles(runs)
        for ax, panel in zip(axes, panels, strict=True):
            for run, look in zip(runs, looks, strict=True):
                _draw(ax, run, panel, look, alone)
            if panel.desired is not None:
                wanted = panel.desired(max(runs, key=lambda run: run.end_time))
                t = max(runs, key=lambda run: run.end_time).t
                ax.plot(t, np.broadcast_to(wanted, t.shape), color=DESIRED.colour, ls=DESIRED.dash,
                        lw=0.9)  # fmt: skip
            ax.set_ylabel(panel.label)
            _limits(ax, runs, panel)
            _mark(ax, runs[0])
        swing = next(ax for ax, p in zip(axes, panels, strict=True) if p.label.startswith("swing"))
        swing.axhspan(0.0, _BAND, color="#009E73", alpha=0.15, lw=0)
        axes[-1].set_xlabel("time (s)")
        axes[-1].set_xlim(0.0, max(run.t[-1] for run in runs))
        _legend(figure, runs, looks, alone)
        _name_events(axes[0], runs[0])
        figure.align_ylabels(axes)
    return figure


def _panels(run: SpatialRun) -> list[_Panel]:
    vehicles = [f"vehicle{k + 1}" for k in range(run.scenario.count)]
    panels = [
        _Panel(f"payload {axis} (m)", itemgetter(f"payload_{axis}"), 0.1,
               itemgetter(f"target_{axis}"))
        for axis in "xyz"
    ]  # fmt: skip
    panels.append(
        _Panel(
            "vehicles'\nerrors (m)",
            lambda r: _columns(
                np.linalg.norm(r.vector(v) - r.vector(f"goal{k + 1}"), axis=1)
                for k, v in enumerate(vehicles)
            ),
            0.05,
            zero=True,
        )
    )
    panels.append(_Panel("swing (deg)", swing, 1.5 * _BAND, zero=True))
    panels.append(
        _Panel(
            "tensions (N)",
            lambda r: _columns(r[f"tension{k + 1}"] for k in range(len(vehicles))),
            1.0,
        )
    )
    panels.append(
        _Panel(
            "thrusts (N)",
            lambda r: _columns(
                np.linalg.norm(r.vector(f"thrust{k + 1}"), axis=1) for k in range(len(vehicles))
            ),
            1.0,
        )
    )
    if np.array(run.scenario["plant.payload_inertia"]).any():
        panels.append(
            _Panel("payload's\nheading (deg)", lambda r: _DEGREE * heading(r), 2.0,
                   lambda r: _DEGREE * np.unwrap(r["target_yaw"]))
        )  # fmt: skip
        panels.append(_Panel("payload's\ntilt (deg)", lambda r: _DEGREE * tilt(r), 2.0, zero=True))
    return panels


def heading(run: SpatialRun) -> Array:
    """Where the payload's x axis points, from the world's x towards y, unwrapped, rad."""
    matrices = rotation_matrices(run.attitude("payload"))
    return np.asarray(np.unwrap(np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])))


def tilt(run: SpatialRun) -> Array:
    """Angle between the payload's z axis and the vertical, rad."""
    up = rotation_matrices(run.attitude("payload"))[:, :, 2]
    return np.asarray(np.arctan2(np.hypot(up[:, 0], up[:, 1]), up[:, 2]))


def swing(run: SpatialRun) -> Array:
    """Of the cables that pull on a flying vehicle, else NaN, deg, shape (rows, n)."""
    return np.asarray(_DEGREE * shown_swing(run))


def _columns(columns: Iterable[NDArray[Any]]) -> NDArray[Any]:
    return np.column_stack(list(columns))


def _draw(ax: Axes, run: SpatialRun, panel: _Panel, look: LineStyle, alone: bool) -> None:
    values = panel.values(run)
    if values.ndim == 1:
        colour = "0.25" if alone else look.colour
        ax.plot(run.t, values, color=colour, ls="-" if alone else look.dash)
    elif alone and values.shape[1] <= _MANY:
        for k in range(values.shape[1]):
            ax.plot(run.t, values[:, k], color=vehicle_colour(k), lw=1.0)
    else:
        low, high = (
            np.where(np.isnan(values).all(axis=1), np.nan, pick(np.nan_to_num(values, nan=fill),
                                                                axis=1))
            for pick, fill in ((np.min, np.inf), (np.max, -np.inf))
        )  # fmt: skip
        colour = "0.25" if alone else look.colour
        ax.fill_between(run.t, low, high, color=colour, alpha=0.18, lw=0)
        ax.plot(run.t, high, color=colour, ls="-" if alone else look.dash, lw=1.0)


def _limits(ax: Axes, runs: Sequence[SpatialRun], panel: _Panel) -> None:
    """All of it but rare jerks, which leave the axis; round-off does not fill it."""
    ends = []
    for run in runs:
        values = panel.values(run)
        values = values[np.isfinite(values)]
        if not values.size:
            continue
        low, high = np.quantile(values, [0.002, 0.998])
        if values.max() - values.min() < 2.0 * (high - low):
            low, high = values.min(), values.max()
        ends += [low, high]
        if panel.desired is not None:
            wanted = panel.desired(run)
            ends += [np.min(wanted), np.max(wanted)]
    if not ends:
        return
    low, high = float(min(ends)), float(max(ends))
    span = max(high - low, panel.least)
    middle = 0.5 * (low + high)
    if panel.zero:
        ax.set_ylim(0.0, 1.08 * max(high, panel.least))
    else:
        ax.set_ylim(middle - 0.56 * span, middle + 0.56 * span)


def _mark(ax: Axes, run: SpatialRun) -> None:
    for push in run.scenario["push"]:
        ax.axvspan(push["start"], push["start"] + push["duration"], color="0.75", lw=0)
    for event in events(run):
        if event.kind != "push":
            ax.axvline(event.time, color=_ALARM, lw=0.9)


def _name_events(ax: Axes, run: SpatialRun) -> None:
    for event in events(run):
        if event.kind != "push":
            ax.annotate(event.text, (event.time, 1.0), xycoords=("data", "axes fraction"),
                        va="bottom", ha="left", fontsize=7.0, color=_ALARM)  # fmt: skip


def _legend(
    figure: Figure, runs: Sequence[SpatialRun], looks: Sequence[LineStyle], alone: bool
) -> None:
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=DESIRED.colour, ls=DESIRED.dash, lw=0.9, label="target")
    ]
    count = runs[0].scenario.count
    if alone and count <= _MANY:
        handles += [
            Line2D([], [], color=vehicle_colour(k), label=f"vehicle {k + 1}") for k in range(count)
        ]
    elif alone:
        handles.append(Patch(color="0.25", alpha=0.3, label=f"all {count} vehicles"))
    else:
        handles += [
            Line2D([], [], color=look.colour, ls=look.dash, label=look.label) for look in looks
        ]
        handles.append(Patch(color="0.5", alpha=0.3, label="all vehicles"))
    handles.append(Patch(color="#009E73", alpha=0.25, label=f"swing < {_BAND:g}°"))
    if runs[0].scenario["push"]:
        handles.append(Patch(color="0.75", label="push"))
    columns = min(len(handles), 5)  # filled one after the other, but people read rows
    handles = [handle for k in range(columns) for handle in handles[k::columns]]
    figure.legend(handles=handles, loc="outside upper center", ncols=columns, frameon=False,
                  columnspacing=1.4)  # fmt: skip
