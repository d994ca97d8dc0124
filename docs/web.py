"""Draws the picture of the web page in flight-fly.md: a twin in mid-flight, in a real browser.

``python docs/web.py`` writes docs/_static/flight-web.png; it needs Chromium or Chrome.
"""

import dataclasses
import sys
import tempfile
import threading
import time
from pathlib import Path

from multilift.flight import lab
from multilift.flight.show import snapshot_of
from multilift.flight.supervisor import State, Word
from multilift.flight.twin.stepped import START, SteppedFlight
from multilift.flight.web.address import WebAddress
from multilift.flight.web.page import Page

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from browser import Browser

#: How long it has flown in the picture, s, and how much faster it is shown.
SECONDS = 9.0
FASTER = 2.0


def flown() -> list:
    """Ten snapshots a second, from the take-off on."""
    flight = SteppedFlight(lab.load(lab.DEFAULT))
    station, found = flight.station, []
    flight.prepare()
    flight.run(60.0, lambda: station.supervisor.state is State.TAKE_OFF, Word.GO)
    while station.supervisor.state is not State.FLY or station.supervisor.lasted < SECONDS:
        flight.run(0.1)
        found.append(snapshot_of(station, flight.now, START))
    flight.close()
    return found


def shows(page: Page, snapshots: list, over: threading.Event) -> None:
    """Flies them, and stays at the last, which is of now until it is over."""
    for shown in snapshots:
        page.show(shown)
        time.sleep(0.1 / FASTER)
    while not over.wait(0.1):
        page.show(dataclasses.replace(snapshots[-1]))


if __name__ == "__main__":
    target = Path(__file__).parent / "_static" / "flight-web.png"
    snapshots, over = flown(), threading.Event()
    with (
        tempfile.TemporaryDirectory() as folder,
        Page(lab.load(lab.DEFAULT), WebAddress("127.0.0.1", 0), "docs/web.py") as page,
        Browser(Path(folder) / "profile", page.address.url) as browser,
    ):
        flight = threading.Thread(target=shows, args=(page, snapshots, over))
        flight.start()
        try:
            browser.type_into("token", page.token)
            browser.press("unlock the buttons")
            browser.wait_for_text(f"for {snapshots[-1].lasted:.1f} s")
            browser.run("[...document.querySelectorAll('.mantine-Notification-closeButton')]"
                        ".forEach(b => b.click())")  # fmt: skip
            time.sleep(1.0)
            browser.picture(target)
        finally:
            over.set()
            flight.join()
