"""What the estimator is told: bodies, cables, and how bodies move and are measured."""

from __future__ import annotations

from dataclasses import dataclass

from multilift.flight.mocap.frames import Vector


@dataclass(frozen=True, slots=True)
class Cable:
    """Which two points a cable ties together.

    Attributes:
        vehicle: name of the body at its upper end.
        payload: name of the body at its lower end.
        vehicle_point: where it is tied, vehicle axes, m.
        payload_point: where it is tied, payload axes, m.
    """

    vehicle: str
    payload: str
    vehicle_point: Vector = (0.0, 0.0, 0.0)
    payload_point: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Tuning:
    """How bodies move and are measured, and what counts as a fault.

    Attributes:
        position_noise: standard deviation of a captured position, each component, m.
        attitude_noise: the same of a captured attitude, rad.
        jerk: strength of the white jerk that drives the model of motion, m/s^3/sqrt(Hz).
        angular_jerk: the same of the model of turning, rad/s^3/sqrt(Hz).
        gate: a pose farther than this many standard deviations from its prediction is rejected.
        slack: allowed on top of the gate, m, for what a model of constant acceleration misses.
        angle_slack: the same for attitudes, rad.
        rebirth: poses, or clocks, that were rejected for this long but agree with one another
            are right, s.
        settle: time from the start until velocities are sound, s.
        coast: how long after the last accepted pose extrapolation is sound, s.
        lost: after which age values are no longer to be used, s.
        latency: from capture to arrival at its least, s; it cannot be measured here.
        clock_slack: arrival may be this much later than at best before the frame is left out, s.
    """

    position_noise: float = 5e-4
    attitude_noise: float = 5e-3
    jerk: float = 6.0
    angular_jerk: float = 60.0
    gate: float = 6.0
    slack: float = 0.01
    angle_slack: float = 0.05
    rebirth: float = 0.3
    settle: float = 0.2
    coast: float = 0.05
    lost: float = 0.15
    latency: float = 0.004
    clock_slack: float = 0.05
