"""What passes between the plant and an autopilot's process: where its body is, how it drives it."""

from __future__ import annotations

import struct

from multilift.flight.twin.autopilot import Body, Drive

#: Time, position, velocity, attitude; whether it stands.
_BODY = struct.Struct("<dq10d?")

#: The count of the body that is answered, attitude, thrust; whether it is armed.
_DRIVE = struct.Struct("<q5d?")


def body_to_bytes(now: float, count: int, body: Body) -> bytes:
    """A body at a time, the count-th that is sent."""
    return _BODY.pack(now, count, *body.position, *body.velocity, *body.attitude, body.standing)


def body_from_bytes(data: bytes) -> tuple[float, int, Body]:
    """What `body_to_bytes` wrote.

    Raises:
        struct.error: it did not.
    """
    now, count, a, b, c, d, e, f, w, x, y, z, standing = _BODY.unpack(data)
    return now, count, Body((a, b, c), (d, e, f), (w, x, y, z), standing)


def drive_to_bytes(count: int, drive: Drive, armed: bool) -> bytes:
    """The answer to a body."""
    return _DRIVE.pack(count, *drive.attitude, drive.thrust, armed)


def drive_from_bytes(data: bytes) -> tuple[int, Drive, bool]:
    """What `drive_to_bytes` wrote.

    Raises:
        struct.error: it did not.
    """
    count, w, x, y, z, thrust, armed = _DRIVE.unpack(data)
    return count, Drive((w, x, y, z), thrust), armed
