"""A capture system read in a process of its own, so that no client can stall the flight loop.

The maker's client loops without end on a packet of size 0, and `motioncapture` on a server that
went away; here either is silence, which the estimator reports and `close` ends.
"""

from __future__ import annotations

import asyncio
import sys
from collections import deque

from multilift.flight.mocap import child, pipe
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Frame
from multilift.flight.mocap.settings import Settings

#: Frames that wait for the reader at most; the oldest go first.
_MOST_WAITING = 32


class CaptureSource:
    """Frames from a capture system.

    Attributes:
        dropped: frames that were dropped here because nobody read them in time.
        malformed: messages that were not frames, or not whole.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.dropped = 0
        self.malformed = 0
        self._waiting: deque[Frame] = deque(maxlen=_MOST_WAITING)
        self._news = asyncio.Event()
        self._error: CaptureError | None = None
        self._process: asyncio.subprocess.Process | None = None
        self._reader: asyncio.Task[None] | None = None

    async def open(self, timeout: float = 10.0) -> None:
        """Connect, and wait for the first frame.

        Raises:
            CaptureError: no server, no such body, no frame within the timeout.
        """
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            child.__name__,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        assert self._process.stdin is not None
        self._process.stdin.write(self.settings.to_json().encode() + b"\n")
        self._reader = asyncio.create_task(self._read())
        try:
            async with asyncio.timeout(timeout):
                await self._news.wait()
        except TimeoutError:
            await self.close()
            raise CaptureError(
                f"{self.settings.system} at {self.settings.host}: no frame within {timeout:g} s\n"
                "  what to do: check that the system measures and streams rigid bodies"
            ) from None
        if self._error is not None:
            await self.close()
            raise self._error

    async def next(self) -> Frame:
        """The oldest frame that waits, or the next to come.

        Raises:
            CaptureError: the source ended.
        """
        while not self._waiting:
            if self._error is not None:
                raise self._error
            self._news.clear()
            await self._news.wait()
        return self._waiting.popleft()

    def drain(self) -> list[Frame]:
        """All frames that wait, oldest first; never waits itself.

        Raises:
            CaptureError: the source ended, and all of its frames have been given.
        """
        found = list(self._waiting)
        self._waiting.clear()
        if not found and self._error is not None:
            raise self._error
        return found

    async def close(self) -> None:
        """End the process; more than once does no harm."""
        process, self._process = self._process, None
        if process is not None:
            if process.returncode is None:
                process.kill()
            await process.wait()
        if self._reader is not None:
            await self._reader
            self._reader = None

    async def _read(self) -> None:
        assert self._process is not None
        assert self._process.stdout is not None
        stream = self._process.stdout
        names = tuple(self.settings.bodies)
        ended = f"{self.settings.system} at {self.settings.host}: the reading process ended"
        try:
            while True:
                size, kind = child.HEAD.unpack(await stream.readexactly(child.HEAD.size))
                if size > pipe.LARGEST:
                    raise CaptureError(f"{ended}: a message of {size} bytes")
                content = await stream.readexactly(size)
                if kind == b"e":
                    raise CaptureError(content.decode(errors="replace"))
                self._take(content, names)
        except CaptureError as error:
            self._error = error
        except asyncio.IncompleteReadError:
            self._error = CaptureError(ended)
        self._news.set()

    def _take(self, content: bytes, names: tuple[str, ...]) -> None:
        try:
            frame = pipe.frame_from_bytes(content, names)
        except ValueError:
            self.malformed += 1
            return
        self.dropped += len(self._waiting) == _MOST_WAITING
        self._waiting.append(frame)
        self._news.set()
