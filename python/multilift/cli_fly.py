"""The commands ``multilift fly`` and ``multilift twin``."""

from __future__ import annotations

import contextlib
import math
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from multilift.errors import MissingExtraError, OutputError, ScenarioError

if TYPE_CHECKING:
    from multilift.flight.program import Program
    from multilift.flight.snapshot import Snapshot

_out = Console()

#: How often the screen is drawn anew, Hz.
_RATE = 8.0

_EXIT_TROUBLE = 3

LabArgument = Annotated[
    Path | None,
    typer.Argument(help="A lab file; left out: a twin of the paper's bar.", metavar="LAB.toml"),
]
LogOption = Annotated[
    Path | None, typer.Option("--log", help="The new log; left out: flight-DATE-TIME.mcap here.")
]
YesOption = Annotated[
    bool, typer.Option("--yes", help="Twins only: nobody at the keys, it goes and leaves itself.")
]
SpeedOption = Annotated[
    float, typer.Option(min=0.1, max=20.0, help="Of a twin's time; what a machine can keep up.")
]


def fly(lab: LabArgument = None, log: LogOption = None, yes: YesOption = False) -> None:
    """Fly a lab's vehicles, from the pre-flight checks to the ground; a twin if none is named."""
    _fly(lab, log, yes=yes, twin=False, speed=1.0)


def twin(
    lab: LabArgument = None,
    log: LogOption = None,
    yes: YesOption = False,
    speed: SpeedOption = 1.0,
) -> None:
    """Fly a lab with nothing real: plant, motion capture, autopilots, each a process of its own."""
    _fly(lab, log, yes=yes, twin=True, speed=speed)


def _fly(path: Path | None, log: Path | None, *, yes: bool, twin: bool, speed: float) -> None:
    try:
        from multilift.flight import lab as labs  # noqa: PLC0415 - the shorter start
        from multilift.flight.program import Program  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise MissingExtraError(str(error.name), "fly", "flying") from None
    file = labs.DEFAULT if path is None else path
    lab = labs.load(file, twin=twin)
    if yes and not lab.is_twin:
        raise ScenarioError(
            "names hardware, which flies on a pilot's word alone", where=str(file), key="vehicle",
            advice="leave --yes out, or fly its twin: multilift twin LAB.toml --yes",
        )  # fmt: skip
    if not yes and not sys.stdin.isatty():
        raise ScenarioError(
            "wants a terminal for the pilot's keys", where="multilift fly",
            advice="start it in a terminal, or give --yes to fly a twin without a pilot",
        )  # fmt: skip
    target = log or Path(time.strftime("flight-%Y%m%d-%H%M%S.mcap"))
    if target.exists():
        raise OutputError(f"{target} is there already\n  what to do: name a new file")
    # Ended by a signal, too, we end what we started.
    signal.signal(signal.SIGTERM, _stop)
    with Program(lab, file, target, speed=speed) as program:
        if yes:
            _go_alone(program)
        else:
            _with_pilot(program)
    _summary(target)


