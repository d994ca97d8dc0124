"""Draws the picture of the live view in flight-fly.md: a twin in mid-flight, without a clock.

``python docs/screen.py`` writes docs/_static/flight-screen.svg.
"""

import io
import re
from pathlib import Path

from multilift.flight import lab
from multilift.flight.screen import screen
from multilift.flight.show import snapshot_of
from multilift.flight.supervisor import State, Word
from multilift.flight.twin.stepped import START, SteppedFlight
from rich.console import Console

WIDTH = 118
SECONDS = 1.5


def picture() -> str:
    """The screen as SVG, in fonts that every reader has."""
    flight = SteppedFlight(lab.load(lab.DEFAULT))
    station = flight.station
    flight.prepare()
    flight.run(60.0, lambda: station.supervisor.state is State.FLY, Word.GO)
    flight.run(SECONDS)
    shown = snapshot_of(station, flight.now, START)
    flight.close()
    console = Console(record=True, width=WIDTH, force_terminal=True, file=io.StringIO())
    console.print(screen(shown))
    svg = console.export_svg(title="multilift twin", unique_id="screen")
    return re.sub(r"@font-face \{.*?\}\s*|<!--.*?-->\s*", "", svg, flags=re.DOTALL)


if __name__ == "__main__":
    target = Path(__file__).parent / "_static" / "flight-screen.svg"
    target.write_text(picture(), encoding="utf-8")
