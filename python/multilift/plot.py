"""Figures of runs in the paper's layout, with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from multilift.errors import MissingExtraError
from multilift.styles import LAW_LABELS, law_styles

try:
    from matplotlib import rc_context
    from matplotlib.figure import Figure
except ImportError:
    raise MissingExtraError("matplotlib", "plot", "drawing figures") from None

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from multilift.run import Run


@dataclass(frozen=True)
class LineStyle:
    """How one controller's curves look in figures."""

    colour: str
    dash: Any  # matplotlib's
    label: str


DESIRED = LineStyle("black", "--", "desired")

#: matplotlib's dashes are in line widths; this makes PD's the length of its own "--".
_WIDTHS_PER_PIXEL = 1.6 / 3.0

#: Sizes and rules of every figure, for matplotlib's rc_context.
RC: Any = {
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.3,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 150,
    "savefig.dpi": 150,
    "pdf.fonttype": 42,
}


def line_styles(laws: Sequence[str]) -> dict[str, LineStyle]:
    """How the curves of laws, by name, look; repetitions are fine."""
    result = {}
    for law, style in law_styles(laws).items():
        dash = (0.0, tuple(_WIDTHS_PER_PIXEL * d for d in style.dashes)) if style.dashes else "-"
        result[law] = LineStyle(style.color, dash, LAW_LABELS.get(law, law))
    return result


def styles(runs: Sequence[Run]) -> list[LineStyle]:
    """One style for each run, by its controller; a law of one's own goes by its title."""
    looks = line_styles([run.controller for run in runs])
    return [
        looks[run.controller]
        if run.controller in LAW_LABELS
        # A dollar sign would start a formula.
        else replace(looks[run.controller], label=run.controller_title.replace("$", r"\$"))
        for run in runs
    ]


def response(runs: Sequence[Run]) -> Figure:
    """Positions, angles and drag estimates of runs of one scenario: the paper's Figs. 2, 4, 7, ...

    Args:
        runs: of the same scenario, one for each controller.
    """
    goal = runs[0].scenario.goal_vector()
    panels = [
        *((name, f"${name[0]}_{name[1]}$ (m)", 1.0) for name in ("y1", "z1", "y2", "z2")),
        *((f"theta{k}", rf"$\theta_{k}$ (deg)", 180 / np.pi) for k in (1, 2, 3)),
        *(
            (f"d_hat_{axis}", rf"$\hat d_{{{axis[0]}{axis[1]}}}$ (N s/m)", 1.0)
            for axis in ("y1", "z1", "y2", "z2")
        ),
    ]
    desired = {name: goal[k] for k, name in enumerate(("y1", "z1", "y2", "z2"))}
    desired |= dict.fromkeys(("theta1", "theta2", "theta3"), 0.0)
    return _stack(runs, panels, desired, height=1.05)


def commands(runs: Sequence[Run]) -> Figure:
    """The commands u1..u4 of runs of one scenario: the paper's Figs. 3, 5, 8, ..."""
    panels = [(f"u{k}", f"$u_{k}$ (N)", 1.0) for k in (1, 2, 3, 4)]
    return _stack(runs, panels, {}, height=1.4)


def overview(runs: Sequence[Run]) -> Figure:
    """Response and commands in one figure, with the tensions."""
    goal = runs[0].scenario.goal_vector()
    panels = [
        *((name, f"${name[0]}_{name[1]}$ (m)", 1.0) for name in ("y1", "z1", "y2", "z2")),
        *((f"theta{k}", rf"$\theta_{k}$ (deg)", 180 / np.pi) for k in (1, 2, 3)),
        *((f"u{k}", f"$u_{k}$ (N)", 1.0) for k in (1, 2, 3, 4)),
        *((f"tension{k}", f"$T_{k}$ (N)", 1.0) for k in (1, 2)),
    ]
    desired = {name: goal[k] for k, name in enumerate(("y1", "z1", "y2", "z2"))}
    return _stack(runs, panels, desired, height=0.95)


def _stack(
    runs: Sequence[Run],
    panels: Sequence[tuple[str, str, float]],
    desired: dict[str, float],
    *,
    height: float,
) -> Figure:
    with rc_context(RC):
        figure = Figure(figsize=(5.6, height * len(panels) + 0.75), layout="constrained")
        axes: list[Axes] = list(figure.subplots(len(panels), 1, sharex=True))
        looks = styles(runs)
        for ax, (column, label, scale) in zip(axes, panels, strict=True):
            if column in desired:
                ax.axhline(desired[column], color=DESIRED.colour, ls=DESIRED.dash, lw=0.9,
                           label=DESIRED.label)  # fmt: skip
            # Solid first: where curves coincide, both show through the dashes on top.
            for run, look in sorted(
                zip(runs, looks, strict=True), key=lambda pair: pair[1].dash != "-"
            ):
                if column in run.columns:
                    ax.plot(run.t, scale * run[column], color=look.colour, ls=look.dash,
                            label=look.label)  # fmt: skip
            ax.set_ylabel(label)
            _steady_limits(ax, runs, column, scale, desired.get(column))
            for push in runs[0].scenario.values["push"]:
                ax.axvspan(push["start"], push["start"] + push["duration"], color="0.75", lw=0)
        axes[-1].set_xlabel("time (s)")
        axes[-1].set_xlim(0.0, max(run.t[-1] for run in runs))
        handles = {
            label: handle
            for ax in axes
            for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
        }
        order = [DESIRED.label] * bool(desired) + [look.label for look in looks]
        figure.legend(
            [handles[k] for k in order], order, loc="outside upper center", ncols=len(order),
            frameon=False,
        )  # fmt: skip
        figure.align_ylabels(axes)
    return figure


def _steady_limits(
    ax: Axes, runs: Sequence[Run], column: str, scale: float, goal: float | None
) -> None:
    """Keeps round-off from filling an axis: at least a small, stated span around the values."""
    least = {"y": 0.1, "z": 0.1, "t": 1.0, "d": 0.02, "u": 0.2}[column[0]]
    values = [scale * run[column] for run in runs if column in run.columns]
    if not values:
        return
    lo, hi = min(v.min() for v in values), max(v.max() for v in values)
    if goal is not None:
        lo, hi = min(lo, goal), max(hi, goal)
    span = max(hi - lo, least)
    middle = 0.5 * (lo + hi)
    ax.set_ylim(middle - 0.56 * span, middle + 0.56 * span)
