"""A benchmark's rows: one measured number each, with the goal it stands against."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.table import Table


@dataclass(frozen=True)
class Row:
    """One measured number.

    Attributes:
        key: its short name, for programs.
        label: what was measured.
        median: over the repetitions; None if it could not be measured.
        best: the least time or the greatest rate; of a ratio, that of the best.
        unit: of both; "" for a ratio.
        note: the goal it stands against, or what it leaves out.
    """

    key: str
    label: str
    median: float | None
    best: float | None
    unit: str
    note: str


def timed(key: str, label: str, times: Sequence[float], note: str) -> Row:
    """The row of times, ns a step."""
    return Row(key, label, statistics.median(times), min(times), "ns a step", note)


def ratio(key: str, label: str, slow: Sequence[float], fast: Sequence[float], note: str) -> Row:
    """The row that says how many times one time is another."""
    median = statistics.median(slow) / statistics.median(fast)
    return Row(key, label, median, min(slow) / min(fast), "", note)


def nanoseconds(work: Callable[[], Any], steps: int, *, wall: bool = False) -> float:
    """How long some work takes, ns for each of its steps.

    Args:
        work: what to do.
        steps: how many steps that is.
        wall: by the clock on the wall, for work on several threads; otherwise the processor's time,
            in which waiting for a core that is busy elsewhere does not count.
    """
    clock = time.perf_counter_ns if wall else time.process_time_ns
    start = clock()
    work()
    return (clock() - start) / steps


def print_rows(rows: Sequence[Row], console: Console) -> None:
    """Prints what was measured as a table."""
    table = Table("measured", box=None, header_style="bold")
    for heading in ("median", "best"):
        table.add_column(heading, justify="right")
    table.add_column("")
    table.add_column("note")
    for row in rows:
        table.add_row(row.label, digits(row.median), digits(row.best), row.unit, row.note)
    console.print(table)


def digits(x: float | None) -> str:
    """A number as a table shows it: three digits, whole from a hundred on."""
    return "" if x is None else f"{x:.0f}" if x >= 99.5 else f"{x:.3g}"
