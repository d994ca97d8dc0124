"""STATUSTEXT: what a vehicle says in words, put together again and safe to print."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

#: How many texts are kept, and how many parts a long one may have.
_KEPT = 200
_MOST_PARTS = 16

#: Letters that one STATUSTEXT holds; a shorter part is the last one.
_PART = 50


def printable(raw: bytes | str) -> str:
    """Letters alone: a terminal must not take orders from a vehicle."""
    text = raw.decode("utf-8", "replace") if isinstance(raw, bytes) else raw
    return "".join(c if c.isprintable() else "?" for c in text.split("\0", 1)[0])


@dataclass(frozen=True)
class Text:
    """What was said.

    Attributes:
        time: when its last part came, s.
        severity: of syslog: 0 emergency ... 7 debug.
        text: in one line.
    """

    time: float
    severity: int
    text: str


@dataclass
class Texts:
    """The texts of one vehicle, newest last."""

    said: deque[Text] = field(default_factory=lambda: deque(maxlen=_KEPT))
    _number: int = 0
    _parts: list[str] = field(default_factory=list)

    def sees(self, raw: bytes | str, severity: int, number: int, part: int, now: float) -> None:
        """Takes in one STATUSTEXT; parts of a long one come under one number, counted from 0."""
        piece = printable(raw)
        if number == 0:
            self.said.append(Text(now, severity, piece))
            return
        if part == 0 or number != self._number:
            self._number, self._parts = number, []
        if part != len(self._parts) or part >= _MOST_PARTS:
            self._parts.append("...")
        self._parts = [*self._parts[:_MOST_PARTS], piece]
        if len(raw) < _PART or part >= _MOST_PARTS - 1:
            self.said.append(Text(now, severity, "".join(self._parts)))
            self._number, self._parts = 0, []
