"""The log of a flight: everything in and out, as MCAP, written by a process of its own.

What is put in goes to that process at once, through a socket that never blocks: a slow disk or a
collection of garbage there delays nothing here. It outlives this process: should that be killed,
all that was put in is still written. Should it be killed itself, the file holds all but what came
since its last write to disk, `FLUSH_PERIOD`.

While it grows the file is plain, so that every whole record counts; at the end it is written anew
with index and compression. `read` takes both.

Topics of a flight; JSON but for the first two; world ENU, body FLU, SI, quaternions scalar first:

- ``in/vehicle_K``, ``out/vehicle_K``: MAVLink datagrams of vehicle K, counted from 1.
- ``lab``, once: ``name``, ``title``, ``twin``, ``speed``, and ``scenario``, the TOML of what is
  flown.
- ``mocap``, a frame: ``number``, ``captured`` by the capture system's clock, ``bodies`` by our
  names, each position and attitude. The record's time is that of arrival.
- ``estimate``, a tick: ``age``, ``quality`` and ``fault`` of the worst body; ``bodies``, each
  position, velocity, attitude, angular rate in body axes; ``swing`` and ``tension`` of each cable.
- ``supervisor``, a tick: ``state``, how long it has ``lasted``, ``orders`` of the vehicles,
  ``may_send``, ``problems``, ``word`` of the pilot, the law's ``swing``, ``armed``, ``link_age``
  and ``charge`` of the vehicles.
- ``wanted``, a tick that steers: ``force`` of each vehicle, where each ``vehicle`` and the
  ``payload`` (null while it stands) shall be, ``yaw``. With the state "fly", ``lasted`` is the
  scenario's time.
- ``timing``, ten a second: what the loop has measured since it began, as
  `multilift.flight.snapshot.Timing`.
- ``error``: ``text`` of what ended motion capture.
- ``truth``, stepped twins only: ``vehicle``, ``vehicle_attitude``, ``payload``,
  ``payload_attitude``, ``tension``, ``taut``, ``standing`` as the plant has them.
"""

from __future__ import annotations

import contextlib
import json
import math
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from multilift.errors import OutputError

#: Between two writes to disk, s.
FLUSH_PERIOD = 0.05

#: What may wait here for a writer that is behind, and what the system may hold, bytes.
_MOST_WAITING = 8 * 2**20
_SYSTEM_BUFFER = 4 * 2**20

#: Before each record on the socket: bytes that follow, topic's number, time in ns; the number of
#: a new topic is followed by its name and encoding.
FRAME = struct.Struct("<IHBQ")
NEW_TOPIC, RECORD = 0, 1

#: What reading raises where a file is damaged or ends.
_DAMAGE = (McapError, ZstdError, struct.error, ValueError, LookupError, ArithmeticError,
           RecursionError, MemoryError)  # fmt: skip

#: How long the end of the writer is waited for, s.
_PATIENCE = 60.0


@dataclass(frozen=True)
class Entry:
    """One record of a log.

    Attributes:
        topic: such as "out/vehicle_1".
        time: Unix, ns.
        data: bytes, or what the JSON of them says.
    """

    topic: str
    time: int
    data: Any


class Log:
    """Takes records; `close` ends the file.

    Attributes:
        path: of the file.
        dropped: records that found the writer too far behind.
        count: records taken.
    """

    def __init__(self, path: Path, now: float) -> None:
        """Starts the writer.

        Args:
            path: of the new file.
            now: by the clock of all later times, s.

        Raises:
            OutputError: if the file is there or cannot be made.
        """
        try:
            path.open("xb").close()
        except OSError as error:
            raise OutputError(
                f"{path} cannot be written: {error.strerror}\n"
                "  what to do: name a new file in a folder that is yours"
            ) from None
        self.path = path
        self.dropped = self.count = 0
        self._unix = time.time_ns() - int(now * 1e9)
        self._topics: dict[str, int] = {}
        self._waiting = bytearray()
        ours, theirs = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SYSTEM_BUFFER)
        ours.setblocking(False)
        self._socket = ours
        command = [sys.executable, "-m", "multilift.flight.log_writer", str(path)]
        with theirs:
            # A session of its own: the keys that interrupt us are not for it.
            self._writer = subprocess.Popen(
                [*command, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                start_new_session=True,
                stdin=subprocess.DEVNULL,
            )

    @property
    def writer(self) -> int:
        """Process id of the writer."""
        return self._writer.pid

    @property
    def is_written(self) -> bool:
        """Whether the writer still runs."""
        return self._writer.poll() is None

    def raw(self, topic: str, now: float, data: bytes) -> None:
        """Takes bytes as they are."""
        self._put(topic, "mavlink", now, data)

    def write(self, topic: str, now: float, values: Mapping[str, Any]) -> None:
        """Takes numbers, texts and lists by name; numbers that JSON has not become null."""
        try:
            text = json.dumps(values, allow_nan=False)
        except ValueError:
            text = json.dumps(_finite(values))
        self._put(topic, "json", now, text.encode())

    def _put(self, topic: str, encoding: str, now: float, data: bytes) -> None:
        number = self._topics.get(topic)
        head = b""
        if number is None:
            number = self._topics[topic] = len(self._topics) + 1
            name = f"{encoding} {topic}".encode()
            head = FRAME.pack(len(name), number, NEW_TOPIC, 0) + name
        elif len(self._waiting) > _MOST_WAITING:
            self.dropped += 1
            self._push()
            return
        stamp = self._unix + int(now * 1e9)
        self._waiting += head + FRAME.pack(len(data), number, RECORD, max(stamp, 0)) + data
        self.count += 1
        self._push()

    def _push(self) -> None:
        """Gives the system what it takes."""
        try:
            while self._waiting:
                sent = self._socket.send(self._waiting)
                del self._waiting[:sent]
        except BlockingIOError:
            pass
        except OSError:  # the writer is gone: `is_written` says so
            self.dropped += 1
            self._waiting.clear()

    def close(self) -> None:
        """Gives the rest away and waits until the file is complete.

        Raises:
            OutputError: if the writer failed.
        """
        self._socket.setblocking(True)
        self._push()
        self._socket.close()
        if self._writer.wait(timeout=_PATIENCE) != 0:
            raise OutputError(
                f"{self.path} is not complete: its writer ended with {self._writer.returncode}\n"
                "  what to do: what was written until then can be read"
            )


def read(path: Path) -> Iterator[Entry]:
    """The records of a log, as many as are whole.

    Raises:
        OutputError: if the file cannot be read.
    """
    try:
        file = path.open("rb")
    except OSError as error:
        raise OutputError(f"{path} cannot be read: {error.strerror}") from None
    with file, contextlib.suppress(*_DAMAGE):
        topics: dict[int, Channel] = {}
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                topics[record.id] = record
            elif isinstance(record, Message):
                topic = topics[record.channel_id]
                text = topic.message_encoding == "json"
                data = json.loads(record.data) if text else record.data
                yield Entry(topic.topic, record.log_time, data)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
