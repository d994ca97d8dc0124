"""Short spatial runs that replays are tested on, and a browser to look at pages with."""

from __future__ import annotations

import shutil
import subprocess

import multilift as ml
import pytest
from multilift import replay

SHORT = {"simulation.duration": 3.0}


def run(name, **changes):
    """A shipped scenario, cut short."""
    return ml.simulate(ml.load(name).with_values({**SHORT, **changes}))


def cut():
    """Four vehicles and a platform; cable 2 is cut at 1 s, vehicle 3 is lost at 2 s."""
    events = [
        {"kind": "cable_cut", "time": 1.0, "vehicle": "vehicle_2"},
        {"kind": "vehicle_lost", "time": 2.0, "vehicle": "vehicle_3"},
    ]
    pushes = [
        {"body": "payload", "start": 0.5, "duration": 0.4, "force": [2.0, 0.0, 0.0],
         "shape": "half_sine"}
    ]  # fmt: skip
    return run("cable_cut", event=events, push=pushes)


def scene(name, **changes):
    """What a run of `run` looks like."""
    return replay.scene_of(run(name, **changes))


def browser():
    """The path of a Chromium; skips the test where there is none."""
    found = shutil.which("chromium") or shutil.which("chromium-browser")
    if found is None:
        pytest.skip("no Chromium to look with")
    return found


def look(page, folder, *options, width=1280, height=860):
    """Opens a page without a network until it has settled; what Chromium prints.

    Args:
        page: address of the page.
        folder: for the browser's own files.
        options: for Chromium, such as --dump-dom.
    """
    command = [
        browser(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
        f"--user-data-dir={folder / 'browser'}", "--virtual-time-budget=8000",
        f"--window-size={width},{height}", "--host-resolver-rules=MAP * ~NOTFOUND",
        *options, page,
    ]  # fmt: skip
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert result.returncode == 0, result.stderr
    return result.stdout
