"""The page in a real browser: it shows the flight, and its buttons fly it."""

import dataclasses
import re
import subprocess
import sys
import threading

import browser
import pytest
from browser import Browser, wait_for
from flight_snapshots import snapshot
from multilift.flight import lab as labs
from multilift.flight.log import read
from multilift.flight.supervisor import Word
from multilift.flight.web.address import WebAddress
from multilift.flight.web.page import Page

pytestmark = pytest.mark.skipif(browser.FOUND is None, reason="no Chromium or Chrome is installed")

TWIN = "from multilift.cli import main; import sys; sys.argv[0] = 'multilift'; main()"


class Feed:
    """Snapshots ten times a second, with time going on, until it is stopped."""

    def __init__(self, page, shown):
        self.shown, self._page, self._over = shown, page, threading.Event()
        self.pressed = []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._over.wait(0.1):
            self.shown = dataclasses.replace(self.shown, time=self.shown.time + 0.1)
            self._page.show(self.shown)
            self.pressed += self._page.words()

    def stop(self):
        self._over.set()
        self._thread.join()


def test_a_page_from_the_first_look_to_the_last(tmp_path):
    lab = labs.load(labs.DEFAULT)
    every = tuple(word.value for word in Word)
    with Page(lab, WebAddress("127.0.0.1", 0), "a test") as page:
        feed = Feed(page, snapshot(words=("hold", "land", "kill"), checks=()))
        try:
            with Browser(tmp_path / "profile", page.address.url) as seen:
                looks_on(seen)
                types_a_wrong_token_and_the_right_one(seen, page)
                presses_what_is_offered(seen, feed, every)
                kills_only_when_asked_again(seen, feed)
                feed.stop()
                seen.wait_for_text("No data for")
                page._process.kill()
                seen.wait_for_text("The page gets nothing any more")
                # Nothing comes from elsewhere; a page's own parts are data.
                served = (page.address.url, "data:", "blob:")
                assert all(url.startswith(served) for url in seen.loaded)
        finally:
            feed.stop()


def looks_on(seen):
    for text in ("fly", "Two craft and a bar", "twin: nothing real", "vehicle 1", "ARMED", "87 %",
                 "15.4 V", "6.3 °", "45.8 °", "swing of the cables, °", "age of the links, s",
                 "swings", "capture to command"):  # fmt: skip
        seen.wait_for_text(text)
    # The view in space, and a canvas for each plot.
    assert seen.run("document.querySelectorAll('canvas').length") >= 6
    assert not seen.shows("No data for")
    assert not seen.shows("land all")


def types_a_wrong_token_and_the_right_one(seen, page):
    seen.type_into("token", "wrong")
    seen.press("unlock the buttons")
    wait_for(lambda: page.refused == 1)
    assert "1 wrong" in page.note
    assert not seen.shows("land all")
    seen.type_into("token", page.token)
    seen.press("unlock the buttons")
    seen.wait_for_text("land all")
    assert not seen.shows("unlock")


def presses_what_is_offered(seen, feed, every):
    assert not seen.offers("go")
    seen.press("hold")
    wait_for(lambda: feed.pressed == [Word.HOLD])
    feed.shown = dataclasses.replace(feed.shown, state="pause", words=every)
    seen.press("go")
    wait_for(lambda: feed.pressed[1:] == [Word.GO])
    feed.shown = dataclasses.replace(feed.shown, state="fly", words=("hold", "land", "kill"))
    wait_for(lambda: not seen.offers("go"))


def kills_only_when_asked_again(seen, feed):
    seen.press("kill: motors off")
    seen.wait_for_text("Stop the motors of 2 vehicles now?")
    seen.press("no")
    wait_for(lambda: not seen.shows("Stop the motors"))
    assert Word.KILL not in feed.pressed
    seen.press("kill: motors off")
    seen.press("yes, motors off")
    wait_for(lambda: feed.pressed[-1] is Word.KILL)


@pytest.mark.skipif(sys.platform != "linux", reason="a twin through all wires, as CI flies it")
def test_a_twin_is_landed_from_a_browser(tmp_path):
    log = tmp_path / "landed.mcap"
    command = subprocess.Popen(
        [sys.executable, "-u", "-c", TWIN, "twin", "--yes", "--log", str(log),
         "--web-address", "127.0.0.1:0"],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    with command:
        try:
            said = (re.search(r"(http://\S+)\s+token (\S+)", line) for line in command.stdout)
            url, token = next(filter(None, said)).groups()
            with Browser(tmp_path / "profile", url, (700, 500)) as seen:
                seen.type_into("token", token)
                seen.press("unlock the buttons")
                seen.wait_for_text("ARMED")
                seen.press("land all")
                seen.wait_for_text("the pilot lands")
            rest = command.stdout.read()
            command.wait(browser.PATIENCE)
        finally:
            command.kill()
    said = [e.data["word"] for e in read(log) if e.topic == "supervisor" and e.data["word"]]
    assert "land" in said, rest
    last = [e.data for e in read(log) if e.topic == "supervisor"][-1]
    assert last["state"] == "idle"
    assert not any(last["armed"])
