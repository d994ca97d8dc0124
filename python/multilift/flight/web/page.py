"""The page as the command that flies holds it: a process that may be slow, stuck or dead."""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import subprocess
import sys
import time
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from multilift.errors import MultiliftError
from multilift.flight.lab import Lab
from multilift.flight.snapshot import Snapshot, to_dict
from multilift.flight.supervisor import Word
from multilift.flight.web import server
from multilift.flight.web.address import WebAddress
from multilift.flight.web.gate import new_token
from multilift.flight.web.stage import stage_of

#: Room for snapshots that the page has not taken: a few of many vehicles, bytes.
_ROOM = 2**18
_MOST_BYTES = 2**16

#: How long the page may take to begin and to end, s.
_TO_BEGIN = 60.0
_TO_END = 30.0

#: What makes something begin; it counts only as an answer to what is still so.
_BEGINNINGS = (Word.START, Word.GO)

#: After which such a word is of the past, s.
_LATE = 2.0


@dataclass(frozen=True)
class Press:
    """A button that was pressed.

    Attributes:
        word: what it says.
        state: of the supervisor, as the page showed it.
        time: when it was, by `time.monotonic`, which all processes of a machine share, s.
    """

    word: Word
    state: str
    time: float

    def counts(self, shown: Snapshot, now: float) -> bool:
        """Whether it is to be said: what stops always, what begins only if nothing has changed.

        Args:
            shown: the newest snapshot.
            now: s.
        """
        if self.word.value not in shown.words:
            return False
        return self.word not in _BEGINNINGS or (
            self.state == shown.state and now - self.time <= _LATE
        )


class Page:
    """The process that serves the page.

    Attributes:
        address: where it is.
        token: that opens its buttons.
        refused: wrong tokens so far.
        trouble: why it is gone; "" while it is there.
    """

    def __init__(self, lab: Lab, address: WebAddress, where: str) -> None:
        """Starts it and waits until it can be looked at.

        Args:
            lab: what is flown.
            address: where the page shall be.
            where: the command, for errors.

        Raises:
            MultiliftError: if it cannot begin.
        """
        self.address = address.free(where)
        self.token = new_token()
        self.refused = 0
        self.trouble = ""
        self._sent: Snapshot | None = None
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        for end in (ours, theirs):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _ROOM)
            end.setblocking(False)
        self._channel = ours
        with theirs:
            # Not our keys, not our terminal: viser prints.
            self._process = subprocess.Popen(
                [sys.executable, "-m", server.__name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                start_new_session=True,
                env={k: v for k, v in os.environ.items() if k != "_VISER_PORT_OVERRIDE"},
            )
            order = server.Order(
                self.address.host, self.address.port, self.token, theirs.fileno(),
                stage_of(lab).to_dict(),
            )  # fmt: skip
            assert self._process.stdin is not None
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.write(order.to_json().encode() + b"\n")
                self._process.stdin.flush()
        try:
            self._wait()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Page:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def show(self, shown: Snapshot | None) -> None:
        """Hands over a snapshot that is new, if it is taken at once."""
        if shown is None or shown is self._sent:
            return
        self._sent = shown
        message = {"snapshot": to_dict(shown), "sent": time.monotonic()}
        with contextlib.suppress(OSError):
            self._channel.send(json.dumps(message).encode())

    def words(self) -> list[Word]:
        """What was pressed since the last time and counts; never waits."""
        presses = []
        while (message := self._received()) is not None:
            if "press" in message:
                presses.append(Press(Word(message["press"]), message["state"], message["time"]))
            self.refused = message.get("refused", self.refused)
            self.trouble = message.get("error", self.trouble)
        if not self.trouble and self._process.poll() is not None:
            self.trouble = f"its process ended ({self._process.returncode})"
        shown, now = self._sent, time.monotonic()
        return [] if shown is None else [p.word for p in presses if p.counts(shown, now)]

    @property
    def note(self) -> str:
        """For the pilot, in a line."""
        if self.trouble:
            return f"The web page is gone: {self.trouble}"
        wrong = f", {self.refused} wrong so far" if self.refused else ""
        return f"Web page {self.address.url}  token {self.token}{wrong}"

    def close(self) -> None:
        """Ends it."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(_TO_END)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._channel.close()

    def _received(self) -> dict[str, Any] | None:
        try:
            data = self._channel.recv(_MOST_BYTES)
        except OSError:
            return None
        message: dict[str, Any] = json.loads(data)
        return message

    def _wait(self) -> None:
        end = time.monotonic() + _TO_BEGIN
        while time.monotonic() < end and self._process.poll() is None:
            select.select([self._channel], [], [], 0.1)
            message = self._received() or {}
            if "error" in message:
                raise MultiliftError(f"the web page did not begin: {message['error']}")
            if "ready" in message:
                return
        last = self._received() or {}
        raise MultiliftError(
            f"the web page did not begin: {last.get('error', 'its process says nothing')}"
        )
