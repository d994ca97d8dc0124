"""Chunks on the machines of a Ray cluster; this process only collects and writes them.

A chunk is a task: what it draws is a function of its number, so it may run anywhere and again.
Tasks lost with their worker or machine are started again; the rows do not depend on it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from multilift import provenance
from multilift.errors import MissingExtraError, MultiliftError
from multilift.study import rows
from multilift.study.rows import Chunk
from multilift.study.spec import Study
from multilift.study.store import SAME

#: Beginnings of one chunk before the study is given up: its machine may die, not every machine.
ATTEMPTS = 8


class ClusterError(MultiliftError):
    """A Ray cluster that cannot be reached, or whose machines do not fit together."""


def chunks(
    study: Study,
    ranges: Sequence[tuple[int, int]],
    *,
    keep: Callable[[Chunk], None],
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Iterator[Chunk]:
    """Simulates ranges of worlds on the cluster, in the order in which they finish.

    Uses the cluster this process is connected to, else the one at RAY_ADDRESS or running on this
    machine; without any, Ray starts one of this machine alone.

    Args:
        study: what to simulate.
        ranges: first world of each chunk, and the one after its last.
        keep: told each chunk, before it is yielded.
        threads: processors that each task takes and threads it runs; 1 if None.
        progress: told of nothing: tasks run elsewhere.

    Raises:
        ClusterError: if a chunk was lost too often, or a machine has another multilift.
        MissingExtraError: without Ray.
    """
    del progress
    ray = _connect()
    threads = threads or 1
    task = ray.remote(num_cpus=threads, max_retries=0)(_work)
    shared = ray.put((study, _version(), threads))
    waiting = list(reversed(ranges))
    begun = dict.fromkeys(ranges, 0)
    running: dict[Any, tuple[int, int]] = {}
    while waiting or running:
        # Twice as many under way as can run: no machine waits, and little memory is held.
        room = 2 * max(1, int(ray.cluster_resources().get("CPU", 1)) // threads)
        while waiting and len(running) < room:
            piece = waiting.pop()
            begun[piece] += 1
            running[task.remote(shared, *piece)] = piece
        done, _ = ray.wait(list(running), num_returns=1, timeout=1.0)
        for reference in done:
            piece = running.pop(reference)
            try:
                made = ray.get(reference)
            except ray.exceptions.RayTaskError as error:
                cause = error.cause
                if isinstance(cause, MultiliftError):
                    raise cause from None
                raise ClusterError(f"worlds {piece[0]} to {piece[1] - 1}: {error}") from None
            except ray.exceptions.RayError as error:  # its worker, machine or result is gone
                if begun[piece] >= ATTEMPTS:
                    raise ClusterError(
                        f"worlds {piece[0]} to {piece[1] - 1} were lost {ATTEMPTS} times, last: "
                        f"{type(error).__name__}\n  what to do: look at the cluster "
                        "('ray status'), smaller --chunk for little memory; the same command goes "
                        "on where this one stopped"
                    ) from None
                waiting.append(piece)
            else:
                keep(made)
                yield made


def _work(shared: tuple[Study, dict[str, str], int], start: int, stop: int) -> Chunk:
    """One chunk, on whatever machine."""
    study, version, threads = shared
    here = _version()
    if here != version:
        raise ClusterError(
            f"machine {os.uname().nodename} has another multilift or processor: {here} instead of "
            f"{version}\n  what to do: install the same on every machine; bits may differ otherwise"
        )
    return rows.fly(study, start, stop, threads=threads).chunk()


def _version() -> dict[str, str]:
    return {k: v for k, v in provenance.describe().items() if k in SAME}


def _connect() -> Any:
    try:
        import ray  # noqa: PLC0415 - heavy, and optional
    except ImportError:
        raise MissingExtraError("ray", "ray", "--engine ray") from None
    if not ray.is_initialized():
        try:
            ray.init(address=os.environ.get("RAY_ADDRESS") or "auto", log_to_driver=False)
        except ConnectionError as error:
            if os.environ.get("RAY_ADDRESS"):
                raise ClusterError(
                    f"no Ray cluster answers at {os.environ['RAY_ADDRESS']}: {error}\n"
                    "  what to do: start it, or mend RAY_ADDRESS"
                ) from None
            ray.init(log_to_driver=False, include_dashboard=False)
    return ray
