"""Datagrams to and from one vehicle."""

from __future__ import annotations

import socket
from collections.abc import Iterator

from multilift.flight.link.address import Address
from multilift.flight.link.guard import LARGEST_DATAGRAM

Source = tuple[str, int]

#: Most datagrams taken at once: a flood must not hold the loop up.
_AT_ONCE = 64


class Udp:
    """A socket that never blocks.

    Attributes:
        peer: where datagrams go and the only source they are taken from; None until someone who
            may has spoken.
        strangers: datagrams from elsewhere.
        unsent: datagrams that the system did not take.
    """

    def __init__(self, address: Address) -> None:
        """Binds or aims the socket.

        Raises:
            OSError: if the address is taken or not ours.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            here = (address.host, address.port) if address.listens else ("", 0)
            if not address.listens and address.is_local:
                here = (address.host, 0)
            self._socket.bind(here)
        except OSError:
            self._socket.close()
            raise
        self._aimed = not address.listens
        self.peer: Source | None = (address.host, address.port) if self._aimed else None
        self.strangers = 0
        self.unsent = 0

    @property
    def port(self) -> int:
        """That we have."""
        return int(self._socket.getsockname()[1])

    def receive(self) -> Iterator[tuple[bytes, Source]]:
        """What has come, at most so much at once."""
        for _ in range(_AT_ONCE):
            try:
                # One byte more, so that too much is seen as too much.
                data, source = self._socket.recvfrom(LARGEST_DATAGRAM + 1)
            except BlockingIOError:
                return
            except OSError:  # the peer's port is closed: it will be open again or age
                continue
            if self.peer is not None and source != self.peer:
                self.strangers += 1
                continue
            yield data, source

    def send(self, data: bytes) -> None:
        """Sends to the peer, if there is one; what the system does not take is counted."""
        if self.peer is None:
            return
        try:
            self._socket.sendto(data, self.peer)
        except OSError:
            self.unsent += 1

    def forget_peer(self) -> None:
        """Lets another source speak, where we listen: the vehicle may have begun anew."""
        if not self._aimed:
            self.peer = None

    def close(self) -> None:
        """Gives the port back."""
        self._socket.close()
