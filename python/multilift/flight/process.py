"""The process that flies: ``python -m multilift.flight.process``.

Nothing else runs in it: screens are elsewhere, the log and the capture system's client are
processes of their own, and garbage is collected on the ground only. Settings come as one line of
JSON, then the pilot's words, one a line; snapshots go out on a socket that never blocks. When the
words end because whoever said them is gone, it lands.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import json
import os
import signal
import socket
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from multilift.errors import MultiliftError, ScenarioError
from multilift.flight import lab as labs
from multilift.flight.clock import Clock
from multilift.flight.estimate.scene import PAYLOAD, estimator_for, tuning_for
from multilift.flight.lab import Lab
from multilift.flight.link.address import Address
from multilift.flight.link.open import link_to
from multilift.flight.link.signing import read_key
from multilift.flight.link.udp import Udp
from multilift.flight.link.vehicle import Tap
from multilift.flight.log import Log
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.settings import Settings
from multilift.flight.mocap.source import CaptureSource
from multilift.flight.show import snapshot_of, timing_of
from multilift.flight.snapshot import to_dict
from multilift.flight.station import Station
from multilift.flight.supervisor import State, Word

#: How often snapshots go out, Hz.
_SHOWN = 10.0

#: The last of the wait for a tick is slept without looking at anything: that is more exact, s.
_EXACT = 0.0015

#: How long it waits for the ground once nobody is there to say anything, s.
_MOST_ALONE = 180.0

#: On the ground; garbage is collected and the program may end.
_ON_GROUND = (State.IDLE, State.PREFLIGHT)


@dataclass(frozen=True)
class Order:
    """What is to be flown, and how.

    Attributes:
        lab: path of the lab file.
        twin: whether hardware that it names is left out.
        speed: of the clock; 1 with hardware.
        log: path of the new log.
        capture_port: of the twin's RT server.
        snapshots: file descriptor of the socket for them.
    """

    lab: str
    twin: bool
    speed: float
    log: str
    capture_port: int
    snapshots: int

    def to_json(self) -> str:
        """All of it in a line."""
        return json.dumps(asdict(self))


class Flying:
    """A ground station with its clock."""

    def __init__(self, order: Order) -> None:
        """Opens everything that is ours.

        Raises:
            MultiliftError: if something is not to be had.
        """
        self.lab = labs.load(order.lab, twin=order.twin)
        self.clock = Clock(order.speed)
        self.began = self.clock.now()
        self.leaving = self.over = False
        self._shown = socket.socket(fileno=order.snapshots)
        self._shown.setblocking(False)
        security = self.lab.security
        key = None if self.lab.key_file is None else read_key(self.lab.key_file, self.lab.where)
        assert security is not None
        self.sockets = [_socket(self.lab, k) for k in range(len(self.lab.vehicles))]
        self.log = Log(Path(order.log), self.began)
        unix = time.time()
        links = [
            link_to(self.lab, k, transport, key, unix, self._tap(k))
            for k, transport in enumerate(self.sockets)
        ]
        flown = self.lab.scenario
        estimator = estimator_for(flown, tuning_for(flown))
        self.station = Station(self.lab, links, estimator, self.log, self.clock.now)
        self.source = CaptureSource(capture_settings(self.lab, order.capture_port))

    def _tap(self, k: int) -> Tap:
        return lambda way, now, data: self.log.raw(f"{way}/vehicle_{k + 1}", now, data)

    async def run(self) -> None:
        """Flies until it may end."""
        flown = self.lab.scenario
        self.log.write("lab", self.began, {
            "name": self.lab.name,
            "title": self.lab.title,
            "twin": self.lab.is_twin,
            "speed": self.clock.speed,
            "scenario": flown.to_toml(),
        })  # fmt: skip
        self.show({"ports": [end.port for end in self.sockets]})
        await self.source.open()
        gc.collect()
        gc.freeze()
        gc.disable()
        times, station = self.station.times, self.station
        due = self.clock.now()
        ticks, captured = 0, True
        alone_since: float | None = None
        while not self.over:
            await self._wait_for(due)
            began = self.clock.now()
            if captured:
                captured = self._take_frames()
            station.tick(began)
            ticks += 1
            if ticks % round(times.rate / _SHOWN) == 0:
                self._look()
            state = station.supervisor.state
            if state in _ON_GROUND and ticks % round(times.rate) == 0:
                gc.collect()
            due = times.ticked(due, began, self.clock.now())
            if self.leaving:
                alone_since = began if alone_since is None else alone_since
                if state in _ON_GROUND or began - alone_since > _MOST_ALONE:
                    break

    async def close(self) -> None:
        """Ends everything that is ours; the log is complete then."""
        gc.unfreeze()
        await self.source.close()
        for end in self.sockets:
            end.close()
        self.log.close()
        self.show({"ended": True})

    async def _wait_for(self, due: float) -> None:
        rest = self.clock.real(due - self.clock.now())
        await asyncio.sleep(max(rest - _EXACT, 0.0))
        rest = self.clock.real(due - self.clock.now())
        if rest > 0.0:
            time.sleep(min(rest, _EXACT))
        # What came meanwhile: the pipe, its reader, who waits for it.
        for _ in range(3):
            await asyncio.sleep(0)

    def _take_frames(self) -> bool:
        """Whether there may be more: a source that ended is silence, which the estimator tells."""
        try:
            for frame in self.source.drain():
                self.station.sees(_at(frame, self.clock))
        except CaptureError as error:
            self.log.write("error", self.clock.now(), {"text": str(error)})
            return False
        return True

    def _look(self) -> None:
        now = self.clock.now()
        snapshot = snapshot_of(self.station, now, self.began)
        if snapshot is not None:
            self.show({"snapshot": to_dict(snapshot)})
            self.log.write("timing", now, asdict(timing_of(self.station.times)))

    def show(self, message: dict[str, Any]) -> None:
        """Gives a message away, if it is taken at once."""
        with contextlib.suppress(OSError):
            self._shown.send(json.dumps(message).encode())

    def hear(self, line: str) -> None:
        """Takes one line: a word of the pilot, or "leave" to end once all is on the ground."""
        if line == "leave":
            self.leaving = True
            return
        with contextlib.suppress(ValueError):
            self.station.say(Word(line))

    def lose_pilot(self) -> None:
        """Nobody is there to say anything any more; a twin goes with them."""
        self.leaving = True
        self.over = self.lab.is_twin
        self.station.say(Word.LAND)


def capture_settings(lab: Lab, twin_port: int) -> Settings:
    """What a lab asks of its motion capture.

    Args:
        lab: which.
        twin_port: of the twin's server.

    Raises:
        ScenarioError: for the vehicles' own estimates, which tell nothing of the load.
    """
    table = lab.motion_capture
    bodies = {f"vehicle_{k + 1}": v.body for k, v in enumerate(lab.vehicles)}
    bodies[PAYLOAD] = str(table["payload"])
    if lab.is_twin:
        return Settings("qualisys", bodies, port=twin_port)
    if table["system"] == "autopilot":
        raise ScenarioError(
            "does not show the load, which is flown by", where=lab.where,
            key="motion_capture.system", value="autopilot",
            permitted="qualisys or motioncapture",
        )  # fmt: skip
    return Settings(str(table["system"]), bodies, str(table["kind"]), str(table["host"]))


def _socket(lab: Lab, k: int) -> Udp:
    address = lab.vehicles[k].address or Address(True, "127.0.0.1", 0)
    try:
        return Udp(address)
    except OSError as error:
        raise ScenarioError(
            f"cannot be opened: {error.strerror}", where=lab.where, key=f"vehicle[{k}].address",
            value=str(address), advice="end what else uses this port, or name another",
        ) from None  # fmt: skip


def _at(frame: Any, clock: Clock) -> Any:
    """A frame with its time of arrival by our clock."""
    return type(frame)(
        frame.number, frame.capture_time, clock.of(frame.received_time), frame.bodies
    )


async def _main(order: Order) -> int:
    flying = Flying(order)
    loop = asyncio.get_running_loop()
    waiting = bytearray()

    def heard() -> None:
        data = os.read(0, 4096)
        if not data:
            loop.remove_reader(0)
            flying.lose_pilot()
        waiting.extend(data)
        while b"\n" in waiting:
            line, _, rest = bytes(waiting).partition(b"\n")
            waiting[:] = rest
            flying.hear(line.decode("ascii", "replace"))

    loop.add_reader(0, heard)
    try:
        await flying.run()
    except MultiliftError as error:
        flying.show({"error": str(error)})
        return 2
    finally:
        await flying.close()
    return 0


def main() -> int:
    """Flies what the first line of standard input says."""
    # The keys that interrupt are for the screen: it says what is to become of the flight.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    line = b""
    while not line.endswith(b"\n"):  # unbuffered: the rest is for the loop
        byte = os.read(0, 1)
        if not byte:
            return 1
        line += byte
    order = Order(**json.loads(line))
    try:
        return asyncio.run(_main(order))
    except MultiliftError as error:
        with socket.socket(fileno=os.dup(order.snapshots)) as out:
            out.send(json.dumps({"error": str(error)}).encode())
        return 2


if __name__ == "__main__":
    sys.exit(main())
