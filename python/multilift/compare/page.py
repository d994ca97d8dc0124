"""The comparison's one offline page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from multilift import provenance
from multilift.compare import tables
from multilift.compare.tuning import ERROR, SWING, Tuned
from multilift.packed import resource
from multilift.report import html
from multilift.study.summary import toml_inline

if TYPE_CHECKING:
    from multilift.compare.run import Comparison

_LONG = 60  # numbers: a set of gains beyond them is in its file alone


def render(result: Comparison, figures: Mapping[str, bytes]) -> str:
    """The page, which loads nothing.

    Args:
        result: what to show.
        figures: PNGs by the tasks' names.
    """
    environment = html.environment()
    content = result.to_json()
    names = " ".join(task.scenario.where for task in result.tasks)
    return environment.from_string(resource("multilift.compare", "page.html.j2")).render(
        result=result,
        entries=content["tasks"],
        heads=tables.heads(),
        legend=tables.LEGEND,
        cells=lambda entry: tables.cells(entry, result.draws),
        change=_change,
        images={name: html.image(png) for name, png in figures.items()},
        contenders=list({r.contender.name: r.contender for t in result.tasks for r in t.results}
                        .values()),
        error=ERROR,
        swing=SWING,
        command_line=f"multilift compare {names} -o {result.folder} --draws {result.draws} "
        f"--seed {result.seed}",
        provenance=list(provenance.describe().items()),
        style=Markup(resource("multilift.report", "style.css")),
        script=Markup(resource("multilift.report", "page.js")),
    )  # fmt: skip


def _change(r: Tuned) -> str:
    """The tuned gains as part of a scenario file, where people can read them."""
    table: dict[str, Any] = r.run.scenario.raw()["controller"]
    if sum(_size(value) for value in table.values()) > _LONG:
        drawn = ", ".join(f"{name} = {value:.6g}" for name, value in r.drawn.items())
        return f"# the gains are in the file; they are those of {drawn}"
    return "\n".join(["[controller]", *(f"{k} = {toml_inline(v)}" for k, v in table.items())])


def _size(value: Any) -> int:
    return sum(map(_size, value)) if isinstance(value, list) else 1
