"""What comes in by a socket: which bytes are a message that is meant for us, and which are not.

MAVLink 2 alone, whole frames in a datagram. Everything else is counted by its reason and dropped;
nothing here raises, keeps bytes of a datagram that was bad, or looks at a length before its end.
"""

from __future__ import annotations

import hashlib
import hmac
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.generator.mavcrc import x25crc

#: Most bytes of a datagram: as many frames as a router packs into one, and no more.
LARGEST_DATAGRAM = 2048

_MAGIC = 0xFD
_SIGNED = 0x01
_HEADER = 10
_CHECKSUM = 2
_SIGNATURE = 13

#: How far back in the count of frames one is late or sent again; beyond, the peer began anew.
_LATE = 64

#: So many late frames in a row, and the peer did begin anew.
_ANEW = 8

#: How far a signature's time may lie from the newest one at first sight: one minute, in 10 us.
_SIGNATURE_WINDOW = 6_000_000

#: Why something was dropped.
REASONS = ("oversized", "malformed", "unknown", "alien", "unsigned", "forged", "replayed")


@dataclass
class Signatures:
    """Checks of signatures of one link.

    Attributes:
        key: 32 bytes.
        newest: the newest time among accepted signatures and our own clock, 10 us since 2015.
    """

    key: bytes
    newest: int = 0
    _streams: dict[tuple[int, int, int], int] = field(default_factory=dict)

    def verdict(self, frame: bytes) -> str:
        """The reason to drop a signed frame, "" if there is none.

        The digest comes first: what nobody of ours signed must not move any clock.
        """
        block = frame[-_SIGNATURE:]
        digest = hashlib.sha256(self.key + frame[:-6]).digest()[:6]
        if not hmac.compare_digest(digest, block[7:]):
            return "forged"
        time = int.from_bytes(block[1:7], "little")
        stream = (block[0], frame[5], frame[6])
        last = self._streams.get(stream, self.newest - _SIGNATURE_WINDOW)
        if time <= last:
            return "replayed"
        self._streams[stream] = time
        self.newest = max(self.newest, time)
        return ""


class Guard:
    """Takes datagrams of one vehicle, gives messages.

    Attributes:
        dropped: how many frames or datagrams, by reason.
        accepted: how many messages.
    """

    def __init__(self, system: int, component: int, signatures: Signatures | None = None) -> None:
        """Lets only one sender through.

        Args:
            system: id of the autopilot.
            component: the same.
            signatures: without, signed frames pass unchecked and unsigned ones pass.
        """
        self.dropped: Counter[str] = Counter(dict.fromkeys(REASONS, 0))
        self.accepted = 0
        self._system, self._component = system, component
        self._signatures = signatures
        self._decoder = mavlink.MAVLink(None)
        self._last: int | None = None
        self._late = 0

    def messages(self, datagram: bytes) -> Iterator[Any]:
        """The messages of a datagram that may be acted on, in order."""
        if len(datagram) > LARGEST_DATAGRAM:
            self.dropped["oversized"] += 1
            return
        rest = datagram
        while rest:
            length = _length(rest)
            if not length:
                self.dropped["malformed"] += 1
                return
            frame, rest = rest[:length], rest[length:]
            reason, message = self._read(frame)
            if reason:
                self.dropped[reason] += 1
            else:
                self.accepted += 1
                yield message

    def _read(self, frame: bytes) -> tuple[str, Any]:
        reason = _damage(frame) or self._stranger(frame)
        if reason:
            return reason, None
        try:
            return "", self._decoder.decode(bytearray(frame))
        except (mavlink.MAVError, ValueError, struct.error):
            return "malformed", None

    def _stranger(self, frame: bytes) -> str:
        """Why a whole frame is not from our vehicle now, "" if it is."""
        if (frame[5], frame[6]) != (self._system, self._component):
            return "alien"
        if self._signatures is not None:
            is_signed = frame[2] & _SIGNED
            reason = self._signatures.verdict(frame) if is_signed else "unsigned"
            if reason:
                return reason
        return "replayed" if self._comes_again(frame[4]) else ""

    def _comes_again(self, count: int) -> bool:
        """Whether a frame was seen or is behind one that was, by the count that frames carry."""
        behind = (self._last - count) % 256 if self._last is not None else 256
        if behind < _LATE and self._late < _ANEW:
            self._late += 1
            return True
        self._last, self._late = count, 0
        return False


def is_for(message: Any, system: int, component: int) -> bool:
    """Whether a message names us as its target, everyone, or nobody."""
    target = getattr(message, "target_system", 0)
    part = getattr(message, "target_component", 0)
    return target in (0, system) and part in (0, component)


def _length(data: bytes) -> int:
    """Of the frame at the start of the data, 0 if there is no whole one."""
    if len(data) < _HEADER + _CHECKSUM or data[0] != _MAGIC or data[2] & ~_SIGNED:
        return 0
    length = _HEADER + data[1] + _CHECKSUM + (_SIGNATURE if data[2] & _SIGNED else 0)
    return length if length <= len(data) else 0


def _damage(frame: bytes) -> str:
    """Why the bytes of a frame are no message, "" if they are one."""
    kind = mavlink.mavlink_map.get(int.from_bytes(frame[7:10], "little"))
    if kind is None:
        return "unknown"
    end = len(frame) - (_SIGNATURE if frame[2] & _SIGNED else 0)
    crc = x25crc(frame[1 : end - _CHECKSUM] + bytes([kind.crc_extra])).crc
    if struct.unpack_from("<H", frame, end - _CHECKSUM)[0] != crc:
        return "malformed"
    return "oversized" if frame[1] > kind.unpacker.size else ""
