"""A tuning's one offline page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from multilift import provenance
from multilift.packed import resource
from multilift.report import html
from multilift.report.text import inline
from multilift.study.page import distribution, value
from multilift.tune.figures import tolerated

if TYPE_CHECKING:
    from multilift.tune.judge import Side
    from multilift.tune.run import Result

#: Name, unit, before and after.
Row = tuple[str, str, float, float]

#: What is shown of the flight beside objectives and constraints, where the model has it.
_BESIDE = ("combined_settling", "swing_settling_time", "position_settling_time", "peak_swing",
           "peak_swing_1", "overshoot", "control_effort", "peak_thrust", "peak_tilt",
           "min_tension")  # fmt: skip


def render(result: Result, drawings: Mapping[str, bytes]) -> str:
    """Makes the page, which loads nothing.

    Args:
        result: of a tuning.
        drawings: PNGs by name.
    """
    tuning = result.found.tuning
    environment = html.environment({"inline": inline, "value": value})
    return environment.from_string(resource("multilift.tune", "page.html.j2")).render(
        result=result,
        tuning=tuning,
        goal=tuning.goal,
        lead=lead(result),
        images={name: html.image(content) for name, content in drawings.items()},
        numbers=[
            (v, result.before.numbers[v.name], result.after.numbers[v.name], s)
            for v, s in zip(tuning.space.varied, result.slices, strict=True)
        ],
        keys=_keys(result),
        flights=_flights(result),
        objectives=[o.metric for o in tuning.goal.objectives],
        constraints=[c.sentence() for c in tuning.goal.constraints],
        statistic=statistic(result),
        varied=[] if tuning.over is None else [(v, distribution(v)) for v in tuning.over.vary],
        front=[(result.found.numbers(int(k)), result.found.values(int(k)))
               for k in result.found.front()] if tuning.goal.combine == "front" else [],
        quantities=tuning.scenario.quantities.metrics,
        tolerated=tolerated(),
        provenance=list(provenance.describe().items()),
        style=Markup(resource("multilift.report", "style.css")),
        script=Markup(resource("multilift.report", "page.js")),
    )  # fmt: skip


def lead(result: Result) -> list[str]:
    """The conclusion in sentences."""
    tuning = result.found.tuning
    sentences = []
    for o in tuning.goal.objectives:
        was, now = result.before.judged[o.metric], result.after.judged[o.metric]
        unit = f" {o.unit}" if o.unit else ""
        what = o.metric.replace("_", " ").capitalize()
        if not math.isfinite(now):
            sentences.append(f"{what}: no set of numbers was found that has a value.")
            continue
        text = f"{what}: {value(now)}{unit}"
        text += f" instead of {value(was)}{unit}" if math.isfinite(was) else ", where it had none"
        if o.metric == "combined_settling" and result.least_time is not None:
            text += f", {now / result.least_time:.2f} times the bound of the move"
        sentences.append(text + ".")
    if result.after.violation > 0:
        sentences.append("No set of numbers was found that keeps every constraint.")
    return sentences


def statistic(result: Result) -> str:
    """Over what the objectives are, in words."""
    tuning = result.found.tuning
    if tuning.over is None:
        return "flown once"
    name = {"worst": "worst", "mean": "mean"}.get(
        tuning.goal.statistic, f"{100 * tuning.goal.quantile:g} % quantile"
    )
    return f"by the {name} over {tuning.worlds:,} worlds; here over others"


def _keys(result: Result) -> list[tuple[str, Any, Any]]:
    """The scenario's keys that changed, before and after."""
    tuning = result.found.tuning
    names = dict.fromkeys(t.key.split("[")[0] for v in tuning.space.varied for t in v.targets)
    one, other = result.before.scenario, result.after.scenario
    return [(name, one[name], other[name]) for name in names]


def _flights(result: Result) -> list[Row]:
    """Name, unit, before and after of one flight's numbers."""
    quantities = result.found.tuning.scenario.quantities.metrics
    goal = result.found.tuning.goal
    names = dict.fromkeys(
        [*(o.metric for o in goal.objectives), *(c.metric for c in goal.constraints), *_BESIDE]
    )
    sides: tuple[Side, Side] = (result.before, result.after)
    rows: list[Row] = [
        (n, quantities[n].unit, sides[0].run.metrics[n], sides[1].run.metrics[n])
        for n in names
        if n in quantities
    ]
    if result.least_time is not None:
        was, now = (s.run.metrics["combined_settling"] / result.least_time for s in sides)
        rows.append(("combined settling, times the bound", "", was, now))
    axes = ("y", "z") if len(result.after.peaks) == 2 else ("x", "y", "z")
    rows += [(f"greatest command along {a}", "N", sides[0].peaks[k], sides[1].peaks[k])
             for k, a in enumerate(axes)]  # fmt: skip
    rows.append(("slowest mode, time constant", "s", sides[0].slowest, sides[1].slowest))
    rows.append(("least damping ratio of a mode", "", sides[0].damping, sides[1].damping))
    return [row for row in rows if any(math.isfinite(x) for x in row[2:])]
