"""Numbers and texts of a page, as HTML; all that comes from outside is escaped.

Whether what is shown is of the past is told twice: by the process, which knows how old the last
snapshot is, and by the browser, in which each text covers itself unless another takes its place
in time. So a page also says so whose server is gone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape
from pathlib import Path

from multilift.flight.screen import AT, BAD_STATES, NEAR
from multilift.flight.snapshot import Margin, Snapshot, VehicleShown
from multilift.replay.colours import vehicle_colour

#: From when on a snapshot is of the past, s. The browser waits 3 s for the next text, see page.css.
STALE = 1.0

_STYLE = f"<style>{Path(__file__).with_name('page.css').read_text(encoding='utf-8')}</style>"

_OVER = (
    '<div class="ml-lost">The page gets nothing any more: its server or the way to it is gone. '
    "All this is of the past.</div>"
)


def is_stale(age: float) -> bool:
    """Whether a snapshot so many seconds old is of the past."""
    return age > STALE


def waiting() -> str:
    """Before the first snapshot."""
    return (
        '<div style="padding:12px;font:16px system-ui;color:#e6e8eb">Waiting for the flight …</div>'
    )


def head(shown: Snapshot, age: float) -> str:
    """What counts most: the supervisor's state, whether it is real and of now.

    It is always as high, so that no button moves away from under a finger. Its age makes each text
    differ from the last, though nothing else may have changed.
    """
    bad = shown.state in BAD_STATES
    kind, since = "bad" if bad else "", f"for {shown.lasted:.1f} s"
    if is_stale(age):
        kind, since = "old", f"No data for {age:.0f} s: all this is of the past"
    real = ("g", "twin: nothing real") if shown.twin else ("y", "HARDWARE")
    return (
        f'{_STYLE}<div class="ml ml-head" data-age="{age:.3f}">{_OVER}'
        f'<div class="ml-state {kind}"><b>{escape(shown.state)}</b><span>{since}</span></div>'
        f'<div class="ml-row">{escape(shown.scenario)} · <span class="{real[0]}">{real[1]}</span>'
        f" · <small>since the start</small> {shown.time:.1f} s</div></div>"
    )


def rest(shown: Snapshot, age: float) -> str:
    """Vehicles, margins, motion capture, loop, checks, what happened."""
    return (
        f'{_STYLE}<div class="ml" data-age="{age:.3f}">{_vehicles(shown)}{_margins(shown)}'
        f"{_sources(shown)}{_lines(shown)}</div>"
    )


def _vehicles(shown: Snapshot) -> str:
    heads = "".join(
        f'<th><b style="color:{vehicle_colour(k)}">■ {escape(v.name.replace("_", " "))}</b><br>'
        f"<small>{escape(v.firmware)}, id {v.system}</small></th>"
        for k, v in enumerate(shown.vehicles)
    )
    rows = zip(*(_readings(v) for v in shown.vehicles), strict=True)
    body = "".join(
        f"<tr><td>{row[0][0]}</td>{''.join(f'<td>{cell}</td>' for _name, cell in row)}</tr>"
        for row in rows
    )
    return f'<div class="ml-wide"><table><tr><th></th>{heads}</tr>{body}</table></div>'


def _readings(v: VehicleShown) -> tuple[tuple[str, str], ...]:
    armed = '<span class="y">ARMED</span>' if v.armed else "no"
    battery = [] if v.charge is None else [f"{100.0 * v.charge:.0f} %"]
    battery += [] if v.voltage is None else [f"{v.voltage:.1f} V"]
    mode = escape(v.mode) + (' <span class="r">FAILSAFE</span>' if v.failsafe else "")
    return (
        ("order", escape(v.order)),
        ("mode", mode),
        ("armed", armed),
        ("link age", _number(v.link_age, "s", 2)),
        ("battery", " · ".join(battery) or "–"),
        ("height, up", _number(v.position[2], "m", 2)),
        ("off its place", _number(v.error, "cm", 1, 100.0)),
        ("speed", _number(math.hypot(*v.velocity), "m/s", 2)),
        ("tilt", _number(v.tilt, "°", 1, 180.0 / math.pi)),
        ("thrust", _number(v.thrust, "N", 1)),
        ("cable: swing", _number(v.swing, "°", 1, 180.0 / math.pi)),
        ("cable: tension", _number(v.tension, "N", 1)),
        ("messages dropped", str(sum(v.dropped.values()))),
    )


def _margins(shown: Snapshot) -> str:
    rows = "".join(
        f"<tr><td>{escape(m.name.replace('_', ' '))}</td><td>{_bar(m)}</td><td>{_of(m)}</td></tr>"
        for m in shown.margins
    )
    return f"<table><tr><th>margins</th><th></th><th>now / limit</th></tr>{rows}</table>"


def _bar(margin: Margin) -> str:
    if margin.used is None:
        return "<small>not watched now</small>"
    part = 100.0 * min(max(margin.used, 0.0), 1.0)
    colour = "#ff5c5c" if margin.used >= AT else "#ffd23c" if margin.used >= NEAR else "#4cc46a"
    return f'<div class="ml-bar"><i style="width:{part:.0f}%;background:{colour}"></i></div>'


def _of(margin: Margin) -> str:
    factor, unit = (180.0 / math.pi, "°") if margin.unit == "rad" else (1.0, margin.unit)
    value = "–" if margin.value is None else f"{factor * margin.value:.2f}"
    return f"{value} / {factor * margin.limit:.3g} {escape(unit)}"


def _sources(shown: Snapshot) -> str:
    capture, timing = shown.capture, shown.timing
    well = "g" if capture.quality == "good" else "r"
    quality = f'<span class="{well}">{escape(capture.fault or capture.quality)}</span>'
    latency = f"{_number(timing.latency_median, 'ms', 1, 1e3)}, 99.9 %: "
    latency += _number(timing.latency_999, "ms", 1, 1e3)
    rows = (
        ("motion capture", f"{quality}, {_number(capture.age, 'ms', 0, 1e3)} old"),
        ("load off its path", _number(shown.payload.error, "cm", 1, 100.0)),
        ("loop", f"{timing.rate:.0f} Hz, {timing.missed} of {timing.ticks} missed"),
        ("capture to command", latency),
    )
    return "<table>" + "".join(f"<tr><td>{a}</td><td>{b}</td></tr>" for a, b in rows) + "</table>"


def _lines(shown: Snapshot) -> str:
    found = [_line(escape(p), bad=True) for p in shown.problems[:6]]
    found += _checks(shown)
    found += [_line(f"{h.time:.1f} s  {escape(h.text)}", bad=h.bad) for h in shown.happenings[-6:]]
    found += [
        _line(f"<small>{escape(v.name)}:</small> {escape(v.said[-1])}")
        for v in shown.vehicles
        if v.said
    ]
    return "".join(found)


def _checks(shown: Snapshot) -> Iterable[str]:
    failed = [name for name, passed in shown.checks if not passed]
    if shown.checks:
        passed = len(shown.checks) - len(failed)
        yield _line(f"<small>pre-flight checks passed:</small> {passed} of {len(shown.checks)}")
    for name in failed:
        yield _line(f"✗ {escape(name)}", bad=True)


def _line(content: str, *, bad: bool = False) -> str:
    return f'<div class="ml-line{" r" if bad else ""}">{content}</div>'


def _number(value: float | None, unit: str, digits: int, factor: float = 1.0) -> str:
    return "–" if value is None else f"{factor * value:.{digits}f} {unit}"
