"""The comparison's numbers as tables: which, in what units, with how many digits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from multilift.compare.contenders import CONTENDERS

LABELS = {c.name: c.label for c in CONTENDERS}


@dataclass(frozen=True)
class Shown:
    """A column: its head, the metric's factor to the head's unit, digits after the point."""

    head: str
    factor: float = 1.0
    digits: int = 1


#: Metrics of the tables.
SHOWN = {
    "payload_settling_time": Shown("settled (s)"),
    "payload_error_rms": Shown("error (cm)", 100.0),
    "peak_swing": Shown("swing (°)"),
    "swing_settling_time": Shown("still (s)"),
    "payload_tilt_max": Shown("tilt (°)"),
    "payload_yaw_error_max": Shown("heading (°)"),
}

#: What the heads mean.
LEGEND = (
    "Settled: when the payload stays within 2 cm of its target. Error: its distance from there, "
    "root mean square. Swing: the cables' peak angle from their directions at rest. Still: when "
    "all stay within 1° of these. Tilt, heading: the payload's greatest, from level and from its "
    "target. A dash: not before the end. Cost: what tuning made small. Flew: the share of the sets "
    "of gains that reached the flight's end."
)


def number(value: float | None, factor: float = 1.0, digits: int = 1) -> str:
    """A metric as the tables show it; a dash where there is none, such as never settled."""
    return "–" if value is None else f"{factor * value:.{digits}f}"


def cells(entry: Mapping[str, Any], draws: int) -> list[str]:
    """A contender's row after its name: the metrics, the cost, the share of sets that flew."""
    shown = [number(entry["metrics"][name], s.factor, s.digits) for name, s in SHOWN.items()]
    return [
        *shown,
        number(entry["cost"], digits=2),
        f"{100 * entry['finished'] / draws:.0f}\u00a0%",
    ]


def heads() -> list[str]:
    """Of `cells`."""
    return [*(s.head for s in SHOWN.values()), "cost", "flew"]


def task_table(entries: Mapping[str, Mapping[str, Any]], draws: int) -> str:
    """One task as a Markdown table."""
    lines = ["| law | " + " | ".join(heads()) + " |"]
    lines.append("|---|" + "--:|" * len(heads()))
    for name, entry in entries.items():
        lines.append(f"| {LABELS.get(name, name)} | " + " | ".join(cells(entry, draws)) + " |")
    return "\n".join(lines) + "\n"


def gains_table(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """The drawn numbers of the best sets as a Markdown table."""
    lines = ["| law | best of its sets |", "|---|---|"]
    for name, entry in entries.items():
        drawn = ", ".join(f"`{key}` {value:.3g}" for key, value in entry["drawn"].items())
        lines.append(f"| {LABELS.get(name, name)} | {drawn} |")
    return "\n".join(lines) + "\n"


def markdown(content: Mapping[str, Any]) -> str:
    """All tasks, each with its table, figure and gains."""
    parts = [f"{LEGEND}\n"]
    for name, entries in content["tasks"].items():
        parts.append(
            f"## {name}\n\n{task_table(entries, content['draws'])}\n"
            f"![Error, swing and tuning of every law on {name}](figures/{name}.png)\n\n"
            f"{gains_table(entries)}"
        )
    return "\n".join(parts)
