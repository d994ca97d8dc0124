"""What a study under way shows: share done, rate, remaining time."""

from __future__ import annotations

import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from multilift.study.rows import Chunk


class Meter:
    """Counts runs and simulated time, and shows them where there is a console."""

    def __init__(self, runs: int, done: int, laws: int, console: Console | None) -> None:
        """Begins to count.

        Args:
            runs: worlds times laws of the whole study.
            done: of these, found finished.
            laws: how many; rates are in runs.
            console: where the bar goes; none without it.
        """
        self.laws = laws
        self.runs = runs
        self.found = self.done = done
        self.under_way = 0
        self.kernel_seconds = self.simulated_seconds = 0.0
        self.begin = time.perf_counter()
        self._progress = Progress(
            TextColumn("{task.description:<20}"),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn("{task.fields[rate]}"),
            console=console or Console(quiet=True),
        )
        self._task = self._progress.add_task("simulating", total=runs, completed=done, rate="")

    def __enter__(self) -> Meter:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def say(self, what: str) -> None:
        """Names what is being done now."""
        self._progress.update(self._task, description=what)

    def part(self, runs: int) -> None:
        """So many runs of the chunk under way are done."""
        self.under_way = runs
        self._show()

    def add(self, chunk: Chunk) -> None:
        """A chunk is on the disk."""
        self.under_way = 0
        self.done += (chunk.stop - chunk.start) * self.laws
        self.kernel_seconds += chunk.kernel_seconds
        self.simulated_seconds += chunk.simulated_seconds
        self._show()

    def seconds(self) -> float:
        """Wall time since the beginning."""
        return time.perf_counter() - self.begin

    def _show(self) -> None:
        now = self.done + self.under_way
        elapsed = self.seconds()
        fresh = now - self.found
        rate = fresh / elapsed if elapsed > 0 else 0.0  # runs: worlds times laws
        text = f"{rate / self.laws:,.4g} worlds/s"
        if self.simulated_seconds:
            share = (self.done - self.found) / max(fresh, 1)
            text += f", {self.simulated_seconds / max(share, 1e-9) / elapsed:,.4g} simulated s/s"
        if rate > 0:
            text += f", {duration((self.runs - now) / rate)} left"
        self._progress.update(self._task, completed=now, rate=text)


def duration(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    return (
        f"{minutes // 60} h {minutes % 60:02d} min" if minutes < 6000 else f"{minutes / 1440:.1f} d"
    )
