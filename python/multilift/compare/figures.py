"""A task's figure: every tuned law's error and swing over time, and what tuning gained."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from multilift.compare.tuning import Tuned
from multilift.plot import RC, LineStyle, line_styles

from matplotlib import rc_context  # isort: skip - after multilift.plot, which says what is missing
from matplotlib.figure import Figure  # isort: skip

_SETTLED = 2.0  # cm
_LEAST = 0.1  # cm: below it nothing is told apart from noise
_DEGREE = 180.0 / np.pi


def looks(results: Sequence[Tuned]) -> list[LineStyle]:
    """A colour for each law, dotted with integral action."""
    styles = line_styles([r.contender.law for r in results])
    return [
        replace(
            styles[r.contender.law],
            dash=(0.0, (1.0, 1.2)) if r.contender.name.endswith("_integral") else "-",
            label=r.contender.label,
        )
        for r in results
    ]


def draw(results: Sequence[Tuned]) -> bytes:
    """The figure of one task as a PNG."""
    with rc_context({**RC, "lines.linewidth": 1.1}):
        figure = Figure(figsize=(7.6, 3.9), layout="constrained")
        axes = figure.subplot_mosaic(
            [["error", "course"], ["swing", "course"]], width_ratios=[1.7, 1.0]
        )
        for r, look in zip(results, looks(results), strict=True):
            run = r.run
            error = 100.0 * np.linalg.norm(run.vector("payload") - run.vector("target"), axis=1)
            drawn = {"color": look.colour, "ls": look.dash}
            axes["error"].plot(run.t, np.maximum(error, _LEAST), label=look.label, **drawn)
            axes["swing"].plot(run.t, _DEGREE * run.swing().max(axis=1), **drawn)
            axes["course"].step(np.arange(1, len(r.course) + 1), r.course, where="post", **drawn)
        axes["error"].axhline(_SETTLED, color="0.6", lw=0.7)
        axes["error"].set_yscale("log")
        axes["error"].set_ylabel("payload off\nits target (cm)")
        axes["error"].tick_params(labelbottom=False)
        axes["swing"].axhline(1.0, color="0.6", lw=0.7)
        axes["swing"].set_ylabel("greatest\nswing (deg)")
        axes["swing"].set_xlabel("time (s)")
        for name in ("error", "swing"):
            axes[name].set_xlim(0.0, max(r.run.t[-1] for r in results))
        axes["course"].set_xscale("log")
        axes["course"].set_xlabel("sets of gains tried")
        axes["course"].set_ylabel("least cost so far")
        figure.legend(loc="outside upper center", ncols=4, frameon=False)
        figure.align_ylabels([axes["error"], axes["swing"]])
        file = io.BytesIO()
        figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()
