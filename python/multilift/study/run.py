"""Running a study: from its file to rows, summary, figures and report."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from multilift import provenance
from multilift.errors import MissingExtraError, MultiliftError
from multilift.storage import write_whole
from multilift.study.progress import Meter
from multilift.study.spec import Study
from multilift.study.store import open_store
from multilift.study.summary import Summary, summarise

try:
    from multilift.study import page
except ImportError as error:
    if isinstance(error, MissingExtraError):
        raise
    raise MissingExtraError(str(error.name), "study", "multilift study") from None

ENGINES = ("local", "ray")


@dataclass(frozen=True)
class Cost:
    """What this run of the command took; earlier runs that it continued are not in it.

    Attributes:
        runs: worlds times laws simulated now; `found` were there already.
        simulated_seconds: simulated time of these runs.
        kernel_seconds: wall time in the compiled kernel, of all tasks together.
        wall_seconds: from the beginning of the run, or of the command, to the finished report.
    """

    runs: int
    found: int
    simulated_seconds: float
    kernel_seconds: float
    wall_seconds: float

    @property
    def rate(self) -> float:
        """Simulated seconds in one second of wall time."""
        return self.simulated_seconds / self.wall_seconds

    @property
    def outside(self) -> float:
        """Share of the wall time outside the compiled kernel; meaningful for the local engine."""
        return max(0.0, 1.0 - self.kernel_seconds / self.wall_seconds)


@dataclass(frozen=True)
class Result:
    """Where the report lies, what it says, what it took.

    Attributes:
        damaged: parts found damaged on the disk, which were made again.
    """

    report: Path
    summary: Summary
    cost: Cost
    damaged: tuple[str, ...]


def run(
    study: Study,
    folder: str | Path,
    *,
    engine: str = "local",
    threads: int | None = None,
    chunk: int | None = None,
    force: bool = False,
    console: Console | None = None,
    begun: float | None = None,
) -> Result:
    """Runs a study, or goes on with one that was interrupted.

    Args:
        study: from `load`.
        folder: for rows, summary, figures and report; where it holds a part of the same study,
            this goes on behind it.
        engine: "local" or "ray".
        threads: of the batch engine; None for its own choice (with Ray: 1 a task).
        chunk: worlds in each part; None for what the folder has, or 8192.
        force: remove an earlier result there.
        console: where the progress goes; nowhere without it.
        begun: when the command began, by ``time.perf_counter()``, for what it took; now if None.

    Raises:
        OutputError: if the folder cannot be used or written.
        ScenarioError: if a world is drawn that the scenario does not permit.
        MultiliftError: from the Ray engine.
    """
    if engine not in ENGINES:
        raise MultiliftError(f"no engine is called {engine!r}\n  permitted: {', '.join(ENGINES)}")
    folder = Path(folder)
    laws = len(study.controllers)
    begin = time.perf_counter() if begun is None else begun
    with open_store(folder, study, chunk=chunk, force=force) as store:
        missing = store.missing()
        ranges = [store.range(number) for number in missing]
        runs = sum(stop - start for start, stop in ranges) * laws
        found = study.worlds * laws - runs
        _announce(console, store.finished, store.chunks, store.damaged)
        with Meter(study.worlds * laws, found, laws, console) as meter:
            if ranges:
                if engine == "ray":
                    from multilift.study.engine_ray import chunks  # noqa: PLC0415 - loads Ray
                else:
                    from multilift.study.engine_local import chunks  # noqa: PLC0415
                for made in chunks(
                    study, ranges, keep=store.write, threads=threads, progress=meter.part
                ):
                    meter.add(made)
            meter.say("summing up")
            summary = summarise(store)
            meter.say("drawing")
            cost = Cost(runs, found, meter.simulated_seconds, meter.kernel_seconds,
                        time.perf_counter() - begin)  # fmt: skip
            page.write(store, summary)
            meter.say("done")
        about = {**summary.to_json(), "made_by": provenance.describe()}
        write_whole(folder / "summary.json", (json.dumps(about, indent=2) + "\n").encode())
        write_whole(folder / "scenario.toml", study.scenario.to_toml().encode())
        cost = Cost(runs, found, cost.simulated_seconds, cost.kernel_seconds,
                    time.perf_counter() - begin)  # fmt: skip
        return Result(folder / "report.html", summary, cost, tuple(store.damaged))


def _announce(console: Console | None, finished: int, chunks: int, damaged: list[str]) -> None:
    if console is None:
        return
    for name in damaged:
        console.print(
            f"[yellow]damaged:[/] {name}; its worlds are simulated again", highlight=False
        )
    if finished == chunks:
        console.print("every chunk is there: summary and report are made again", highlight=False)
    elif finished:
        console.print(f"going on: {finished} of {chunks} chunks are there", highlight=False)
