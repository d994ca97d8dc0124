"""One twin autopilot as a process: ``python -m multilift.flight.twin.pilot LAB K PLANT STATION``.

It asks the plant for its body and answers with what drives it; it ends with who started it.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import struct
import sys
import threading
import time
from random import Random

from multilift.flight import lab as labs
from multilift.flight.link.address import Address
from multilift.flight.link.firmware import BY_NAME
from multilift.flight.link.udp import Udp
from multilift.flight.twin import shaft
from multilift.flight.twin.autopilot import TwinAutopilot
from multilift.flight.twin.wire import Impaired, Radio

#: A plant that says nothing for so long is gone, s.
_PLANT_GONE = 10.0

#: How long its silence is waited for before the seat is asked for again, s.
_PATIENCE = 0.2

_MOST_BYTES = 256


class Seat:
    """An autopilot in the seat of vehicle k."""

    def __init__(self, lab: labs.Lab, k: int, station: int) -> None:
        """Of a lab's twin, with the ground station at a port of this machine."""
        vehicle, link = lab.vehicles[k], lab.scenario.values["link"]
        self.now = 0.0
        there = Udp(Address(False, "127.0.0.1", station))
        radio = Radio(float(link["delay"]), float(link["jitter"]))
        self.pilot = TwinAutopilot(
            vehicle.system, int(lab.security["system"]), BY_NAME[vehicle.firmware],
            Impaired(there, radio, lambda: self.now, Random(k)), vehicle.hover_thrust,
            unix=time.time(),
        )  # fmt: skip

    def answer(self, data: bytes) -> bytes:
        """What drives a body that the plant tells of."""
        self.now, count, body = shaft.body_from_bytes(data)
        return shaft.drive_to_bytes(count, self.pilot.step(body, self.now), self.pilot.armed)


def _end_with_parent() -> None:
    sys.stdin.read()
    os._exit(0)


def main() -> None:
    """Sits in the seat that the command line names until the plant is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    path, twin, k, plant, station = sys.argv[1:]
    threading.Thread(target=_end_with_parent, daemon=True).start()
    seat = Seat(labs.load(path, twin=twin == "twin"), int(k), int(station))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.connect(("127.0.0.1", int(plant)))
        line.setblocking(False)
        heard = time.monotonic()
        while time.monotonic() - heard < _PLANT_GONE:
            line.send(struct.pack("<i", int(k)))
            while select.select([line], [], [], _PATIENCE)[0]:
                data = _newest(line)
                if data is None:
                    return
                heard = time.monotonic()
                line.send(seat.answer(data))


def _newest(line: socket.socket) -> bytes | None:
    """The last body that came: after a delay of this process only the present counts.

    Returns:
        None when the plant is gone.
    """
    data = None
    try:
        while True:
            data = line.recv(_MOST_BYTES)
    except BlockingIOError:
        return data
    except ConnectionRefusedError:
        return None


if __name__ == "__main__":
    main()
