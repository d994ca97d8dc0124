"""What a law of one's own is told of the spatial plant, and how the core calls it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift.controllers import PythonLaw
from multilift.models.spatial.scenario import SpatialScenario

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measurement:
    """What a law is told at a control instant: world axes x east, y north, z up; SI, radians.

    Attributes:
        t: time, s.
        vehicle: positions, shape (n, 3), m.
        vehicle_velocity: shape (n, 3), m/s.
        payload: position of its centre of mass, shape (3,), m.
        payload_attitude: to the world, unit quaternion, scalar first, shape (4,).
        payload_velocity: shape (3,), m/s.
        payload_rate: angular rate in the payload's frame, shape (3,), rad/s.
        vehicle_target: where the vehicles shall be, shape (n, 3), m.
        vehicle_target_velocity: shape (n, 3), m/s.
        payload_target: shape (3,), m.
        payload_target_velocity: shape (3,), m/s.
        payload_target_acceleration: shape (3,), m/s^2.
        yaw_target: heading of the payload, rad.
        yaw_target_rate: rad/s.
        holding: force on each vehicle that holds the formation at rest, shape (n, 3), N.
        saturated: whether each vehicle's last command hit a limit.
    """

    t: float
    vehicle: Array
    vehicle_velocity: Array
    payload: Array
    payload_attitude: Array
    payload_velocity: Array
    payload_rate: Array
    vehicle_target: Array
    vehicle_target_velocity: Array
    payload_target: Array
    payload_target_velocity: Array
    payload_target_acceleration: Array
    yaw_target: float
    yaw_target_rate: float
    holding: Array
    saturated: tuple[bool, ...]


Law = Callable[[Measurement], Sequence[Sequence[float]]]


def callback(law: PythonLaw, scenario: SpatialScenario) -> Callable[..., list[list[float]]]:
    """A fresh law behind the signature that the core calls.

    Raises:
        ControllerError: if the law cannot be constructed; and, from the callback, if it raises or
            answers anything but n finite forces, with the time.
    """
    n = scenario.count
    answer = law.begin(scenario, 3 * n, f"a finite force (x, y, z) in N for each of {n} vehicles")
    assumed = scenario["controller.assumed"]
    weight = np.zeros((n, 3))
    weight[:, 2] = np.array(assumed["vehicle_mass"]) * assumed["gravity"]
    force = scenario.rest.cable_force[0]

    def step(
        t: float,
        vehicle: Array,
        velocity: Array,
        body: Sequence[float],
        target: Array,
        target_velocity: Array,
        payload_target: Sequence[float],
        saturated: Sequence[bool],
    ) -> list[list[float]]:
        now, goal = np.array(body), np.array(payload_target)
        c, s = np.cos(goal[9]), np.sin(goal[9])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        measured = Measurement(
            t, vehicle, velocity, now[:3], now[3:7], now[7:10], now[10:], target, target_velocity,
            goal[:3], goal[3:6], goal[6:9], float(goal[9]), float(goal[10]),
            weight + force @ turn.T, tuple(map(bool, saturated)),
        )  # fmt: skip
        flat = answer(t, measured)
        return [flat[3 * i : 3 * i + 3] for i in range(n)]

    return step
