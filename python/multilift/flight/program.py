"""All processes of a flight, as whoever shows it holds them.

With hardware that is the process that flies; a twin has its plant and RT server, and one process
for each autopilot, too. All of them end with this one, however that ends.
"""

from __future__ import annotations

import json
import select
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from multilift.errors import MultiliftError
from multilift.flight import process
from multilift.flight.lab import Lab
from multilift.flight.snapshot import Snapshot, from_dict
from multilift.flight.supervisor import Word
from multilift.flight.twin import pilot, server

#: Room for snapshots that nobody has looked at, bytes.
_ROOM = 2**20
_MOST_BYTES = 2**18

#: How long processes may take to begin and to end, s.
_TO_BEGIN = 60.0
_TO_END = 90.0


class Program:
    """A flight and everything that it needs.

    Attributes:
        lab: what is flown.
        log: path of the log.
        snapshot: the last that came; None before the first.
        is_over: whether the process that flies has ended, and the log is complete.
    """

    def __init__(self, lab: Lab, path: Path, log: Path, *, speed: float = 1.0) -> None:
        """Starts everything.

        Args:
            lab: of the file; one without hardware is flown as a twin.
            path: of the lab file.
            log: of the new log.
            speed: of a twin's clock.

        Raises:
            MultiliftError: if something cannot begin.
        """
        self.lab, self.log = lab, log
        self.snapshot: Snapshot | None = None
        self.is_over = False
        self._twins: list[subprocess.Popen[bytes]] = []
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        theirs.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _ROOM)
        ours.setblocking(False)
        self._shown = ours
        kind = "twin" if lab.is_twin else "real"
        ports = {"capture": 0, "plant": 0}
        if lab.is_twin:
            plant = self._start(server.__name__, str(path), kind, str(speed))
            self._twins.append(plant)
            ports = self._said_by(plant)
        with theirs:
            self.flying = self._start(process.__name__, fds=(theirs.fileno(),))
            order = process.Order(
                str(path), lab.is_twin, speed, str(log), ports["capture"], theirs.fileno()
            )
            self._tell(order.to_json())
        try:
            stations = self._wait_for("ports")
            if lab.is_twin:
                for k, station in enumerate(stations):
                    where = (str(path), kind, str(k), str(ports["plant"]), str(station))
                    self._twins.append(self._start(pilot.__name__, *where))
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Program:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def say(self, word: Word) -> None:
        """What the pilot says."""
        self._tell(word.value)

    def leave(self) -> None:
        """Ends the program once all is on the ground."""
        self._tell("leave")

    def look(self, patience: float = 0.0) -> Snapshot | None:
        """The newest snapshot.

        Args:
            patience: how long a new one is waited for, s.

        Raises:
            MultiliftError: what ended the flight, if something did.
        """
        select.select([self._shown], [], [], patience)
        while (message := self._received()) is not None:
            if "snapshot" in message:
                self.snapshot = from_dict(message["snapshot"])
        if self.flying.poll() is not None:
            self.is_over = True
        return self.snapshot

    def close(self) -> None:
        """Ends everything; a vehicle in the air is landed first, unless it is a twin's."""
        if self.flying.stdin is not None:
            self.flying.stdin.close()
        if self.lab.is_twin and not self.is_over:
            self.flying.terminate()
        try:
            self.flying.wait(_TO_END if self.is_over else None)
        except subprocess.TimeoutExpired:
            self.flying.kill()
            self.flying.wait()
        for twin in self._twins:
            if twin.stdin is not None:
                twin.stdin.close()
            if twin.stdout is not None:
                twin.stdout.close()
        for twin in self._twins:
            try:
                twin.wait(_TO_BEGIN)
            except subprocess.TimeoutExpired:
                twin.kill()
                twin.wait()
        self._shown.close()

    def _start(
        self, module: str, *words: str, fds: tuple[int, ...] = ()
    ) -> subprocess.Popen[bytes]:
        # A session of its own: the keys that interrupt us are not for it.
        return subprocess.Popen(
            [sys.executable, "-m", module, *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE if module == server.__name__ else None,
            pass_fds=fds,
            start_new_session=True,
        )

    def _said_by(self, child: subprocess.Popen[bytes]) -> dict[str, int]:
        assert child.stdout is not None
        line = child.stdout.readline()
        if not line:
            raise MultiliftError("the twin's plant did not begin: see what it said above")
        said: dict[str, int] = json.loads(line)
        return said

    def _tell(self, line: str) -> None:
        assert self.flying.stdin is not None
        try:
            self.flying.stdin.write(line.encode() + b"\n")
            self.flying.stdin.flush()
        except (BrokenPipeError, ValueError):  # it has ended: `look` says so
            pass

    def _received(self) -> dict[str, Any] | None:
        try:
            data = self._shown.recv(_MOST_BYTES)
        except BlockingIOError:
            return None
        message: dict[str, Any] = json.loads(data)
        if "error" in message:
            self.is_over = True
            raise MultiliftError(message["error"])
        return message

    def _wait_for(self, what: str) -> Any:
        end = time.monotonic() + _TO_BEGIN
        while time.monotonic() < end:
            select.select([self._shown], [], [], 0.2)
            message = self._received()
            if message is not None and what in message:
                return message[what]
            if message is None and self.flying.poll() is not None:
                break
        raise MultiliftError("the process that flies did not begin: see what it said above")
