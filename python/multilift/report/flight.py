"""The page of one run: its replay in space, its figure, its numbers, in one offline file."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from markupsafe import Markup

from multilift.packed import resource
from multilift.replay import scene_of
from multilift.replay.page import render as render_replay
from multilift.report import html
from multilift.report.text import inline, number

if TYPE_CHECKING:
    from multilift.run import Run

_HERE = "multilift.report"


def render(run: Run, figure: bytes) -> str:
    """Makes the page, which loads nothing.

    Args:
        run: of a model that has a shape.
        figure: its overview, a PNG.

    Raises:
        ScenarioError: if its model has none.
    """
    environment = html.environment({"inline": inline, "value": partial(number, digits=3)})
    overview = html.image(figure)
    names = run.quantities
    return environment.from_string(resource(_HERE, "flight.html.j2")).render(
        run=run,
        scenario=run.scenario,
        replay=render_replay(scene_of(run)),
        figure=overview.base64,
        width=overview.width,
        height=overview.height,
        tables=[
            (
                "Metrics",
                [
                    *((q, run.metrics[name]) for name, q in names.metrics.items()),
                    *run.beyond_metrics(),
                ],
            ),
            ("Energy audit", [(q, run.audit[name]) for name, q in names.audit.items()]),
            ("Residuals", [(q, run.residuals[name]) for name, q in names.residuals.items()]),
        ],
        provenance=list(run.provenance().items()),
        style=Markup(resource(_HERE, "style.css")),
        script=Markup(resource(_HERE, "page.js")),
    )
