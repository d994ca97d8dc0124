"""The questions that the paper leaves open, answered by the shipped studies at a small size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from multilift import library, study
from multilift.report import Sensitivity
from multilift.study import page, run
from multilift.study.spec import Study
from multilift.study.summary import LawSummary, Summary

#: Draws of a study at its small size; about a minute for all of them with the compiled batches.
COUNT = 512

#: Of a grid at its small size, each axis keeps at most so many values.
POINTS = 16


def names() -> list[str]:
    """The studies that are run."""
    return [file.stem for file in library.studies()]


def small(name: str, *, count: int = COUNT, points: int = POINTS) -> Study:
    """A shipped study at its small size: fewer draws, coarser grids over the same range."""
    plan = study.load(name)
    thinned = tuple(
        replace(v, values=v.values[:: -(-(len(v.values) - 1) // (points - 1))])
        if v.distribution == "grid" and len(v.values) > points else v
        for v in plan.vary
    )  # fmt: skip
    return replace(plan, vary=thinned, count=min(count, plan.count) if plan.sampled else plan.count)


def table(
    folder: Path,
    advance: Callable[[], None] = lambda: None,
    *,
    count: int = COUNT,
    points: int = POINTS,
) -> Sensitivity:
    """Runs every shipped study at its small size and says what came out.

    Args:
        folder: where each study's own folder, with its report, is made.
        advance: called after each study, for a progress bar.
        count: draws of each study.
        points: of each axis of a grid.

    Raises:
        OutputError: if the folder cannot be written.
    """
    rows = []
    for name in names():
        plan = small(name, count=count, points=points)
        rows.append(_row(plan, run.run(plan, folder / name).summary))
        advance()
    return Sensitivity(
        title="Questions that the paper leaves open",
        intro="How often a law succeeds where much is uncertain at once: share of worlds, with the "
        "95 % interval where they are drawn, energy-coupled / PD. Each study has a page of its own "
        "beside this one, `studies/NAME/report.html`, which says what varies.",
        heads=["study", "success means", "worlds", "success", "ended early", "full size"],
        rows=rows,
        note="Shares hold for the ranges that the studies choose, which the paper does not give.",
    )


def _row(plan: Study, summary: Summary) -> list[str]:
    def rate(law: LawSummary) -> str:
        text = page.percent(law.success.estimate)
        return f"{text} ({page.interval(law.success)})" if plan.sampled else text

    early = [f"{plan.worlds - law.outcomes['finished']:,}" for law in summary.laws]
    return [
        plan.title,
        ", ".join(c.sentence() for c in plan.success),
        f"{plan.worlds:,}",
        " / ".join(map(rate, summary.laws)),
        " / ".join(early),
        f"multilift study {plan.name} -o out/{plan.name}",
    ]
