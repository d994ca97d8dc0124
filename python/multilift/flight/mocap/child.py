"""The process that reads a capture system: `python -m multilift.flight.mocap.child`.

Settings come as one line of JSON, messages go out as a length, a letter and content: "f" a frame,
"e" an error in words. It ends with the process that started it.
"""

from __future__ import annotations

import asyncio
import os
import struct
import sys
import threading
from typing import BinaryIO

from multilift.errors import MultiliftError
from multilift.flight.mocap import libmotioncapture, pipe, qualisys
from multilift.flight.mocap.frames import Frame
from multilift.flight.mocap.settings import Settings

#: Length of what follows it, then the letter.
HEAD = struct.Struct("<Ic")


def main() -> None:
    """Read settings, then send frames until nobody takes them."""
    out = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what libraries print is no message
    settings = Settings.from_json(sys.stdin.readline())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    names = tuple(settings.bodies)

    def send(frame: Frame) -> None:
        _write(out, b"f", pipe.frame_to_bytes(frame, names))

    async def run_qualisys() -> None:
        async for frame in qualisys.frames(settings):
            send(frame)

    try:
        if settings.system == "qualisys":
            asyncio.run(run_qualisys())
        else:
            for frame in libmotioncapture.frames(settings):
                send(frame)
    except MultiliftError as error:
        _write(out, b"e", str(error).encode())
    except BrokenPipeError:
        pass


def _write(out: BinaryIO, kind: bytes, content: bytes) -> None:
    out.write(HEAD.pack(len(content), kind) + content)


def _end_with_parent() -> None:
    """The other end of standard input closes when the parent is gone, however it went."""
    sys.stdin.read()
    os._exit(0)


if __name__ == "__main__":
    main()
