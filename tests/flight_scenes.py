"""Two vehicles and a bar in motion, seen by a capture system, for the tests of the estimator."""

import math
import random

from multilift.flight.estimate.config import Cable
from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Frame, Pose

BODIES = ("vehicle_1", "vehicle_2", "payload")
CABLES = (
    Cable("vehicle_1", "payload", payload_point=(-0.5, 0.0, 0.0)),
    Cable("vehicle_2", "payload", payload_point=(0.5, 0.0, 0.0)),
)
RATE = 100.0
#: Of the capture clock when ours is zero, s.
BEGAN = 1000.0
LATENCY = 0.004


def truth(name, t):
    """Position and its derivative, attitude and angular rate in body axes, of a gentle flight."""
    k = BODIES.index(name)
    low = name == "payload"
    w, reach = 1.3 + 0.2 * k, 0.05 if low else 0.3
    center = (0.0, 0.0, 0.5) if low else ((-0.7, 0.7)[k], 0.0, 1.5)
    position = (
        center[0] + reach * math.sin(w * t),
        center[1] + reach * math.cos(w * t + k),
        center[2] + 0.1 * math.sin(0.7 * t),
    )
    velocity = (
        reach * w * math.cos(w * t),
        -reach * w * math.sin(w * t + k),
        0.07 * math.cos(0.7 * t),
    )
    axis = (math.sin(k), math.cos(k), 0.0)
    angle, rate = 0.15 * math.sin(1.7 * t), 0.15 * 1.7 * math.cos(1.7 * t)
    attitude = rotations.from_vector(tuple(angle * a for a in axis))
    return position, velocity, attitude, tuple(rate * a for a in axis)


class Camera:
    """Makes frames of the scene: noise, then whatever goes wrong."""

    def __init__(self, seed=1, position_noise=3e-4, attitude_noise=3e-3):
        self.rng = random.Random(seed)
        self.position_noise = position_noise
        self.attitude_noise = attitude_noise
        self.number = 0

    def vector(self, sigma):
        return tuple(self.rng.gauss(0.0, sigma) for _ in range(3))

    def pose(self, name, t):
        position, _, attitude, _ = truth(name, t)
        error = rotations.from_vector(self.vector(self.attitude_noise))
        noise = self.vector(self.position_noise)
        seen = tuple(p + n for p, n in zip(position, noise, strict=True))
        return Pose(seen, rotations.product(attitude, error), 1e-4)

    def frame(self, t, latency=LATENCY):
        """The scene at our time t."""
        self.number += 1
        bodies = {name: self.pose(name, t) for name in BODIES}
        return Frame(self.number, BEGAN + t, t + latency, bodies)


def times(seconds, start=0.0):
    return [start + k / RATE for k in range(round(seconds * RATE))]
