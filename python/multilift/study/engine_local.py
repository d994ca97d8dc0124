"""Chunks one after the other in this process, each on all threads of the batch engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

from multilift.study import rows
from multilift.study.rows import Chunk, Flown
from multilift.study.spec import Study


def chunks(
    study: Study,
    ranges: Sequence[tuple[int, int]],
    *,
    keep: Callable[[Chunk], None],
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Iterator[Chunk]:
    """Simulates ranges of worlds; a chunk is made and kept while the next one is simulated.

    Args:
        study: what to simulate.
        ranges: first world of each chunk, and the one after its last.
        keep: told each chunk, in another thread, before it is yielded.
        threads: of the batch engine; None for its own choice.
        progress: told how many runs of the chunk under way are done.

    Raises:
        ScenarioError: if a world is drawn that the scenario does not permit.
        Exception: whatever `keep` raises.
    """

    def finish(flown: Flown) -> Chunk:
        chunk = flown.chunk()
        keep(chunk)
        return chunk

    with ThreadPoolExecutor(max_workers=1) as aside:
        last: Future[Chunk] | None = None
        for start, stop in ranges:
            flown = rows.fly(study, start, stop, threads=threads, progress=progress)
            if last is not None:
                yield last.result()
            last = aside.submit(finish, flown)
        if last is not None:
            yield last.result()
