"""What a radio does to datagrams: late, lost, twice, in another order, or not at all."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from random import Random

from multilift.flight.link.udp import Source
from multilift.flight.link.vehicle import Transport

_IN, _OUT = 0, 1


@dataclass(frozen=True)
class Radio:
    """How bad a radio is, in each direction alike.

    Attributes:
        delay: of every datagram, s.
        jitter: added to it, up to so much, s.
        loss: part that never arrives.
        double: part that arrives twice.
        overtakes: whether what is less late passes what is later, or waits behind it.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    double: float = 0.0
    overtakes: bool = False


@dataclass
class Impaired:
    """A transport behind a radio; everything that waits moves on when it is asked to receive.

    Attributes:
        inner: carries what the radio lets through.
        radio: may be exchanged at any time.
        clock: by which things are late, s.
        dice: of the radio.
        dead: whether nothing passes now.
    """

    inner: Transport
    radio: Radio
    clock: Callable[[], float]
    dice: Random
    dead: bool = False
    _arriving: list[tuple[float, int, bytes, Source]] = field(default_factory=list)
    _leaving: list[tuple[float, int, bytes]] = field(default_factory=list)
    _last: list[float] = field(default_factory=lambda: [0.0, 0.0])
    _count: int = 0

    @property
    def peer(self) -> Source | None:
        """As of the inner one."""
        return self.inner.peer

    @peer.setter
    def peer(self, source: Source | None) -> None:
        self.inner.peer = source

    def receive(self) -> Iterator[tuple[bytes, Source]]:
        """What has come and is due; what is due to leave does."""
        now = self.clock()
        for data, source in self.inner.receive():
            for due in self._dues(now, _IN):
                heapq.heappush(self._arriving, (due, self._count, data, source))
        while self._leaving and self._leaving[0][0] <= now:
            self.inner.send(heapq.heappop(self._leaving)[2])
        while self._arriving and self._arriving[0][0] <= now:
            _due, _count, data, source = heapq.heappop(self._arriving)
            yield data, source

    def send(self, data: bytes) -> None:
        """Lets it leave when it is due."""
        for due in self._dues(self.clock(), _OUT):
            heapq.heappush(self._leaving, (due, self._count, data))

    def forget_peer(self) -> None:
        """As the inner one."""
        self.inner.forget_peer()

    def _dues(self, now: float, way: int) -> Iterator[float]:
        """When one datagram arrives: never, once or twice."""
        radio, dice = self.radio, self.dice
        if self.dead or dice.random() < radio.loss:
            return
        for _ in range(2 if dice.random() < radio.double else 1):
            self._count += 1
            due = now + radio.delay + radio.jitter * dice.random()
            if not radio.overtakes:
                due = max(due, self._last[way])
            self._last[way] = due
            yield due
