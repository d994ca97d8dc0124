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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import simulate_batch
from multilift.errors import OutputError
from multilift.study.vary import Array
from multilift.tune.goals import not_dominated
from multilift.tune.spec import Tuning
from multilift.tune.strategies import Strategy, descents, front

#: The file of generations.
FILE = "generations.jsonl"


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
        """Which is the best; the first of equals."""
        return int(np.lexsort(self.tuning.goal.order(self.figures).T[::-1])[0])

    def front(self) -> NDArray[np.intp]:
        """Those that keep the constraints and to which none is better in every objective."""
        goal = self.tuning.goal
        values = self.figures[:, : len(goal.objectives)]
        kept = np.flatnonzero(np.isfinite(values).all(axis=1) & (goal.violations(self.figures) == 0))
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


def fly(tuning: Tuning, points: Array, threads: int | None = None) -> Array:
    """The figures of sets of numbers, each flown in every world of the tuning.

    Args:
        tuning: scenario, worlds and goal.
        points: of the unit cube, shape (N, dimensions).
        threads: of the batch engine; its own choice if None.
    """
    own = tuning.space.overrides(tuning.scenario, tuning.space.numbers(points))
    drawn = tuning.world_numbers()
    worlds = tuning.worlds
    overrides = {key: np.repeat(x, worlds, axis=0) for key, x in own.items()}
    overrides |= {key: np.concatenate([x] * len(points)) for key, x in drawn.items()}
    batch = simulate_batch(tuning.flown, overrides, count=len(points) * worlds, threads=threads)
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
        OutputError: if the file holds other generations, or cannot be written.
    """
    kept = _read(file, tuning)
    points = np.zeros((0, tuning.space.dimensions))
    figures = np.zeros((0, len(tuning.goal.objectives) + len(tuning.goal.constraints) + 2))
    replayed = 0
    strategy = _strategy(tuning)
    with _opened(file, kept) as stream:
        asked = next(strategy, None)
        earlier: Iterator[tuple[Array, Array]] = iter(kept)
        while asked is not None:
            known = next(earlier, None)
            if known is None:
                told = fly(tuning, asked, threads)
                line = json.dumps({"points": asked.tolist(), "figures": told.tolist()})
                try:
                    stream.write(line + "\n")
                    stream.flush()
                except OSError as error:
                    raise OutputError(f"{file} cannot be written: {error}") from None
            elif np.array_equal(known[0], asked):
                told = known[1]
                replayed += len(told)
            else:
                raise OutputError(
                    f"{file} holds a search that chose other numbers, as by another version of "
                    "its packages\n  what to do: choose another folder, or begin again with --force"
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
    chosen = front if tuning.goal.combine == "front" else descents
    return chosen(tuning.goal, tuning.space.dimensions, tuning.seed, tuning.budget,
                  tuning.population, tuning.start())  # fmt: skip


def _read(file: Path, tuning: Tuning) -> list[tuple[Array, Array]]:
    """The complete generations of a file; a last line that was being written is left out."""
    try:
        text = file.read_text(encoding="utf-8") if file.exists() else ""
    except (OSError, UnicodeDecodeError) as error:
        raise OutputError(f"{file} cannot be read: {error}") from None
    columns = len(tuning.goal.objectives) + len(tuning.goal.constraints) + 2
    result = []
    for number, line in enumerate(text.split("\n")[:-1], start=1):
        try:
            kept = json.loads(line)
            points = np.array(kept["points"], dtype=float).reshape(-1, tuning.space.dimensions)
            figures = np.array(kept["figures"], dtype=float).reshape(len(points), columns)
        except (ValueError, KeyError, TypeError):
            raise OutputError(
                f"{file}, line {number}, is damaged\n  what to do: begin again with --force"
            ) from None
        result.append((points, figures))
    return result


def _opened(file: Path, kept: list[tuple[Array, Array]]) -> Any:
    """The file to write behind its complete lines."""
    try:
        lines = file.read_bytes().split(b"\n")[: len(kept)] if kept else []
        stream = file.open("w", encoding="utf-8")
        stream.writelines(line.decode() + "\n" for line in lines)
        stream.flush()
    except OSError as error:
        raise OutputError(f"{file} cannot be written: {error}") from None
    return stream
