"""The process that writes a flight's log: ``python -m multilift.flight.log_writer FILE SOCKET``."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import sys
import time
from pathlib import Path
from typing import Any, BinaryIO

from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from multilift.flight.log import FLUSH_PERIOD, FRAME, NEW_TOPIC

_AT_ONCE = 2**18


class _Plain:
    """A file that grows record by record."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._writer: Any = Writer(file, use_chunking=False)
        self._writer.start(profile="", library="multilift")
        self._any = self._writer.register_schema("any", "jsonschema", b'{"type": "object"}')
        self._channels: dict[int, int] = {}
        self._sequence = 0

    def take(self, data: bytearray) -> None:
        """Writes the whole records at the start of the data and takes them away."""
        at = 0
        while len(data) - at >= FRAME.size:
            size, number, kind, stamp = FRAME.unpack_from(data, at)
            end = at + FRAME.size + size
            if end > len(data):
                break
            content = bytes(data[at + FRAME.size : end])
            if kind == NEW_TOPIC:
                encoding, _space, topic = content.decode().partition(" ")
                schema = self._any if encoding == "json" else 0
                self._channels[number] = self._writer.register_channel(topic, encoding, schema)
            else:
                self._sequence += 1
                channel = self._channels[number]
                self._writer.add_message(channel, stamp, content, stamp, self._sequence)
            at = end
        del data[:at]

    def flush(self) -> None:
        """Puts what was taken on the disk."""
        self._file.flush()
        os.fsync(self._file.fileno())

    def finish(self) -> None:
        """Ends the file."""
        self._writer.finish()
        self.flush()


def write(file: BinaryIO, source: socket.socket) -> None:
    """Writes what comes until nobody is left who could send."""
    plain, data = _Plain(file), bytearray()
    source.settimeout(FLUSH_PERIOD)
    due = time.monotonic() + FLUSH_PERIOD
    while True:
        try:
            came = source.recv(_AT_ONCE)
        except TimeoutError:
            came = None
        if came == b"":
            break
        if came is not None:
            data += came
            plain.take(data)
        if time.monotonic() >= due:
            plain.flush()
            due = time.monotonic() + FLUSH_PERIOD
    plain.finish()


def index(path: Path) -> None:
    """Writes a finished plain file anew with chunks, index and compression, in its place."""
    temporary = path.with_name(path.name + ".index")
    schemas, channels = {0: 0}, {}
    with path.open("rb") as old, temporary.open("wb") as new:
        writer: Any = Writer(new)
        writer.start(profile="", library="multilift")
        for record in StreamReader(old).records:
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic, record.message_encoding, schemas[record.schema_id]
                )
            elif isinstance(record, Message):
                writer.add_message(
                    channels[record.channel_id], record.log_time, record.data,
                    record.publish_time, record.sequence,
                )  # fmt: skip
        writer.finish()
        new.flush()
        os.fsync(new.fileno())
    temporary.replace(path)


def main() -> None:
    """Writes the file that the command line names from the socket that it names."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    path = Path(sys.argv[1])
    with path.open("wb") as file, socket.socket(fileno=int(sys.argv[2])) as source:
        write(file, source)
    with contextlib.suppress(OSError):  # no room for a second file: the plain one is complete
        index(path)


if __name__ == "__main__":
    main()
