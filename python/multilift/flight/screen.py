"""A snapshot as a terminal shows it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from multilift.flight.snapshot import Margin, Snapshot, VehicleShown
from multilift.flight.supervisor import State, Word

#: The pilot's keys and what they say; go and start share one, as only one of them is ever open.
KEYS = {
    "\r": (Word.START, Word.GO),
    "\n": (Word.START, Word.GO),
    " ": (Word.HOLD,),
    "l": (Word.LAND,),
    "k": (Word.KILL,),
}

_NAMES = {
    Word.START.value: ("Enter", "begin the checks"),
    Word.GO.value: ("Enter", "go"),
    Word.HOLD.value: ("Space", "hold"),
    Word.LAND.value: ("l", "land all"),
    Word.KILL.value: ("k", "kill: motors off"),
}

_BAD_STATES = (State.HOLD.value, State.LAND_APART.value, State.KILL.value)
_BAR = 12

#: Where a margin turns yellow, and red.
_NEAR, _AT = 0.6, 0.9


def screen(snapshot: Snapshot, asked: str = "") -> RenderableType:
    """All of a snapshot.

    Args:
        snapshot: shown.
        asked: a question to the pilot in the place of the keys; "" for none.
    """
    middle = Table.grid(expand=True, padding=(0, 1))
    middle.add_column(ratio=3)
    middle.add_column(ratio=2)
    middle.add_row(
        Group(_vehicles(snapshot), _bottom(snapshot)), Group(_margins(snapshot), _rest(snapshot))
    )
    return Group(_head(snapshot), middle, _keys(snapshot, asked))


def _head(shown: Snapshot) -> RenderableType:
    grid = Table.grid(expand=True)
    grid.add_column()
    grid.add_column(justify="center")
    grid.add_column(justify="right")
    bad = shown.state in _BAD_STATES
    colours = "bold white on red" if bad else "bold black on green"
    state = Text.assemble((f" {shown.state} ", colours), f" {shown.lasted:.1f} s")
    what = Text("twin: nothing real" if shown.twin else "HARDWARE",
                style="cyan" if shown.twin else "bold yellow")  # fmt: skip
    name = Text.assemble((shown.title, "bold"), ("  " + shown.scenario, "dim"))
    grid.add_row(name, state, Text.assemble(what, f"   {shown.time:.1f} s"))
    return Panel(grid, style="default", border_style="red" if bad else "green")


def _vehicles(shown: Snapshot) -> RenderableType:
    table = Table(expand=True, box=None, padding=(0, 1))
    table.add_column("", style="dim")
    for v in shown.vehicles:
        table.add_column(f"{v.name} [dim]({v.firmware} {v.system})[/]", justify="right")
    rows: Sequence[tuple[str, Callable[[VehicleShown], Text]]] = (
        ("order", lambda v: Text(v.order)),
        ("mode", lambda v: _either(v.mode, v.mode != "unknown")),
        ("armed", lambda v: Text("ARMED", style="bold yellow") if v.armed else Text("no")),
        ("link age", lambda v: _number(v.link_age, "s", 2)),
        ("battery", _battery),
        ("height", lambda v: _number(v.position[2], "m", 2)),
        ("off its place", lambda v: _number(_times(v.error, 100.0), "cm", 1)),
        ("speed", lambda v: _number(math.hypot(*v.velocity), "m/s", 2)),
        ("thrust", lambda v: _number(v.thrust, "N", 1)),
        ("swing", lambda v: _number(_times(v.swing, 180.0 / math.pi), "°", 1)),
        ("tension", lambda v: _number(v.tension, "N", 1)),
    )
    for name, cell in rows:
        table.add_row(name, *(cell(v) for v in shown.vehicles))
    dropped = [sum(v.dropped.values()) for v in shown.vehicles]
    if any(dropped):
        table.add_row("dropped", *(str(n) for n in dropped))
    return Panel(table, title="vehicles", border_style="dim")


def _margins(shown: Snapshot) -> RenderableType:
    table = Table.grid(expand=True, padding=(0, 1))
    table.add_column()
    table.add_column()
    table.add_column(justify="right")
    for margin in shown.margins:
        table.add_row(Text(margin.name.replace("_", " "), style="dim"), _bar(margin), _of(margin))
    return Panel(table, title="margins", border_style="dim")


def _bar(margin: Margin) -> Text:
    used = margin.used
    if used is None:
        return Text("?" * _BAR, style="dim")
    full = min(round(used * _BAR), _BAR)
    colour = "red" if used >= _AT else "yellow" if used >= _NEAR else "green"
    return Text.assemble(("█" * full, colour), ("·" * (_BAR - full), "dim"))


def _of(margin: Margin) -> Text:
    value, limit, unit = margin.value, margin.limit, margin.unit
    if unit == "rad":
        value, limit, unit = _times(value, 180.0 / math.pi), limit * 180.0 / math.pi, "°"
    shown = "–" if value is None else f"{value:.2f}"
    return Text(f"{shown} / {limit:.3g} {unit}")


def _rest(shown: Snapshot) -> RenderableType:
    table = Table.grid(expand=True, padding=(0, 1))
    table.add_column(style="dim")
    table.add_column(justify="right")
    capture, timing, load = shown.capture, shown.timing, shown.payload
    well = capture.quality == "good"
    table.add_row("motion capture", _either(capture.fault or capture.quality, well))
    table.add_row("its age", _number(_times(capture.age, 1e3), "ms", 0))
    table.add_row("load off its path", _number(_times(load.error, 100.0), "cm", 1))
    table.add_row("loop", Text(f"{timing.rate:.0f} Hz, {timing.missed} of {timing.ticks} missed"))
    table.add_row("late", _pair(timing.late_median, "at most", timing.late_most))
    latency = _pair(timing.latency_median, "99.9 %:", timing.latency_999)
    table.add_row("capture to command", latency)
    log = Text("none") if not shown.log else Text(shown.log, overflow="ellipsis", no_wrap=True)
    table.add_row("log", log)
    if shown.unlogged:
        table.add_row("not logged", Text(str(shown.unlogged), style="red"))
    return Panel(table, title="loop", border_style="dim")


def _bottom(shown: Snapshot) -> RenderableType:
    if shown.checks:
        failed = [name for name, passed in shown.checks if not passed]
        passed = [name for name, passed in shown.checks if passed]
        lines = [Text.assemble(("✗ ", "red"), name) for name in failed[:8]]
        if len(failed) > 8:
            lines.append(Text(f"  and {len(failed) - 8} more", style="dim"))
        for a, b in zip(passed[::2], [*passed[1::2], ""], strict=False):
            lines.append(Text.assemble(("✓ ", "green"), f"{a:34.34}",
                                       ("✓ " if b else "", "green"), b))  # fmt: skip
        for line in lines:
            line.no_wrap, line.overflow = True, "ellipsis"
        return Panel(Group(*lines), title="pre-flight checks", border_style="dim")
    said = [Text(f"{h.time:7.1f}  {h.text}", style="red" if h.bad else "default")
            for h in shown.happenings[-6:]]  # fmt: skip
    said += [Text(p, style="bold red") for p in shown.problems]
    said += [Text.assemble((f"{v.name}: ", "dim"), v.said[-1]) for v in shown.vehicles if v.said]
    for line in said:
        line.no_wrap, line.overflow = True, "ellipsis"
    return Panel(Group(*said), title="so far", border_style="dim")


def _keys(shown: Snapshot, asked: str) -> RenderableType:
    if asked:
        return Panel(Text(asked, style="bold white on red"), border_style="red")
    line = Text()
    for word in shown.words:
        key, what = _NAMES[word]
        line.append(f" {key} ", style="reverse")
        line.append(f" {what}   ")
    line.append(" q ", style="reverse")
    line.append(" land and leave")
    return Panel(line, border_style="dim")


def _battery(v: VehicleShown) -> Text:
    if v.charge is None and v.voltage is None:
        return Text("–", style="dim")
    parts = [] if v.charge is None else [f"{100 * v.charge:.0f} %"]
    parts += [] if v.voltage is None else [f"{v.voltage:.1f} V"]
    return Text("  ".join(parts))


def _either(text: str, well: bool) -> Text:
    return Text(text, style="green" if well else "red")


def _number(value: float | None, unit: str, digits: int) -> Text:
    return Text("–", style="dim") if value is None else Text(f"{value:.{digits}f} {unit}")


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _pair(median: float | None, between: str, most: float | None) -> Text:
    if median is None or most is None:
        return Text("–", style="dim")
    return Text(f"{1e3 * median:.1f} ms, {between} {1e3 * most:.1f}")
