"""Qualisys' real-time protocol, little-endian, as bytes: what clients send and what QTM answers.

A packet is its whole size and its type, 32 bits each, then its content. After the public
description of the protocol, versions 1.8 (single precision) and later.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from xml.sax.saxutils import escape

from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Pose

#: Greatest packet that is taken from a client; its commands are tens of bytes long.
LARGEST_REQUEST = 4096

#: First and last minor version of protocol 1 that is spoken here.
VERSIONS = range(8, 29)

#: From this minor version on, bodies stand in the parameters without a table of their own.
_NEW_BODIES = 21

_HEADER = struct.Struct("<II")
_FRAME = struct.Struct("<qII")
_COMPONENT = struct.Struct("<IIIhh")


class Packet(IntEnum):
    """Types of packets."""

    ERROR = 0
    COMMAND = 1
    XML = 2
    DATA = 3
    NO_MORE_DATA = 4
    EVENT = 6


class Event(IntEnum):
    """What QTM says that it is doing."""

    CONNECTED = 1
    CONNECTION_CLOSED = 2


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of component of a data packet.

    Attributes:
        number: of the type, in the packet.
        rotation: "matrix", "angles", or "" for markers, of which there are none here.
        residual: whether each body ends with its residual.
    """

    number: int
    rotation: str = ""
    residual: bool = False


#: Components by their names in commands, in small letters.
KINDS = {
    "3d": Kind(1),
    "3dnolabels": Kind(2),
    "6d": Kind(5, "matrix"),
    "6deuler": Kind(6, "angles"),
    "3dres": Kind(9),
    "3dnolabelsres": Kind(10),
    "6dres": Kind(11, "matrix", True),
    "6deulerres": Kind(12, "angles", True),
}


@dataclass(frozen=True, slots=True)
class Capture:
    """What the cameras saw at one instant.

    Attributes:
        number: of the frame, counting from 1.
        time: since the capture began, s.
        poses: in the order of the server's bodies; None for one that was not seen.
    """

    number: int
    time: float
    poses: Sequence[Pose | None]


@dataclass(frozen=True, slots=True)
class Request:
    """A packet that a client sent: type and content, without the zero byte at its end."""

    kind: int
    content: bytes


class RequestError(Exception):
    """Bytes that are no packet; where the next one would begin is not known."""


