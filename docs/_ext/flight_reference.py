"""The flight pages' tables and the drawing of the supervisor, from what flies.

Run by Sphinx, it writes ``docs/generated/flight/``.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from multilift.flight.lab_tables import TABLES
from multilift.flight.link.firmware import BY_NAME
from multilift.flight.supervisor.states import COURSE, MOST_TIME, TRANSITIONS, Event, State
from scenario_reference import field_table, grid, sentence

if TYPE_CHECKING:
    from sphinx.application import Sphinx

#: Column and row of each state.
PLACES = {
    State.IDLE: (0, 0), State.PREFLIGHT: (0, 1), State.ARMED: (0, 2),
    **{state: (0, 3 + k) for k, state in enumerate(COURSE)},
    State.PAUSE: (1, 6), State.HOLD: (2, 4), State.LAND_APART: (2, 8), State.KILL: (3, 6),
}  # fmt: skip
BOX, STEP, MARGIN = (112, 34), (190, 66), 84

#: Colours that both themes show, by what brings a state to its end.
KINDS = {
    "the plan goes on": ("#1a9850", (Event.ALL_ARMED, Event.DONE, Event.ALL_DISARMED)),
    "the pilot": ("#3a86d8", (Event.HOLD_WORD, Event.LAND_WORD, Event.START_WORD, Event.GO_WORD)),
    "trouble, hold over": ("#d73027", (Event.TROUBLE, Event.HOLD_OVER)),
    "takes too long": ("#b07d2b", (Event.TOO_LONG,)),
    "the pilot kills": ("#8e44ad", (Event.KILL,)),
}


def centre(state: State) -> tuple[float, float]:
    column, row = PLACES[state]
    return MARGIN + BOX[0] / 2 + column * STEP[0], MARGIN + BOX[1] / 2 + row * STEP[1]


def curve(start: State, end: State, kind: int) -> str:
    """A path from the edge of one box to the edge of another, bent to one side."""
    (x0, y0), (x1, y1) = centre(start), centre(end)
    length = math.hypot(x1 - x0, y1 - y0)
    near = abs(PLACES[start][0] - PLACES[end][0]) + abs(PLACES[start][1] - PLACES[end][1]) == 1
    around = PLACES[start][0] == PLACES[end][0]  # of the boxes between
    bend = (0.0 if near else BOX[0] + 20.0 if around else 0.16 * length) + 9.0 * kind
    mx = (x0 + x1) / 2 - (y1 - y0) / length * bend
    my = (y0 + y1) / 2 + (x1 - x0) / length * bend
    ax, ay = edge(x0, y0, mx, my)
    bx, by = edge(x1, y1, mx, my)
    return f"M{ax:.1f} {ay:.1f} Q{mx:.1f} {my:.1f} {bx:.1f} {by:.1f}"


def edge(x: float, y: float, towards_x: float, towards_y: float) -> tuple[float, float]:
    """Where the line from a box's centre leaves it."""
    dx, dy = towards_x - x, towards_y - y
    scale = min((BOX[k] / 2 + 3) / abs(d) for k, d in ((0, dx), (1, dy)) if d)
    return x + dx * scale, y + dy * scale


def drawing() -> str:
    """The states and every way between them, as SVG."""
    width = MARGIN * 2 + BOX[0] + STEP[0] * 3
    height = MARGIN * 2 + BOX[1] + STEP[1] * 8 + 30
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'role="img" aria-label="States of a flight" font-family="sans-serif" font-size="14">'
    ]
    for k, (colour, _events) in enumerate(KINDS.values()):
        parts.append(
            f'<marker id="tip{k}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
            f'markerHeight="7" orient="auto"><path d="M0 0 L8 4 L0 8 z" fill="{colour}"/></marker>'
        )
    for k, (kind, (colour, events)) in enumerate(KINDS.items()):
        ways = {(t.start, t.end): t for t in TRANSITIONS if t.event in events}
        for start, end in ways:
            words = ", ".join(
                t.event.value for t in TRANSITIONS
                if (t.start, t.end) == (start, end) and t.event in events
            )  # fmt: skip
            parts.append(
                f'<path d="{curve(start, end, k)}" fill="none" stroke="{colour}" '
                f'stroke-width="1.5" opacity="{0.35 if kind == "the pilot kills" else 0.9}" '
                f'marker-end="url(#tip{k})">'
                f"<title>{start.value} → {end.value}: {words}</title></path>"
            )
    for state in State:
        x, y = centre(state)
        parts.append(
            f'<rect x="{x - BOX[0] / 2:.1f}" y="{y - BOX[1] / 2:.1f}" width="{BOX[0]}" '
            f'height="{BOX[1]}" rx="6" fill="#f4f4f4" stroke="#555"/>'
            f'<text x="{x:.1f}" y="{y + 5:.1f}" text-anchor="middle" fill="#111">'
            f"{state.value}</text>"
        )
    x = MARGIN
    for kind, (colour, _events) in KINDS.items():
        parts.append(
            f'<text x="{x}" y="{height - 12}" fill="{colour}" font-size="13">{kind}</text>'
        )
        x += 9 * len(kind) + 20
    return "\n".join([*parts, "</svg>"]) + "\n"


def ways() -> str:
    """Every way, by state."""
    rows = []
    for state in State:
        limit = MOST_TIME[state]
        after = f" ({limit:g} s)" if math.isfinite(limit) else ""
        for t in TRANSITIONS:
            if t.start is state:
                why = t.event.value + (after if t.event is Event.TOO_LONG else "")
                rows.append((state.value, why, t.end.value))
    return grid(("in", "when", "goes to"), rows) + "\n"


def lab_tables() -> str:
    """Every table of a lab file."""
    parts = []
    for table in TABLES.values():
        name = f"[[{table.name}]]" if table.repeated else f"[{table.name}]"
        parts.append(f"### `{name}`\n\n{sentence(table.doc)}\n\n{field_table(table.fields)}\n")
    return "\n".join(parts)


def settings() -> str:
    """The parameters that are set and verified before arming."""
    rows = [
        (firmware.name, f"`{s.name}`", f"{s.value:g}", s.reason)
        for firmware in BY_NAME.values()
        for s in firmware.settings
    ]
    return grid(("firmware", "parameter", "must be", "why"), rows) + "\n"


def pages() -> dict[str, str]:
    """Content of each generated file by its path below ``docs/generated``."""
    return {
        "flight/supervisor.svg": drawing(),
        "flight/ways.md": ways(),
        "flight/lab-tables.md": lab_tables(),
        "flight/settings.md": settings(),
    }


def write(app: Sphinx) -> None:
    for name, content in pages().items():
        file = Path(app.srcdir) / "generated" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists() or file.read_text(encoding="utf-8") != content:
            file.write_text(content, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
