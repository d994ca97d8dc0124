"""Frames as bytes, from the process that reads the capture system to the one that flies."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from multilift.flight.mocap.frames import Frame, Pose

_START = struct.Struct("<qddI")
_POSE = struct.Struct("<I8d")

#: Stands for "none" among frame numbers, which count from 0 or 1.
_NO_NUMBER = -1

#: Greatest message, bytes: thousands of bodies, or a long complaint.
LARGEST = 1 << 18


def frame_to_bytes(frame: Frame, names: Sequence[str]) -> bytes:
    """A frame; bodies by their place in `names`."""
    time = math.nan if frame.capture_time is None else frame.capture_time
    number = _NO_NUMBER if frame.number is None else frame.number
    parts = [_START.pack(number, time, frame.received_time, len(frame.bodies))]
    for name, pose in frame.bodies.items():
        parts.append(_POSE.pack(names.index(name), *pose.position, *pose.attitude, pose.residual))
    return b"".join(parts)


def frame_from_bytes(data: bytes, names: Sequence[str]) -> Frame:
    """What `frame_to_bytes` wrote.

    Raises:
        ValueError: it did not.
    """
    try:
        number, time, received, count = _START.unpack_from(data)
        if len(data) != _START.size + count * _POSE.size:
            raise ValueError("a frame that is not whole")
        bodies = {}
        for k in range(count):
            place, *v = _POSE.unpack_from(data, _START.size + k * _POSE.size)
            bodies[names[place]] = Pose((v[0], v[1], v[2]), (v[3], v[4], v[5], v[6]), v[7])
    except (struct.error, IndexError):
        raise ValueError("a frame that is not whole") from None
    return Frame(
        None if number == _NO_NUMBER else number,
        None if math.isnan(time) else time,
        received,
        bodies,
    )
