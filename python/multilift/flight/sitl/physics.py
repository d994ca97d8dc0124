"""The joint model under all firmwares, as they see it: north-east-down and forward-right-down."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from multilift.errors import ScenarioError
from multilift.flight.link import frames
from multilift.flight.sitl.autopilot import Motors, Quaternion, SitlError, Vector
from multilift.models.spatial.world import AUTOPILOT_MOTORS, SpatialWorld
from multilift.scenario import Scenario

#: The longest that motors are held, s: firmwares do not count on longer steps.
LONGEST_PERIOD = 0.02


class Motion(NamedTuple):
    """How one vehicle moves at an instant, and on average since the one before.

    Attributes:
        position: NED, m.
        velocity: NED, m/s.
        quaternion: of FRD in NED, scalar first.
        rate: FRD, rad/s.
        mean_rate: angular rate since the last instant, FRD, rad/s.
        mean_force: acceleration less gravity since the last instant, FRD, m/s^2, with the impulses
            of cables that were pulled taut.
    """

    position: Vector
    velocity: Vector
    quaternion: Quaternion
    rate: Vector
    mean_rate: Vector
    mean_force: Vector


class Physics:
    """A scenario's world, driven by motor commands in the firmwares' order.

    Attributes:
        world: the model itself.
        motions: of each vehicle, at the present.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Puts the world at its start.

        Raises:
            ScenarioError: for a scenario in which firmware cannot start: not spatial, without
                rotors or ground, or in the air already.
        """
        check(scenario)
        self.world = SpatialWorld(scenario)
        self._gravity = float(scenario["plant.gravity"])
        self.motions = self._look(None, 0.0)

    @property
    def count(self) -> int:
        """Number of vehicles."""
        return self.world.count

    @property
    def time(self) -> float:
        """Since the start, s."""
        return self.world.t

    def advance(self, motors: Sequence[Motors], period: float) -> None:
        """Holds motor commands for a period, to the nearest integration step and at least one.

        Args:
            motors: of each vehicle, in the firmwares' order.
            period: s; at most `LONGEST_PERIOD` of it are taken.

        Raises:
            SitlError: when the world has ended by a collision or divergence.
        """
        steps = max(round(min(period, LONGEST_PERIOD) / self.world.period), 1)
        before, begun = self.motions, self.time
        self.world.step_motors(np.array(motors)[:, AUTOPILOT_MOTORS], steps=steps)
        if self.world.status != "running":
            raise SitlError(
                f"the world ended by {self.world.status} at t = {self.time:.3f} s\n"
                "  what to do: look at the flight before it; [safety] in the scenario says what "
                "counts as a collision"
            )
        self.motions = self._look(before, self.time - begun)

    def _look(self, before: Sequence[Motion] | None, elapsed: float) -> list[Motion]:
        w = self.world
        motions = []
        states = zip(
            w.vehicle.tolist(), w.vehicle_velocity.tolist(), w.vehicle_attitude.tolist(),
            w.vehicle_rate.tolist(), strict=True,
        )  # fmt: skip
        for i, (place, speed, turned, turning) in enumerate(states):
            position, velocity = frames.world(place), frames.world(speed)
            quaternion, rate = frames.attitude(turned), frames.body(turning)
            last = before[i] if before else Motion(
                position, velocity, quaternion, rate, rate, (0.0, 0.0, 0.0)
            )  # fmt: skip
            force = _mean_force(last, velocity, quaternion, elapsed, self._gravity)
            mean_rate = _mean(last.rate, rate)
            motions.append(Motion(position, velocity, quaternion, rate, mean_rate, force))
        return motions


def check(scenario: Scenario) -> None:
    """Refuses scenarios in which firmware cannot start; see `Physics`."""

    def fail(key: str, problem: str, permitted: str) -> ScenarioError:
        return ScenarioError(
            problem,
            where=scenario.where,
            key=key,
            value=scenario[key],
            permitted=permitted,
            advice="start from bar_from_floor: multilift scenarios --show bar_from_floor",
        )

    if scenario["plant.model"] != "spatial":
        raise fail("plant.model", "is not flown by firmware", "spatial")
    if scenario["vehicle.kind"] != "quadrotor":
        raise fail("vehicle.kind", "has no motors to command", "quadrotor")
    if not scenario["ground.present"]:
        raise fail("ground.present", "leaves nothing to stand on while firmware starts", "true")
    if scenario["start.rotors"] != "stopped":
        raise fail("start.rotors", "is not how firmware starts", "stopped")


def _mean_force(
    last: Motion, velocity: Vector, quaternion: Quaternion, elapsed: float, gravity: float
) -> Vector:
    if elapsed > 0.0:
        a = [(v - u) / elapsed for u, v in zip(last.velocity, velocity, strict=True)]
    else:
        a = [0.0, 0.0, 0.0]
    return to_body(_middle(last.quaternion, quaternion), (a[0], a[1], a[2] - gravity))


def _mean(a: Vector, b: Vector) -> Vector:
    return (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]))


def _middle(p: Quaternion, q: Quaternion) -> Quaternion:
    """Halfway between two attitudes that are less than half a turn apart."""
    sign = math.copysign(1.0, sum(a * b for a, b in zip(p, q, strict=True)))
    w, x, y, z = (a + sign * b for a, b in zip(p, q, strict=True))
    size = math.sqrt(w * w + x * x + y * y + z * z)
    return (w / size, x / size, y / size, z / size)


def to_body(q: Quaternion, v: Vector) -> Vector:
    """A vector of the world as seen from a body at attitude q."""
    w, x, y, z = q
    a, b, c = v
    # v - 2 w (u x v) + 2 u x (u x v), with u the vector part.
    d, e, f = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a - w * d + y * f - z * e,
        b - w * e + z * d - x * f,
        c - w * f + x * e - y * d,
    )
