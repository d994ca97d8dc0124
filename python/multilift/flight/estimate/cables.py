"""A cable's direction, swing and their rates, from the bodies at its ends."""

from __future__ import annotations

import math

from multilift.flight.estimate.config import Cable
from multilift.flight.estimate.state import BodyState, CableState, Standing
from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Vector

#: Ends nearer than this have no direction; it is then said to be up, at rest.
_NEAREST = 1e-2


def cable_state(cable: Cable, vehicle: BodyState, payload: BodyState) -> CableState:
    """The cable between two bodies, at their time."""
    top, top_velocity = _point(vehicle, cable.vehicle_point)
    low, low_velocity = _point(payload, cable.payload_point)
    standing = worst(vehicle.standing, payload.standing)
    distance = math.dist(top, low)
    if distance < _NEAREST:
        up, still = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
        return CableState(standing, up, still, 0.0, 0.0, 0.0, distance)
    x, y, z = ((t - b) / distance for t, b in zip(top, low, strict=True))
    u, v, w = ((t - b) / distance for t, b in zip(top_velocity, low_velocity, strict=True))
    stretch = x * u + y * v + z * w
    return CableState(
        standing,
        (x, y, z),
        (u - stretch * x, v - stretch * y, w - stretch * z),
        math.atan2(math.hypot(x, y), z),
        math.atan2(x, z),
        math.atan2(y, z),
        distance,
    )


def worst(*standings: Standing) -> Standing:
    """The one of least quality, of those the oldest."""
    return min(standings, key=lambda s: (s.quality, -s.age))


def _point(body: BodyState, point: Vector) -> tuple[Vector, Vector]:
    """Where a point of a body is and how fast it moves, world axes."""
    (a, b, c), (x, y, z) = body.rate, point
    lever = rotations.turned(body.attitude, point)
    spin = rotations.turned(body.attitude, (b * z - c * y, c * x - a * z, a * y - b * x))
    p, v = body.position, body.velocity
    return (
        (p[0] + lever[0], p[1] + lever[1], p[2] + lever[2]),
        (v[0] + spin[0], v[1] + spin[1], v[2] + spin[2]),
    )
