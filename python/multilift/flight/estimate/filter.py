"""A Kalman filter of one body's pose: constant acceleration, constant angular acceleration.

Attitude errors are rotation vectors in body axes, after each measurement folded into the
quaternion.
"""

from __future__ import annotations

import math

from multilift.flight.estimate.chain import Chain
from multilift.flight.estimate.config import Tuning
from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Pose, Quaternion, Vector

#: What a body may be doing when it is first seen, as standard deviations.
_SPEED, _ACCELERATION = 2.0, 5.0
_RATE, _ANGULAR_ACCELERATION = 3.0, 30.0

_ZERO: Vector = (0.0, 0.0, 0.0)


class PoseFilter:
    """Position, velocity, acceleration, attitude, angular rate of a body.

    Attributes:
        born: time of the first pose, the source's clock, s.
        time: of the last pose, s.
        count: of poses taken in.
    """

    def __init__(self, tuning: Tuning, time: float, pose: Pose) -> None:
        self._tuning = tuning
        self.born = self.time = time
        self.count = 1
        self._position = pose.position
        self._velocity = self._acceleration = _ZERO
        self._attitude = rotations.unit(pose.attitude)
        self._rate = self._angular_acceleration = _ZERO
        self._straight = Chain.unknown(tuning.position_noise, _SPEED, _ACCELERATION)
        self._turning = Chain.unknown(tuning.attitude_noise, _RATE, _ANGULAR_ACCELERATION)

    def shift(self, by: float) -> None:
        """The source's clock was found to have jumped."""
        self.born += by
        self.time += by

    def motion(self, dt: float) -> tuple[Vector, Vector, Vector]:
        """Position, velocity and acceleration dt after the last pose."""
        p, v, a = self._position, self._velocity, self._acceleration
        half = 0.5 * dt * dt
        position = (
            p[0] + dt * v[0] + half * a[0],
            p[1] + dt * v[1] + half * a[1],
            p[2] + dt * v[2] + half * a[2],
        )
        return position, _along(v, a, dt), a

    def turning(self, dt: float) -> tuple[Quaternion, Vector]:
        """Attitude and angular rate dt after the last pose."""
        w, a = self._rate, self._angular_acceleration
        half = 0.5 * dt * dt
        turn = (dt * w[0] + half * a[0], dt * w[1] + half * a[1], dt * w[2] + half * a[2])
        attitude = rotations.product(self._attitude, rotations.from_vector(turn))
        return attitude, _along(w, a, dt)

    def sigmas(self, dt: float) -> tuple[float, float]:
        """Standard deviations of position and velocity, each component."""
        chain = self._straight.after(dt, self._tuning.jerk)
        return math.sqrt(chain.vv), math.sqrt(chain.rr)

    def fits(self, time: float, pose: Pose) -> bool:
        """Whether the body can have reached this pose."""
        tuning = self._tuning
        dt = time - self.time
        if not 0 <= dt <= tuning.lost:
            return False
        straight = self._straight.after(dt, tuning.jerk)
        reach = tuning.gate * straight.spread(tuning.position_noise) + tuning.slack
        if math.dist(pose.position, self.motion(dt)[0]) > reach:
            return False
        turning = self._turning.after(dt, tuning.angular_jerk)
        reach = tuning.gate * turning.spread(tuning.attitude_noise) + tuning.angle_slack
        return math.hypot(*_error(self.turning(dt)[0], pose.attitude)) <= reach

    def take(self, time: float, pose: Pose) -> None:
        """Take a pose in; it must not be older than the last."""
        tuning = self._tuning
        dt = time - self.time
        position, velocity, acceleration = self.motion(dt)
        chain = self._straight.after(dt, tuning.jerk)
        error = _minus(pose.position, position)
        k = chain.gains(tuning.position_noise)
        self._position = _along(position, error, k[0])
        self._velocity = _along(velocity, error, k[1])
        self._acceleration = _along(acceleration, error, k[2])
        self._straight = chain.measured(tuning.position_noise)

        attitude, rate = self.turning(dt)
        chain = self._turning.after(dt, tuning.angular_jerk)
        error = _error(attitude, pose.attitude)
        k = chain.gains(tuning.attitude_noise)
        step = rotations.from_vector((k[0] * error[0], k[0] * error[1], k[0] * error[2]))
        self._attitude = rotations.unit(rotations.product(attitude, step))
        self._rate = _along(rate, error, k[1])
        self._angular_acceleration = _along(self._angular_acceleration, error, k[2])
        self._turning = chain.measured(tuning.attitude_noise)
        self.time = time
        self.count += 1


def _error(predicted: Quaternion, measured: Quaternion) -> Vector:
    """What turns the predicted attitude into the measured one, body axes, rad."""
    turn = rotations.product(rotations.inverse(predicted), rotations.unit(measured))
    return rotations.to_vector(turn)


def _along(a: Vector, b: Vector, k: float) -> Vector:
    return (a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2])


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
