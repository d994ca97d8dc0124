"""Quaternions, rotation matrices and Qualisys' angles, on plain floats.

A frame has a handful of bodies; at that size tuples are several times faster than arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from multilift.flight.mocap.frames import Quaternion, Vector


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """First q, then p."""
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def inverse(q: Quaternion) -> Quaternion:
    """Of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def unit(q: Quaternion) -> Quaternion:
    """The quaternion at unit length; it must not be zero."""
    length = math.hypot(*q)
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


def turned(q: Quaternion, v: Vector) -> Vector:
    """A vector of the body in the world."""
    w, x, y, z = q
    a, b, c = v
    s, t, u = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return (
        a + w * s + y * u - z * t,
        b + w * t + z * s - x * u,
        c + w * u + x * t - y * s,
    )


def from_vector(r: Vector) -> Quaternion:
    """The rotation about r by |r|, rad."""
    angle = math.hypot(*r)
    scale = math.sin(angle / 2) / angle if angle > 1e-9 else 0.5
    return unit((math.cos(angle / 2), r[0] * scale, r[1] * scale, r[2] * scale))


def to_vector(q: Quaternion) -> Vector:
    """The rotation vector of a unit quaternion, of length 0 to pi, rad."""
    sine = math.hypot(q[1], q[2], q[3])
    scale = 2.0
    if sine > 1e-9:
        scale = 2 * math.atan2(sine, abs(q[0])) / sine
    if q[0] < 0:
        scale = -scale
    return (q[1] * scale, q[2] * scale, q[3] * scale)


def matrix(q: Quaternion) -> tuple[Vector, Vector, Vector]:
    """The rotation matrix of a unit quaternion, by rows."""
    w, x, y, z = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def from_matrix(rows: Sequence[Sequence[float]]) -> Quaternion:
    """The quaternion of a rotation matrix, by rows; from the greatest of its four squares."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    squares = (a + e + i, a - e - i, e - a - i, i - a - e)
    greatest = max(range(4), key=squares.__getitem__)
    s = 2 * math.sqrt(max(1 + squares[greatest], 1e-12))
    q = (
        (s / 4, (h - f) / s, (c - g) / s, (d - b) / s),
        ((h - f) / s, s / 4, (b + d) / s, (c + g) / s),
        ((c - g) / s, (b + d) / s, s / 4, (f + h) / s),
        ((d - b) / s, (c + g) / s, (f + h) / s, s / 4),
    )[greatest]
    return unit(q)


def to_angles(q: Quaternion) -> Vector:
    """Qualisys' roll, pitch, yaw, rad: R = R_x(roll) R_y(pitch) R_z(yaw)."""
    rows = matrix(q)
    return (
        math.atan2(-rows[1][2], rows[2][2]),
        math.asin(max(-1.0, min(1.0, rows[0][2]))),
        math.atan2(-rows[0][1], rows[0][0]),
    )
