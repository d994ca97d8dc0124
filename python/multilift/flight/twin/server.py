"""The twin's plant and its Qualisys RT server, a process: ``python -m`` and this module.

Says its two ports in one line of JSON, lets the autopilots' processes take their seats, and moves
the plant by the clock until who started it is gone. A plant that cannot keep up is slow, it does
not jump: what it is behind by more than a moment is let go.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import socket
import struct
import sys
import threading

from multilift.flight import lab as labs
from multilift.flight.clock import Clock
from multilift.flight.mocap.rt_server import RTServer
from multilift.flight.twin import shaft
from multilift.flight.twin.autopilot import Drive
from multilift.flight.twin.cameras import Cameras
from multilift.flight.twin.rig import NOTHING, Motions
from multilift.flight.twin.start import plant_of
from multilift.models.spatial import SpatialWorld

#: Between two looks of the autopilots, s.
_PERIOD = 0.005

#: What the plant may be behind the clock before that is let go, s.
_MOST_BEHIND = 0.1

#: An autopilot that answers no more for so long has ended, s.
_PATIENCE = 0.5

_MOST_BYTES = 256


class Seats:
    """The autopilots' processes, as the plant reaches them."""

    def __init__(self, count: int) -> None:
        self._line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._line.bind(("127.0.0.1", 0))
        self._line.settimeout(1.0)
        self._where: list[tuple[str, int] | None] = [None] * count
        self._answered = [(0, 0.0, NOTHING, False)] * count
        self._count = 0

    @property
    def port(self) -> int:
        """Where they find it."""
        return int(self._line.getsockname()[1])

    def seat(self) -> None:
        """Waits until every autopilot has taken its seat."""
        while None in self._where:
            try:
                data, source = self._line.recvfrom(_MOST_BYTES)
                (k,) = struct.unpack("<i", data)
            except (TimeoutError, struct.error):
                continue
            if 0 <= k < len(self._where):
                self._where[k] = source

    def tell(self, now: float, motions: Motions) -> None:
        """Tells all where their bodies are."""
        self._count += 1
        for k, where in enumerate(self._where):
            if where is not None:
                body = shaft.body_to_bytes(now, self._count, motions.body(k))
                with contextlib.suppress(OSError):  # it is gone: its answers stay away
                    self._line.sendto(body, where)

    def drives(self, now: float) -> tuple[list[Drive], bool]:
        """How all are driven by what they last answered, and whether any is armed.

        Nobody is waited for: a machine that is busy with other things makes autopilots late, not
        the plant. Who answers no more for a while has ended, and its motors stand still.
        """
        self._line.setblocking(False)
        while True:
            try:
                data, source = self._line.recvfrom(_MOST_BYTES)
                count, drive, armed = shaft.drive_from_bytes(data)
            except BlockingIOError:
                break
            except (ConnectionRefusedError, struct.error):  # gone, or takes a seat twice
                continue
            if source in self._where:
                k = self._where.index(source)
                if count > self._answered[k][0]:
                    self._answered[k] = count, now, drive, armed
        alive = [a for a in self._answered if now - a[1] <= _PATIENCE]
        drives = [a[2] if now - a[1] <= _PATIENCE else NOTHING for a in self._answered]
        return drives, any(a[3] for a in alive)


async def _serve(lab: labs.Lab, clock: Clock) -> None:
    flown = lab.scenario
    motions = Motions(SpatialWorld(plant_of(flown)), _PERIOD)
    cameras = Cameras(flown, int(flown.values["simulation"]["seed"]))
    names = [v.body for v in lab.vehicles] + [str(lab.motion_capture["payload"])]
    server = RTServer(names, rate=1.0 / cameras.period)
    port = await server.start(port=0)
    seats = Seats(flown.count)
    sys.stdout.write(json.dumps({"plant": seats.port, "capture": port}) + "\n")
    sys.stdout.flush()
    await asyncio.to_thread(seats.seat)
    began = clock.now()
    time = next_look = 0.0
    while True:
        behind = clock.now() - began - time
        if behind > _MOST_BEHIND:
            began += behind - _MOST_BEHIND
        if time >= next_look - 1e-9:
            next_look += cameras.period
            cameras.look(motions.world, time)
        for capture in cameras.due(time):
            server.publish_capture(capture)
        seats.tell(time, motions)
        # The autopilots answer while the bodies' period passes.
        await asyncio.sleep(clock.real(max(motions.period - behind, 0.0)))
        motions.step(*seats.drives(clock.now()))
        time += motions.period


def _end_with_parent() -> None:
    sys.stdin.read()
    os._exit(0)


def main() -> None:
    """Serves the twin of the lab that the command line names."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    path, twin, speed = sys.argv[1:]
    threading.Thread(target=_end_with_parent, daemon=True).start()
    asyncio.run(_serve(labs.load(path, twin=twin == "twin"), Clock(float(speed))))


if __name__ == "__main__":
    main()