def _stop(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _go_alone(program: Program) -> None:
    """Without a pilot: checks, go, and leave when all is down; one line a state."""
    from multilift.flight.supervisor import State, Word  # noqa: PLC0415

    program.say(Word.START)
    state, gone = "", False
    while not program.is_over:
        shown = program.look(0.5)
        if shown is None or (shown.state == state == State.PREFLIGHT.value and gone):
            continue
        if shown.state != state:
            state = shown.state
            why = shown.happenings[-1].text if shown.happenings else state
            _out.print(f"{shown.time:7.1f} s  {escape(why)}", soft_wrap=True)
            if gone and state == State.IDLE.value:
                program.leave()
        if Word.GO.value in shown.words and not gone:
            gone = True
            program.say(Word.GO)


def _with_pilot(program: Program) -> None:
    """A live view and the pilot's keys, until she leaves and all is on the ground."""
    from multilift.flight.screen import KEYS, screen  # noqa: PLC0415
    from multilift.flight.supervisor import Word  # noqa: PLC0415

    program.say(Word.START)
    asked = ""
    with _keys() as pressed, Live(
        console=_out, auto_refresh=False, screen=True, transient=True
    ) as live:  # fmt: skip
        while not program.is_over:
            try:
                shown = program.look(1.0 / _RATE)
                key = pressed()
            except KeyboardInterrupt:
                shown, key = program.snapshot, "q"
            if shown is None:
                continue
            if asked:
                if key == "y":
                    program.say(Word.KILL)
                asked = "" if key else asked
            elif key == "q":
                program.say(Word.LAND)
                program.leave()
            elif key == "k":
                asked = _kill_question(shown)
            else:
                for word in KEYS.get(key, ()):
                    if word.value in shown.words:
                        program.say(word)
            live.update(screen(shown, asked), refresh=True)


def _kill_question(shown: Snapshot) -> str:
    armed = sum(v.armed for v in shown.vehicles)
    if "kill" not in shown.words:
        return ""
    return f"Stop the motors of {armed} vehicles now? They fall. y: yes; any other key: no"


@contextlib.contextmanager
def _keys() -> Iterator[Callable[[], str]]:
    """The keys as they are pressed: a function that gives the last one, "" for none."""
    import termios  # noqa: PLC0415 - not on every system, and not without a pilot
    import tty  # noqa: PLC0415

    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)

    def pressed() -> str:
        if not select.select([descriptor], [], [], 0.0)[0]:
            return ""
        try:
            data = os.read(descriptor, 64)
        except OSError:
            data = b""
        # A terminal that went away lands, too.
        return data.decode("utf-8", "replace")[:1] if data else "q"

    try:
        tty.setcbreak(descriptor)
        yield pressed
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _summary(log: Path) -> None:
    """What the flight was like, from its log."""
    from multilift.flight.review import metrics, review  # noqa: PLC0415

    flight = review(log)
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    if flight.flown is not None:
        found = metrics(flight.flown)
        rows = (
            ("peak swing", f"{found['peak_swing']:.1f}°"),
            ("still (1°) after", _after(found["still_after"])),
            ("vehicles there (2 cm) after", _after(found["vehicles_there_after"])),
            ("payload there (2 cm) after", _after(found["payload_there_after"])),
            ("off at the end", f"vehicles {100 * found['vehicles_off_at_end']:.1f} cm, payload "
             f"{100 * found['payload_off_at_end']:.1f} cm"),
            ("tensions", f"{found['least_tension']:.1f} to {found['greatest_tension']:.1f} N"),
        )  # fmt: skip
        for row in rows:
            table.add_row(*row)
    if math.isfinite(flight.separation):
        table.add_row("vehicles apart at least", f"{flight.separation:.2f} m")
    timing = flight.timing
    if timing and timing["latency_median"] is not None:
        table.add_row(
            "capture to command",
            f"median {1e3 * timing['latency_median']:.1f} ms, 99.9 % within "
            f"{1e3 * timing['latency_999']:.1f} ms",
        )
        table.add_row(
            "loop",
            f"{timing['rate']:.0f} Hz, {timing['missed']} of {timing['ticks']} periods missed, "
            f"late by {1e3 * timing['late_median']:.2f} ms, at most "
            f"{1e3 * timing['late_most']:.1f} ms",
        )
    _out.print(table)
    _out.print(f"Log: [bold]{escape(str(log))}[/], {flight.records} records", soft_wrap=True)
    if flight.states and not flight.is_regular and any(s == "take-off" for _t, s in flight.states):
        for trouble in flight.troubles:
            _out.print(f"[yellow]{escape(trouble)}[/]", soft_wrap=True)
        raise typer.Exit(_EXIT_TROUBLE)


def _after(seconds: float) -> str:
    return f"{seconds:.1f} s" if math.isfinite(seconds) else "not within the flight"
