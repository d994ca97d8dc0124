"""Fake firmware as programs for the launcher, and instances whose ports are free."""

import socket
import stat
import sys
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import multilift as ml
from multilift.flight.sitl import firmware as firmwares
from multilift.flight.sitl.lockstep import Lockstep
from multilift.flight.sitl.physics import Physics
from multilift.flight.sitl.sensors import Capture, Sensors

FAKE = Path(__file__).with_name("fake_firmware.py")

#: Above each end of the bar where it lies in the scenario, cables taut and the bar up by 0.5 m;
#: north, east, down.
ABOVE = ((0.0, -0.75, -1.75), (0.0, 0.75, -1.75))


def program(folder, kind):
    """A program at the place where the kind's build leaves it."""
    file = folder / {"px4": "bin/px4", "ardupilot": "arducopter"}[kind]
    file.parent.mkdir(parents=True, exist_ok=True)
    (folder / "etc").mkdir(exist_ok=True)
    file.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{FAKE}" {kind} "$@"\n')
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
    return file


@contextmanager
def instances(count=2):
    """The first of so many instances whose ports are free, and stay so for other tests' sake."""
    for first in range(3, 200, count):
        with ExitStack() as taken:
            try:
                # Who holds this one has the instances.
                claim = taken.enter_context(closing(socket.socket(type=socket.SOCK_DGRAM)))
                claim.bind(("127.0.0.1", 24640 + first))
                for i in range(first, first + count):
                    for kind, port in (
                        (socket.SOCK_STREAM, 4560 + i),
                        (socket.SOCK_DGRAM, 9002 + 10 * i),
                        (socket.SOCK_DGRAM, 14640 + i),
                    ):
                        with closing(socket.socket(type=kind)) as probe:
                            probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            yield first
            return
    raise AssertionError("no free ports")


@contextmanager
def instances_of_fakes(monkeypatch, targets=ABOVE):
    """The same, for fake firmware that is told where to go."""
    with instances() as first:
        monkeypatch.setenv("FAKE_FIRST", str(first))
        monkeypatch.setenv("FAKE_TARGETS", ";".join(",".join(map(str, t)) for t in targets))
        yield first


def make(kind, path, first):
    return {"px4": firmwares.Px4, "ardupilot": firmwares.ArduPilot}[kind](path, first)


def run(kind, path, folder, first, *, duration, each=None):
    """Flies bar_from_floor by a firmware; the physics and the progress."""
    scenario = ml.load("bar_from_floor")
    firmware = make(kind, path, first)
    physics = Physics(scenario)
    with ExitStack() as stack:
        links = [stack.enter_context(closing(firmware.link(i))) for i in range(physics.count)]
        processes = stack.enter_context(firmwares.Processes(firmware, scenario, folder))
        sensors = [Sensors(1, i, capture=Capture()) for i in range(physics.count)]
        lockstep = Lockstep(physics, sensors, links, watch=processes.check)
        lockstep.connect()
        progress = lockstep.run(duration, each)
    return physics, progress


def fly(kind, path, folder, monkeypatch, *, duration, each=None):
    """The same by fake firmware."""
    with instances_of_fakes(monkeypatch) as first:
        return run(kind, path, folder, first, duration=duration, each=each)
