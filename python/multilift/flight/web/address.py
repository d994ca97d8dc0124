"""Where the page is served."""

from __future__ import annotations

import ipaddress
import re
import socket
from dataclasses import dataclass

from multilift.errors import ScenarioError

#: Where it is unless told otherwise: seen from this machine alone.
DEFAULT = "127.0.0.1:8080"

_FORM = re.compile(r"([0-9.]{7,15}|localhost):([0-9]{1,5})")
_KEY = "--web-address"


@dataclass(frozen=True)
class WebAddress:
    """An address of this machine.

    Attributes:
        host: an IPv4 address.
        port: of TCP; 0 for any that is free.
    """

    host: str
    port: int

    @classmethod
    def parse(cls, text: str, where: str) -> WebAddress:
        """The address that a text names.

        Raises:
            ScenarioError: if it names none, or all at once.
        """
        match = _FORM.fullmatch(text)
        try:
            if match is None:
                raise ValueError
            host = "127.0.0.1" if match[1] == "localhost" else str(ipaddress.IPv4Address(match[1]))
            port = int(match[2])
            if port > 65535 or not int(ipaddress.IPv4Address(host)):
                raise ValueError
        except ValueError:
            raise ScenarioError(
                "is no address for a page", where=where, key=_KEY, value=text[:80],
                permitted="ADDRESS:PORT, one IPv4 address of this machine in numbers; port 0 is "
                "any that is free",
                advice=f"{DEFAULT} is seen from this machine alone",
            ) from None  # fmt: skip
        return cls(host, port)

    @property
    def is_local(self) -> bool:
        """Whether only this machine sees it."""
        return ipaddress.IPv4Address(self.host).is_loopback

    @property
    def url(self) -> str:
        """For a browser."""
        return f"http://{self}"

    @property
    def origins(self) -> list[str]:
        """What pages served here call themselves; a browser says so of the page that connects."""
        return [self.url, f"http://localhost:{self.port}"] if self.is_local else [self.url]

    def free(self, where: str) -> WebAddress:
        """The same with a port that can be had.

        Raises:
            ScenarioError: if it cannot.
        """
        with socket.socket() as trial:
            # What a page that has just ended leaves behind is no hindrance.
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                trial.bind((self.host, self.port))
                trial.listen()
            except OSError as error:
                raise ScenarioError(
                    f"cannot be had: {error.strerror}", where=where, key=_KEY, value=str(self),
                    advice="end what else uses it, or name another: "
                    f"{_KEY} {self.host}:{(self.port + 1) % 65536}",
                ) from None  # fmt: skip
            return WebAddress(self.host, int(trial.getsockname()[1]))

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"
