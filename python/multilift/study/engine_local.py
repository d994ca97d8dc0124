"""Chunks one after the other in this process, each on all threads of the batch engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from multilift.study import rows
from multilift.study.rows import Chunk
from multilift.study.spec import Study


def chunks(
    study: Study,
    ranges: Sequence[tuple[int, int]],
    *,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Iterator[Chunk]:
    """Simulates ranges of worlds.

    Args:
        study: what to simulate.
        ranges: first world of each chunk, and the one after its last.
        threads: of the batch engine; None for its own choice.
        progress: told how many runs of the chunk under way are done.

    Raises:
        ScenarioError: if a world is drawn that the scenario does not permit.
    """
    for start, stop in ranges:
        yield rows.simulate(study, start, stop, threads=threads, progress=progress)
