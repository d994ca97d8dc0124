"""Frames from Qualisys by the maker's client, `qtm-rt`."""

from __future__ import annotations

import asyncio
import itertools
import math
import time
from collections.abc import AsyncIterator, Sequence
from typing import Any
from xml.etree import ElementTree

from multilift.errors import MissingExtraError
from multilift.fields import did_you_mean
from multilift.flight.mocap import rotations
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Frame, Pose
from multilift.flight.mocap.settings import Settings

#: Frames that wait here at most; the oldest go first.
_MOST_WAITING = 8

#: How far the columns of a rotation matrix may be from unit length and right angles.
_MATRIX_TOLERANCE = 1e-3


async def frames(settings: Settings) -> AsyncIterator[Frame]:
    """All frames from now on, the newest where the reader is slow.

    Raises:
        CaptureError: no server, no such body, or the server went away.
        MissingExtraError: qtm-rt is not installed.
    """
    try:
        import qtm_rt  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("qtm-rt", "fly", "motion capture from Qualisys") from None
    where = f"Qualisys at {settings.host}:{settings.port}"
    arrived: asyncio.Queue[Frame | None] = asyncio.Queue(_MOST_WAITING)

    def put(frame: Frame | None) -> None:
        if arrived.full():
            arrived.get_nowait()
        arrived.put_nowait(frame)

    connection = await qtm_rt.connect(
        settings.host, settings.port, on_disconnect=lambda _: put(None)
    )
    if connection is None:
        raise CaptureError(
            f"{where}: no answer, or not in this version of the protocol\n"
            "  what to do: check host, port (little-endian: base port + 1) and that QTM runs"
        )
    try:
        xml = await connection.get_parameters(["6d"])
        places = body_places(xml, settings, where)
        await connection.stream_frames(
            components=["6dres"],
            on_packet=lambda packet: put(frame_of(packet, places, settings, time.monotonic())),
        )
        while (frame := await arrived.get()) is not None:
            yield frame
        raise CaptureError(f"{where}: the server closed the connection")
    except (TimeoutError, qtm_rt.QRTCommandException) as error:
        raise CaptureError(f"{where}: {error or 'no frames come'}") from None
    finally:
        if connection.has_transport():
            connection.disconnect()


def body_places(xml: bytes | str, settings: Settings, where: str) -> dict[str, int]:
    """At which place in a frame each of our bodies stands.

    Raises:
        CaptureError: the server has no such body, or says no XML.
    """
    try:
        tree = ElementTree.fromstring(xml)
    except ElementTree.ParseError as error:
        raise CaptureError(f"{where}: parameters that are no XML: {error}") from None
    theirs = [(name.text or "").strip() for name in tree.findall("./The_6D/Body/Name")]
    places = {}
    for ours, wanted in settings.bodies.items():
        if wanted not in theirs:
            raise CaptureError(
                f"{where}: no body {wanted!r} for {ours}\n"
                f"  permitted: {', '.join(theirs) or 'none: no body is defined there'}\n"
                f"  what to do: {did_you_mean(wanted, theirs) or 'define it in QTM'}"
            )
        places[ours] = theirs.index(wanted)
    return places


def frame_of(packet: Any, places: dict[str, int], settings: Settings, received: float) -> Frame:
    """A packet of the client as a frame of ours.

    Args:
        packet: a ``QRTPacket`` with 6DRes.
        places: at which place in it each of our bodies stands.
        settings: its axes.
        received: when it came, s.
    """
    found = packet.get_6d_residual()
    bodies = {}
    rows: Sequence[Any] = found[1] if found else ()
    for name, place in places.items():
        pose = _pose(*rows[place]) if place < len(rows) else None
        if pose is not None:
            bodies[name] = settings.axes.ours(name, pose)
    return Frame(packet.framenumber, packet.timestamp * 1e-6, received, bodies)


def _pose(position: Any, rotation: Any, residual: Any) -> Pose | None:
    """A body in metres; None where it was not seen or its matrix does not turn."""
    m = rotation.matrix
    if len(m) == 1:
        m = m[0]  # as qtm-rt wraps it
    if not all(map(math.isfinite, (*position, *m))):
        return None
    columns = (m[0:3], m[3:6], m[6:9])
    for j, k in itertools.product(range(3), repeat=2):
        dot = sum(a * b for a, b in zip(columns[j], columns[k], strict=True))
        if abs(dot - (j == k)) > _MATRIX_TOLERANCE:
            return None
    (a, b, c), (d, e, f), (g, h, i) = columns
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0:
        return None
    attitude = rotations.from_matrix(tuple(zip(*columns, strict=True)))
    return Pose(
        (position.x * 1e-3, position.y * 1e-3, position.z * 1e-3),
        attitude,
        residual.residual * 1e-3,
    )
