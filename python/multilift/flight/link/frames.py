"""World ENU and body FLU here, NED and FRD on the wire: the only place where they meet.

Vectors: world x east, y north, z up against x north, y east, z down; body x forward, y left, z up
against x forward, y right, z down. Quaternions are of unit length, scalar first, and turn a body's
coordinates into the world's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

#: Half turn about the diagonal of x and y, which takes ENU to NED and back; scalar first.
_HALF = math.sqrt(0.5)


def world(v: Sequence[float]) -> Vector:
    """ENU to NED, or NED to ENU: the same exchange."""
    return (v[1], v[0], -v[2])


def body(v: Sequence[float]) -> Vector:
    """FLU to FRD, or FRD to FLU."""
    return (v[0], -v[1], -v[2])


def attitude(q: Sequence[float]) -> Quaternion:
    """Body FLU in ENU to body FRD in NED, or back, with a scalar part that is not negative.

    The product of the half turns: (0, 1, 1, 0) / sqrt 2 before, about the body's x behind.
    """
    w, x, y, z = q
    r = (_HALF * (w + z), _HALF * (x + y), _HALF * (x - y), _HALF * (w - z))
    return r if r[0] >= 0.0 else (-r[0], -r[1], -r[2], -r[3])


def euler(q: Sequence[float]) -> Vector:
    """Roll, pitch, yaw of a quaternion, as MAVLink means them: yaw, then pitch, then roll; rad."""
    w, x, y, z = q
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw
