"""Where a vehicle's messages come from and go to."""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass

from multilift.errors import ScenarioError

_FORM = re.compile(r"(udpin|udpout):([0-9.]{7,15}|localhost):([0-9]{1,5})")


@dataclass(frozen=True)
class Address:
    """A UDP address.

    Attributes:
        listens: whether it is ours to bind; the peer is then whoever speaks first as it should.
        host: an IPv4 address.
        port: of UDP.
    """

    listens: bool
    host: str
    port: int

    @classmethod
    def parse(cls, text: str, where: str, key: str) -> Address:
        """The address that a text names.

        Raises:
            ScenarioError: if it names none.
        """
        match = _FORM.fullmatch(text)
        try:
            if match is None:
                raise ValueError
            host = "127.0.0.1" if match[2] == "localhost" else str(ipaddress.IPv4Address(match[2]))
            port = int(match[3])
            if not 1 <= port <= 65535:
                raise ValueError
        except ValueError:
            raise ScenarioError(
                "is no address", where=where, key=key, value=text,
                permitted="udpin:ADDRESS:PORT or udpout:ADDRESS:PORT, IPv4 in numbers",
                advice="bring a serial radio to UDP by a router such as mavlink-router",
            ) from None  # fmt: skip
        return cls(match[1] == "udpin", host, port)

    @property
    def is_local(self) -> bool:
        """Whether nothing leaves or enters this machine by it."""
        return ipaddress.IPv4Address(self.host).is_loopback

    def __str__(self) -> str:
        return f"{'udpin' if self.listens else 'udpout'}:{self.host}:{self.port}"
