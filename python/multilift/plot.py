"""How figures of runs look: styles, sizes, and panels over time, with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

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


@dataclass(frozen=True)
class Panel:
    """A column of a run over time.

    Attributes:
        column: absent from a run: not drawn for it.
        label: of the axis, with the unit that `scale` gives.
        least: span that the axis has at least, so that round-off does not fill it.
        scale: from SI and radians.
        desired: value to draw beside it, in the axis's unit.
    """

    column: str
    label: str
    least: float
    scale: float = 1.0
    desired: float | None = None


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
    """One style for each run, by its controller; a law of one's own goes by its title.

    Runs of one law are told apart by their scenarios, whose titles then name them.
    """
    if len({run.controller for run in runs}) < len(runs):
        titles = [run.scenario.title for run in runs]
        told_apart = line_styles(titles)
        return [replace(told_apart[t], label=t.replace("$", r"\$")) for t in titles]
    looks = line_styles([run.controller for run in runs])
    return [
        looks[run.controller]
        if run.controller in LAW_LABELS
        # A dollar sign would start a formula.
        else replace(looks[run.controller], label=run.controller_title.replace("$", r"\$"))
        for run in runs
    ]


def stack(runs: Sequence[Run], panels: Sequence[Panel], *, height: float) -> Figure:
    """Panels over one axis of time, with the pushes as grey bands.

    Args:
        runs: of the same scenario, one for each controller.
        panels: from top to bottom.
        height: of each, inches.
    """
    with rc_context(RC):
        figure = Figure(figsize=(5.6, height * len(panels) + 0.75), layout="constrained")
        axes: list[Axes] = list(figure.subplots(len(panels), 1, sharex=True))
        looks = styles(runs)
        for ax, panel in zip(axes, panels, strict=True):
            if panel.desired is not None:
                ax.axhline(panel.desired, color=DESIRED.colour, ls=DESIRED.dash, lw=0.9,
                           label=DESIRED.label)  # fmt: skip
            # Solid first: where curves coincide, both show through the dashes on top.
            for run, look in sorted(
                zip(runs, looks, strict=True), key=lambda pair: pair[1].dash != "-"
            ):
                if panel.column in run.columns:
                    ax.plot(run.t, panel.scale * run[panel.column], color=look.colour, ls=look.dash,
                            label=look.label)  # fmt: skip
            ax.set_ylabel(panel.label)
            _steady_limits(ax, runs, panel)
            for push in runs[0].scenario.values.get("push", []):
                ax.axvspan(push["start"], push["start"] + push["duration"], color="0.75", lw=0)
        axes[-1].set_xlabel("time (s)")
        axes[-1].set_xlim(0.0, max(run.t[-1] for run in runs))
        handles = {
            label: handle
            for ax in axes
            for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
        }
        any_desired = any(panel.desired is not None for panel in panels)
        order = [DESIRED.label] * any_desired + [look.label for look in looks]
        figure.legend(
            [handles[k] for k in order], order, loc="outside upper center", ncols=len(order),
            frameon=False,
        )  # fmt: skip
        figure.align_ylabels(axes)
    return figure


def _steady_limits(ax: Axes, runs: Sequence[Run], panel: Panel) -> None:
    """Keeps round-off from filling an axis."""
    values = [panel.scale * run[panel.column] for run in runs if panel.column in run.columns]
    if not values:
        return
    lo, hi = min(v.min() for v in values), max(v.max() for v in values)
    if panel.desired is not None:
        lo, hi = min(lo, panel.desired), max(hi, panel.desired)
    span = max(hi - lo, panel.least)
    middle = 0.5 * (lo + hi)
    ax.set_ylim(middle - 0.56 * span, middle + 0.56 * span)