class RequestReader:
    """Cuts a client's bytes into packets; holds at most one packet that is not whole."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[Request]:
        """The packets that are whole now.

        Raises:
            RequestError: a size that is less than a header or more than LARGEST_REQUEST. What
                was whole before it is lost; the connection is of no use any more.
        """
        self._rest += data
        found = []
        start = 0
        while len(self._rest) - start >= _HEADER.size:
            size, kind = _HEADER.unpack_from(self._rest, start)
            if not _HEADER.size <= size <= LARGEST_REQUEST:
                raise RequestError(f"a packet of {size} bytes")
            if len(self._rest) - start < size:
                break
            content = self._rest[start + _HEADER.size : start + size]
            found.append(Request(kind, content.removesuffix(b"\0")))
            start += size
        self._rest = self._rest[start:]
        return found


def text_packet(kind: Packet, text: str) -> bytes:
    """A command, an error or XML: text and a zero byte."""
    content = text.encode() + b"\0"
    return _HEADER.pack(_HEADER.size + len(content), kind) + content


def event_packet(event: Event) -> bytes:
    """One byte that says what happened."""
    return _HEADER.pack(_HEADER.size + 1, Packet.EVENT) + bytes([event])


def no_more_data_packet() -> bytes:
    """Sent where a frame is asked for and there is none."""
    return _HEADER.pack(_HEADER.size, Packet.NO_MORE_DATA)


def data_packet(capture: Capture, components: Sequence[str]) -> bytes:
    """One frame.

    Args:
        capture: what to send; metres become millimetres here.
        components: names in KINDS.
    """
    parts = [_component(KINDS[name], capture.poses) for name in components]
    content = _FRAME.pack(round(capture.time * 1e6), capture.number, len(parts)) + b"".join(parts)
    return _HEADER.pack(_HEADER.size + len(content), Packet.DATA) + content


def _component(kind: Kind, poses: Sequence[Pose | None]) -> bytes:
    bodies = [_body(kind, pose) for pose in poses] if kind.rotation else []
    content = b"".join(bodies)
    return _COMPONENT.pack(_COMPONENT.size + len(content), kind.number, len(bodies), 0, 0) + content


def _body(kind: Kind, pose: Pose | None) -> bytes:
    turns = 9 if kind.rotation == "matrix" else 3
    if pose is None:
        numbers = [math.nan] * (3 + turns + kind.residual)
    else:
        numbers = [1e3 * x for x in pose.position]
        if kind.rotation == "matrix":
            rows = rotations.matrix(pose.attitude)
            numbers += [rows[i][j] for j in range(3) for i in range(3)]  # column by column
        else:
            numbers += map(math.degrees, rotations.to_angles(pose.attitude))
        if kind.residual:
            numbers.append(1e3 * pose.residual)
    return struct.pack(f"<{len(numbers)}f", *numbers)


def parameters_xml(names: Sequence[str], rate: float, version: int, wanted: Sequence[str]) -> str:
    """The answer to GetParameters.

    Args:
        names: of the bodies.
        rate: of capture, Hz.
        version: minor version that the client chose; the layout of bodies depends on it.
        wanted: of "all", "general", "6d", "3d" in small letters; the last has nothing in it here.
    """
    parts = []
    if {"all", "general"} & set(wanted):
        parts.append(f"<General><Frequency>{rate:g}</Frequency></General>")
    if {"all", "3d"} & set(wanted):
        parts.append("<The_3D><AxisUpwards>+Z</AxisUpwards><Labels>0</Labels></The_3D>")
    if {"all", "6d"} & set(wanted):
        new = version >= _NEW_BODIES
        bodies = "".join(_body_xml(name, new) for name in names)
        count = "" if new else f"<Bodies>{len(names)}</Bodies>"
        euler = "<Euler><First>Roll</First><Second>Pitch</Second><Third>Yaw</Third></Euler>"
        parts.append(f"<The_6D>{count}{bodies}{euler}</The_6D>")
    table = f"QTM_Parameters_Ver_1.{version:02d}"
    return f"<{table}>{''.join(parts)}</{table}>"


def _body_xml(name: str, new: bool) -> str:
    named = f"<Name>{escape(name)}</Name>"
    if not new:
        return f"<Body>{named}<RGBColor>65280</RGBColor></Body>"
    return (
        f"<Body>{named}<Enabled>true</Enabled><Color R='0' G='255' B='0'/>"
        "<MaximumResidual>10</MaximumResidual><MinimumMarkersInBody>3</MinimumMarkersInBody>"
        "<BoneLengthTolerance>5</BoneLengthTolerance><Filter Preset='No filter'/>"
        "<Points/><Data_origin Relative_body='0'>0</Data_origin>"
        "<Data_orientation Relative_body='0'/></Body>"
    )


@dataclass(frozen=True, slots=True)
class Stream:
    """What a client asked to have streamed.

    Attributes:
        components: names in KINDS.
        divisor: every n-th frame by its number; 1 for all.
        period: least time between two frames, s; 0 for all.
        udp_port: where to send them; None on the connection itself.
        udp_host: as the client wrote it; "" for its own address.
    """

    components: tuple[str, ...]
    divisor: int = 1
    period: float = 0.0
    udp_port: int | None = None
    udp_host: str = ""


def parse_stream(words: Sequence[str]) -> Stream | None:
    """The arguments of StreamFrames; None where they mean nothing.

    Args:
        words: in small letters: a rate, then "udp:PORT" or "udp:HOST:PORT", then components.
    """
    if not words:
        return None
    rate, *rest = words
    name, _, number = rate.partition(":")
    divisor, period = 1, 0.0
    count = _whole(number, 1_000_000)
    if name == "frequency" and count:
        period = 1.0 / count
    elif name == "frequencydivisor" and count:
        divisor = count
    elif rate != "allframes":
        return None
    port, host = None, ""
    if rest and rest[0].startswith("udp:"):
        _, *address = rest.pop(0).split(":")
        port = _whole(address[-1], 65535)
        host = ":".join(address[:-1])
        if not port:
            return None
    components = parse_components(rest)
    return Stream(components, divisor, period, port, host) if components else None


def parse_components(words: Sequence[str]) -> tuple[str, ...]:
    """Names in KINDS, each once; none where one of them is not spoken here."""
    return tuple(dict.fromkeys(words)) if all(word in KINDS for word in words) else ()


def parse_version(word: str) -> int | None:
    """The minor version of "1.19"; None where it is not spoken here."""
    major, _, minor = word.partition(".")
    number = _whole(minor, VERSIONS[-1])
    return number if major == "1" and number in VERSIONS else None


def _whole(text: str, most: int) -> int | None:
    """A whole number from 1 to `most` in plain digits."""
    if not (text.isascii() and text.isdigit() and len(text) <= 7):
        return None
    number = int(text)
    return number if 1 <= number <= most else None
