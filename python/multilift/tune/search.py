"""The search itself: sets of numbers flown generation by generation, every one remembered.

Each generation is one line of a file, written before the next begins. A search that was killed
replays its strategy with the lines that are there and flies only what is missing, so that it ends
with the same bits as one that was not.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from multilift import simulate_batch
from multilift.errors import OutputError
from multilift.storage import as_output_error
from multilift.study.spec import Study
from multilift.study.vary import Array
from multilift.tune import gradients
from multilift.tune.goals import not_dominated
from multilift.tune.spec import Tuning, worlds_of
from multilift.tune.strategies import Strategy, descents, front

#: The file of generations.
FILE = "generations.jsonl"

_AGAIN = "\n  what to do: choose another folder, or begin again with --force"


@dataclass(frozen=True)
class Found:
    """Everything that a search has flown.

    Attributes:
        tuning: what was searched.
        points: of the unit cube, shape (N, dimensions).
        figures: of each; see `Goal.figures`.
        replayed: how many of them an earlier search had flown.
    """

    tuning: Tuning
    points: Array
    figures: Array
    replayed: int

    @property
    def best(self) -> int:
        """Which is the best, the first of equals; of a front, the even compromise."""
        goal = self.tuning.goal
        scales = None
        if goal.combine == "front" and len(self.front()):
            known = self.figures[self.front(), : len(goal.objectives)]
            ideal, worst = known.min(axis=0), known.max(axis=0)
            scales = (np.ones(known.shape[1]), ideal, np.where(worst > ideal, worst - ideal, 1.0))
        return int(np.lexsort(goal.order(self.figures, scales).T[::-1])[0])

    def front(self) -> NDArray[np.intp]:
        """Those that keep the constraints and to which none is better in every objective."""
        goal = self.tuning.goal
        values = self.figures[:, : len(goal.objectives)]
        allowed = np.isfinite(values).all(axis=1) & (goal.violations(self.figures) == 0)
        kept = np.flatnonzero(allowed)
        return np.asarray(kept[not_dominated(values[kept])], dtype=np.intp)

    def numbers(self, which: int) -> dict[str, float]:
        """One set of numbers, by name."""
        rows = self.tuning.space.numbers(self.points[which : which + 1])
        return {name: float(x[0]) for name, x in rows.items()}

    def values(self, which: int) -> dict[str, float]:
        """The objectives of one set, by metric; NaN where there is none."""
        goal = self.tuning.goal
        rows = goal.values(self.figures[which])
        return {o.metric: float(x) for o, x in zip(goal.objectives, rows, strict=True)}


def fly(
    tuning: Tuning,
    points: Array | None,
    threads: int | None = None,
    *,
    over: Study | None = None,
) -> Array:
    """The figures of sets of numbers, each flown in every world of the tuning.

    Args:
        tuning: scenario, worlds and goal.
        points: of the unit cube, shape (N, dimensions); None for the scenario as it is.
        threads: of the batch engine; its own choice if None.
        over: other worlds than the tuning's.
    """
    study = over or tuning.over
    drawn, worlds = worlds_of(study, tuning.scenario.law)
    count = 1 if points is None else len(points)
    overrides = {key: np.concatenate([x] * count) for key, x in drawn.items()}
    if points is not None:
        own = tuning.space.overrides(tuning.scenario, tuning.space.numbers(points))
        overrides |= {key: np.repeat(x, worlds, axis=0) for key, x in own.items()}
    flown = tuning.scenario if study is None else study.scenario
    batch = simulate_batch(flown, overrides, count=count * worlds, threads=threads)
    return tuning.goal.figures(batch, worlds)


def search(
    tuning: Tuning,
    file: Path,
    *,
    threads: int | None = None,
    progress: Callable[[Found], None] | None = None,
) -> Found:
    """Searches, or goes on behind the generations that a file holds.

    Args:
        tuning: what to search.
        file: one line a generation; made if it is not there.
        threads: of the batch engine; its own choice if None.
        progress: called after each generation that was flown.

    Raises:
        MissingExtraError: without cma.
        OutputError: if the file holds another search's generations, or cannot be written.
    """
    kept, complete = _read(file, tuning)
    points = np.zeros((0, tuning.space.dimensions))
    figures = np.zeros((0, _columns(tuning)))
    replayed = 0
    strategy = _strategy(tuning)
    with _behind(file, complete) as stream:
        asked = next(strategy, None)
        earlier: Iterator[tuple[Array, Array]] = iter(kept)
        while asked is not None:
            known = next(earlier, None)
            if known is None:
                told = fly(tuning, asked, threads)
                _write(stream, file, {"points": asked.tolist(), "figures": told.tolist()})
            elif np.array_equal(known[0], asked):
                told = known[1]
                replayed += len(told)
            else:
                raise OutputError(
                    f"{file} holds a search that chose other numbers, as by another version of "
                    f"its packages{_AGAIN}"
                )
            points, figures = np.concatenate([points, asked]), np.concatenate([figures, told])
            if known is None and progress is not None:
                progress(Found(tuning, points, figures, replayed))
            try:
                asked = strategy.send(told)
            except StopIteration:
                asked = None
    return Found(tuning, points, figures, replayed)


def _strategy(tuning: Tuning) -> Strategy:
    goal, last = tuning.goal, gradients.budget(tuning)
    chosen = front if goal.combine == "front" else descents
    first = chosen(goal, tuning.space.dimensions, tuning.seed, tuning.budget - last,
                   tuning.population, tuning.start())  # fmt: skip
    return gradients.polished(tuning, first) if last else first


def _columns(tuning: Tuning) -> int:
    return len(tuning.goal.objectives) + len(tuning.goal.constraints) + 2


def _read(file: Path, tuning: Tuning) -> tuple[list[tuple[Array, Array]], int]:
    """The complete generations of a file, and their bytes; a line half written is left out."""
    try:
        content = file.read_bytes() if file.exists() else b""
    except OSError as error:
        raise OutputError(f"{file} cannot be read: {error}") from None
    lines = content.split(b"\n")[:-1]
    result = []
    for number, line in enumerate(lines, start=1):
        try:
            kept = json.loads(line)
            points = np.array(kept["points"], dtype=float).reshape(-1, tuning.space.dimensions)
            figures = np.array(kept["figures"], dtype=float).reshape(len(points), _columns(tuning))
        except (ValueError, KeyError, TypeError):
            raise OutputError(f"{file}, line {number}, is damaged{_AGAIN}") from None
        result.append((points, figures))
    return result, sum(len(line) + 1 for line in lines)


def _behind(file: Path, complete: int) -> BinaryIO:
    """The file, to be written behind its complete lines, which are not touched."""
    try:
        stream = file.open("r+b" if file.exists() else "xb")
        stream.truncate(complete)
        stream.seek(complete)
    except OSError as error:
        raise as_output_error(error, file) from None
    return stream


def _write(stream: BinaryIO, file: Path, generation: dict[str, list[float]]) -> None:
    try:
        stream.write(json.dumps(generation).encode() + b"\n")
        stream.flush()
    except OSError as error:
        raise as_output_error(error, file) from None
