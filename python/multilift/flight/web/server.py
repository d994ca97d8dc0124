"""The process that serves the page: ``python -m multilift.flight.web.server``.

Settings come as one line of JSON on standard input, whose end ends it; snapshots come and presses
go on a socket on which neither side waits.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import select
import socket
import sys
import time
from dataclasses import asdict, dataclass
from typing import Any

from multilift.flight.snapshot import Snapshot, from_dict
from multilift.flight.web.address import WebAddress
from multilift.flight.web.gate import Gate
from multilift.flight.web.stage import Stage

#: How often space, words and plots are drawn anew, s.
_PERIODS = {"space": 0.1, "words": 0.25, "plots": 0.5}

_MOST_BYTES = 2**18

#: The process that flies goes first where there is too little to go round.
_NICE = 10


@dataclass(frozen=True)
class Order:
    """What is to be served, and where.

    Attributes:
        host, port: of the page.
        token: that opens its buttons.
        channel: file descriptor of the socket to the command.
        stage: see `multilift.flight.web.stage.Stage`.
    """

    host: str
    port: int
    token: str
    channel: int
    stage: dict[str, Any]

    def to_json(self) -> str:
        """All of it in a line."""
        return json.dumps(asdict(self))


class Channel:
    """The other end of a `multilift.flight.web.page.Page`.

    Attributes:
        shown: the newest snapshot; None before the first.
        sent: when it was, by `time.monotonic`, s.
    """

    def __init__(self, descriptor: int) -> None:
        self._socket = socket.socket(fileno=descriptor)
        self._socket.setblocking(False)
        self.shown: Snapshot | None = None
        self.sent = 0.0

    def wait(self, patience: float) -> bool:
        """Takes the newest snapshot; whether the command is still there.

        Args:
            patience: how long one is waited for, s.
        """
        readable, _, _ = select.select([self._socket, sys.stdin], [], [], patience)
        if sys.stdin in readable and not os.read(sys.stdin.fileno(), 1):
            return False
        newest = None
        with contextlib.suppress(BlockingIOError):
            while data := self._socket.recv(_MOST_BYTES):
                newest = data
        if newest is not None:
            message = json.loads(newest)
            self.shown, self.sent = from_dict(message["snapshot"]), message["sent"]
        return True

    def say(self, **message: Any) -> None:
        """Gives a message away, if it is taken at once."""
        with contextlib.suppress(OSError):
            self._socket.send(json.dumps(message).encode())


def _serve(order: Order, channel: Channel) -> None:
    import viser  # noqa: PLC0415 - takes a second, and whoever flies imports this module, too
    import websockets.asyncio.server as sockets  # noqa: PLC0415

    from multilift.flight.web.drawing import Drawing  # noqa: PLC0415

    class Server(viser.ViserServer):
        def request_share_url(self, verbose: bool = True) -> str | None:
            """Never: any browser could ask viser to publish the page by way of its makers."""
            return None

    address = WebAddress(order.host, order.port)
    # A page of somebody else, in the same browser, is not to read along: viser asks nobody.
    sockets.serve = functools.partial(sockets.serve, origins=address.origins)  # type: ignore
    server = Server(order.host, order.port, verbose=False)
    if server.get_port() != order.port:
        raise OSError(f"{address} was taken meanwhile")
    drawing = Drawing(server, Stage.from_dict(order.stage), Gate(order.token), channel.say)
    channel.say(ready=True)
    due = dict.fromkeys(_PERIODS, 0.0)
    refused = 0
    while channel.wait(min(_PERIODS.values())):
        now = time.monotonic()
        age = now - channel.sent
        for what, period in _PERIODS.items():
            if channel.shown is not None and now >= due[what]:
                due[what] = now + period
                getattr(drawing, what)(channel.shown, age)
        if drawing.gate.refused != refused:
            refused = drawing.gate.refused
            channel.say(refused=refused)
    server.stop()


def main() -> int:
    """Serves what the first line of standard input says."""
    order = Order(**json.loads(sys.stdin.buffer.readline()))
    os.nice(_NICE)
    channel = Channel(order.channel)
    try:
        _serve(order, channel)
    except Exception as error:  # told to the command, which has a terminal
        channel.say(error=f"{type(error).__name__}: {error}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
