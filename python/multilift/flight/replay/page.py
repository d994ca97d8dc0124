"""The page of a replay: the flight, its simulation, and what the autopilots recorded; offline."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from markupsafe import Markup
from matplotlib import rc_context
from matplotlib.figure import Figure

from multilift.flight.replay.beside import Replay
from multilift.flight.replay.ulog import MEANINGS, Compared
from multilift.models.spatial import plot
from multilift.models.spatial.run import SpatialRun
from multilift.packed import resource
from multilift.plot import RC
from multilift.quantities import Quantity
from multilift.replay import scene_of
from multilift.replay.page import render as render_scene
from multilift.report import html
from multilift.report.text import inline, number

#: Ours and the autopilot's.
_OURS, _THEIRS = "#0072B2", "#D55E00"


@dataclass(frozen=True)
class _Row:
    """A quantity of the flight and of its simulation."""

    quantity: Quantity
    flight: float
    simulation: float


def render(replay: Replay, whole: SpatialRun) -> str:
    """The page, which loads nothing.

    Args:
        replay: what to show.
        whole: the flight from its first tick to its last.
    """
    environment = html.environment({"inline": inline, "value": partial(number, digits=3)})
    flight, simulation = replay.flight, replay.simulation
    names = flight.quantities
    tables = [
        ("Metrics", [_Row(q, flight.metrics[k], simulation.metrics[k])
                     for k, q in names.metrics.items()]),
        ("Energy audit", [_Row(q, flight.audit[k], simulation.audit[k])
                          for k, q in names.audit.items()]),
    ]  # fmt: skip
    return environment.from_string(resource("multilift.flight.replay", "page.html.j2")).render(
        replay=replay,
        flown=replay.flown,
        scenario=replay.flown.scenario,
        scenes=[("flight", "From the first tick of the log to its last.", whole),
                ("simulation", "The same scenario, simulated.", simulation)],
        scene=lambda run: render_scene(scene_of(run)),
        figure=_image(plot.overview([flight, simulation])),
        tables=tables,
        recorded={k: (_image(_figure(c)), _numbers(c)) for k, c in replay.compared.items()},
        provenance=list(flight.provenance().items()),
        style=Markup(resource("multilift.report", "style.css")),
        script=Markup(resource("multilift.report", "page.js")),
    )  # fmt: skip


def _numbers(compared: Compared) -> list[tuple[str, float, str, str]]:
    return [(name, x, *MEANINGS[name]) for name, x in compared.numbers.items()]


def _figure(compared: Compared) -> Figure:
    """Ours and the autopilot's of every curve that both have."""
    curves = compared.curves
    pairs = [name for name in curves if f"{name}_recorded" in curves]
    labels: Mapping[str, str] = {"lean": "thrust axis\n{} (-)", "wanted": "set-point\n{} (-)",
                                 "position": "position\n{} (m)"}  # fmt: skip
    with rc_context(RC):
        figure = Figure(figsize=(6.2, 0.95 * len(pairs) + 0.8), layout="constrained")
        axes = np.atleast_1d(figure.subplots(len(pairs), 1, sharex=True))
        for ax, name in zip(axes, pairs, strict=True):
            kind, _, axis = name.rpartition("_")
            ax.plot(curves["t"], curves[name], color=_OURS, label="our log")
            ax.plot(curves["t"], curves[f"{name}_recorded"], color=_THEIRS, lw=0.8,
                    label="autopilot's recording")  # fmt: skip
            ax.set_ylabel(labels[kind].format(axis))
        axes[-1].set_xlabel("time since the log's first tick (s)")
        handles, texts = axes[0].get_legend_handles_labels()
        figure.legend(handles, texts, loc="outside upper center", ncols=2, frameon=False)
        figure.align_ylabels(list(axes))
    return figure


def _image(figure: Figure) -> html.Image:
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return html.image(file.getvalue())
