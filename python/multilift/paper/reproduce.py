"""``multilift reproduce``: the paper's five tests under every law, with figures and report."""

from __future__ import annotations

import math
import multiprocessing
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from multilift import controllers, library, provenance, storage
from multilift.errors import ControllerError, MissingExtraError
from multilift.models.planar.run import PlanarRun, planar_run
from multilift.run import Run, write_json, write_parquet
from multilift.scenario import load
from multilift.simulate import simulate
from multilift.styles import LAW_LABELS

try:
    from multilift import report
    from multilift.models.planar import plot
    from multilift.paper import page, sensitivity
except ImportError as error:
    if isinstance(error, MissingExtraError):
        raise
    raise MissingExtraError(str(error.name), "report", "multilift reproduce") from None

LAWS = ("energy_coupled", "pd")


@dataclass(frozen=True)
class Result:
    """Where the report lies, and the runs by scenario, then controller."""

    report: Path
    runs: dict[str, dict[str, PlanarRun]]


def reproduce(
    target: Path,
    *,
    beside: Sequence[str] = (),
    with_studies: bool = False,
    force: bool = False,
    console: Console | None = None,
) -> Result:
    """Runs the paper's tests and writes figures, data, metrics and one offline report.

    Args:
        target: folder to make; it appears only when complete.
        beside: further laws, each "FILE.py:NAME" or a compiled law's name.
        with_studies: run the shipped studies at a small size too; about a minute.
        force: replace an earlier result there.
        console: where the progress bar goes; none without it.

    Raises:
        OutputError: if the folder is taken or cannot be written.
        ControllerError: if a further law cannot be found or stepped, or its name is taken.
    """
    storage.check_target(target, force=force)
    laws = _laws(beside)
    drawings = 2 * len(page.FIGURES)
    total = len(page.FIGURES) * len(laws) + sensitivity.runs_needed() + drawings + 1
    total += len(library.studies()) * with_studies
    with (
        storage.new_folder(target, force=force) as folder,
        Progress(
            TextColumn("{task.description:<22}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console or Console(quiet=True),
        ) as progress,
    ):
        task = progress.add_task("simulating", total=total)
        runs: dict[str, dict[str, PlanarRun]] = {}
        for name in page.FIGURES:
            runs[name] = {}
            for law in laws:
                run = planar_run(simulate(load(name), law))
                runs[name][run.controller] = run
                _write_run(run, folder / name)
                progress.advance(task)
        figures = folder / "figures"
        figures.mkdir()
        with ProcessPoolExecutor(
            min(os.cpu_count() or 1, drawings), multiprocessing.get_context("spawn")
        ) as pool:
            waiting = [
                pool.submit(_draw, kind, list(runs[name].values()), figures,
                            page.figure_stem(number, name, kind))
                for name, numbers in page.FIGURES.items()
                for number, kind in zip(numbers, ("response", "commands"), strict=True)
            ]  # fmt: skip
            # While others draw, this process varies the assumptions.
            progress.update(task, description="varying, drawing")
            tables = [sensitivity.table(lambda: progress.advance(task))]
            progress.update(task, description="drawing")
            for done in as_completed(waiting):
                done.result()
                progress.advance(task)
        if with_studies:
            progress.update(task, description="studies")
            from multilift.paper import studies  # noqa: PLC0415 - needs the extra "study"

            tables.append(studies.table(folder / "studies", lambda: progress.advance(task)))
        progress.update(task, description="writing the report")
        summaries = {
            name: {law: run.summary() for law, run in laws.items()} for name, laws in runs.items()
        }
        write_json(folder / "metrics.json", summaries)
        seeds = {name: load(name).values["simulation"]["seed"] for name in runs}
        write_json(folder / "run.json", {**provenance.describe(), "seeds": seeds})
        contents = page.build(runs, figures, tables, beside)
        (folder / "report.html").write_text(report.render(contents), encoding="utf-8")
        progress.update(task, description="done")
        progress.advance(task)
    return Result(target / "report.html", runs)


def summary_table(runs: dict[str, dict[str, PlanarRun]]) -> Table:
    """The main metrics of every run, for the terminal."""
    early = any(not run.finished for laws in runs.values() for run in laws.values())
    heads = ["test", "law", "peak swing", "quiet after", "at goal after", "overshoot"]
    table = Table(*heads, *["ended"] * early, box=None, header_style="bold")
    for laws in runs.values():
        for k, run in enumerate(laws.values()):
            m = run.metrics
            table.add_row(
                run.scenario.title.split(":")[0] if k == 0 else "",
                LAW_LABELS.get(run.controller, run.controller),
                f"{m['peak_swing_1']:.2f}°",
                _seconds(m["swing_settling_time"]),
                _seconds(m["position_settling_time"]),
                f"{100 * m['overshoot']:.1f} cm",
                *["as planned" if run.finished else run.status] * early,
            )
    return table


def _laws(beside: Sequence[str]) -> list[str | controllers.PythonLaw]:
    names = set(LAWS)
    laws: list[str | controllers.PythonLaw] = list(LAWS)
    for reference in beside:
        law, _ = controllers.resolve(reference, load(next(iter(page.FIGURES))))
        if law.name in names:
            raise ControllerError(
                f"two laws are called {law.name!r}: rename the one in {reference}"
            )
        names.add(law.name)
        laws.append(law if isinstance(law, controllers.PythonLaw) else law.name)
    return laws


def _write_run(run: Run, folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    write_parquet(run, folder / f"{run.controller}.parquet")
    (folder / f"{run.controller}.toml").write_text(run.scenario.to_toml(), encoding="utf-8")


def _draw(kind: str, runs: Sequence[Run], folder: Path, stem: str) -> None:
    figure = plot.response(runs) if kind == "response" else plot.commands(runs)
    for ending in ("png", "pdf"):
        figure.savefig(folder / f"{stem}.{ending}")


def _seconds(x: float) -> str:
    return f"{x:.1f} s" if math.isfinite(x) else "-"
