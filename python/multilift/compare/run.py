"""The comparison: from tasks to a folder with tables, figures, flights and one offline page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from multilift import provenance, storage
from multilift.compare import page, tables
from multilift.compare.contenders import CONTENDERS, Contender
from multilift.compare.figures import draw
from multilift.compare.tuning import Tuned, tune
from multilift.errors import MultiliftError, ScenarioError
from multilift.models.spatial.scenario import SpatialScenario
from multilift.run import finite, write_json
from multilift.scenario import load

#: The shipped tasks: rest to rest, pushes, moves along paths, wind.
TASKS = (
    "exp1_1_quadrotors",
    "exp2_quadrotors",
    "platform_turn",
    "uneven_four",
    "platform_wind",
    "figure_eight_six",
)
DRAWS = 256
SEED = 2


@dataclass(frozen=True)
class Task:
    """A scenario and what each contender made of it."""

    scenario: SpatialScenario
    results: Sequence[Tuned]


@dataclass(frozen=True)
class Comparison:
    """All tasks.

    Attributes:
        tasks: in order.
        draws: sets of gains of each contender on each task.
        seed: of the draws, and of the noise while tuning.
        folder: where the results lie.
    """

    tasks: Sequence[Task]
    draws: int
    seed: int
    folder: Path

    @property
    def report(self) -> Path:
        """The offline page."""
        return self.folder / "report.html"

    def to_json(self) -> dict[str, Any]:
        """Everything but the trajectories; numbers that do not exist are None."""
        return {
            "draws": self.draws,
            "seed": self.seed,
            "tasks": {
                task.scenario.name: {r.contender.name: _entry(r) for r in task.results}
                for task in self.tasks
            },
        }


def compare(
    names: Sequence[str] = TASKS,
    folder: str | Path = "out/compare",
    *,
    draws: int = DRAWS,
    seed: int = SEED,
    threads: int | None = None,
    contenders: Sequence[Contender] = CONTENDERS,
    force: bool = False,
    console: Console | None = None,
) -> Comparison:
    """Tunes every contender on every task and writes what came of it.

    Args:
        names: spatial scenarios, files or shipped names.
        folder: to write.
        draws: sets of gains for each contender on each task.
        seed: of the draws, and of the noise while tuning; the tables' flights have the scenarios'
            own.
        threads: None for one a processor.
        contenders: who takes part.
        force: replace an earlier result.
        console: where progress goes; nowhere without it.

    Returns:
        What came of it; in the folder ``report.html``, ``comparison.md``, ``comparison.json``,
        ``figures/`` and ``flights/``, every tuned flight as a scenario file.

    Raises:
        ScenarioError: for a task that cannot be read or is not in space.
        MultiliftError: if a law has no gains for a task's formation.
        MissingExtraError: without SciPy, matplotlib or Jinja2.
        OutputError: if the folder is taken or cannot be written.
    """
    if draws < 1:
        raise MultiliftError(f"draws = {draws}: give at least one set of gains")
    scenarios = [_task(name) for name in names]
    titles = [scenario.name for scenario in scenarios]
    for title in titles:
        if titles.count(title) > 1:
            raise ScenarioError("is given twice", where=title, advice="name each task once")
    folder = Path(folder)
    with storage.new_folder(folder, force=force) as made:
        with Progress(
            TextColumn("{task.description:<44}"),
            BarColumn(),
            TextColumn("{task.completed:,}/{task.total:,} flights"),
            TimeRemainingColumn(),
            console=console or Console(quiet=True),
        ) as bar:
            total = bar.add_task("", total=len(scenarios) * len(contenders) * draws)
            tasks = []
            done = 0
            for scenario in scenarios:
                results = []
                for contender in contenders:
                    bar.update(total, description=f"{scenario.name}: {contender.label}")

                    def show(flown: int, before: int = done) -> None:
                        bar.update(total, completed=before + flown)

                    results.append(
                        tune(scenario, contender, draws, seed, threads=threads, progress=show)
                    )
                    done += draws
                tasks.append(Task(scenario, results))
            bar.update(total, completed=done)
        result = Comparison(tasks, draws, seed, folder)
        _write(result, made)
    return result


def _task(name: str) -> SpatialScenario:
    scenario = load(name)
    if not isinstance(scenario, SpatialScenario):
        raise ScenarioError(
            "is not compared: the laws are those of the spatial plant", where=name,
            key="plant.model", value=scenario.model.name, permitted="spatial",
            advice="'multilift reproduce' compares laws on planar scenarios",
        )  # fmt: skip
    return scenario


def _write(result: Comparison, folder: Path) -> None:
    (folder / "figures").mkdir()
    (folder / "flights").mkdir()
    figures = {}
    for task in result.tasks:
        name = task.scenario.name
        figures[name] = draw(task.results)
        (folder / "figures" / f"{name}.png").write_bytes(figures[name])
        for r in task.results:
            file = folder / "flights" / f"{name}-{r.contender.name}.toml"
            file.write_text(r.run.scenario.to_toml(), encoding="utf-8")
    content = result.to_json()
    write_json(folder / "comparison.json", content)
    (folder / "comparison.md").write_text(tables.markdown(content), encoding="utf-8")
    (folder / "report.html").write_text(page.render(result, figures), encoding="utf-8")
    write_json(folder / "run.json", provenance.describe())


def _entry(r: Tuned) -> dict[str, Any]:
    metrics: Mapping[str, float] = r.run.metrics
    return {
        "drawn": dict(r.drawn),
        "cost": finite(r.cost),
        "finished": r.finished,
        "ending": r.run.ending,
        "metrics": {name: finite(metrics[name]) for name in tables.SHOWN},
    }
