"""One plant flown by as many twin autopilots as it has vehicles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilift.flight.link.frames import Quaternion, Vector
from multilift.flight.twin.autopilot import Body, Drive, TwinAutopilot
from multilift.models.spatial import SpatialWorld

#: Between two looks of the autopilots, s: PX4's at 250 Hz.
PERIOD = 0.004

#: What drives a vehicle whose autopilot is dead.
NOTHING = Drive((1.0, 0.0, 0.0, 0.0), 0.0)


class Motions:
    """A plant, driven by what autopilots answer.

    Its time begins when the first vehicle is armed: before that all stands still, and what the
    scenario has happen at its times would come while people still read check-lists.

    Attributes:
        world: the plant.
        period: between two drives, s.
    """

    def __init__(self, world: SpatialWorld, period: float) -> None:
        """Of a world of quadrotors; the period to a whole number of its steps."""
        self.world = world
        self._steps = max(round(period / world.period), 1)
        self.period = self._steps * world.period
        self._began = False

    def body(self, k: int) -> Body:
        """Vehicle k as the plant has it."""
        world = self.world
        return Body(
            _vector(world.vehicle[k]),
            _vector(world.vehicle_velocity[k]),
            _quaternion(world.vehicle_attitude[k]),
            bool(world.standing[k]),
        )

    def step(self, drives: Sequence[Drive], armed: bool) -> None:
        """Moves on by a period; a world that has ended stays.

        Args:
            drives: of each vehicle.
            armed: whether any is.
        """
        self._began = self._began or armed
        if not self._began or self.world.status != "running":
            return
        attitudes = np.array([d.attitude for d in drives])
        attitudes /= np.linalg.norm(attitudes, axis=1)[:, None]
        self.world.step_set_points(attitudes, [d.thrust for d in drives], steps=self._steps)


class Rig:
    """The plant and its autopilots, in step.

    Attributes:
        motions: the plant, driven.
        world: the plant.
        autopilots: one a vehicle.
        start: the autopilots' clock at the beginning, s.
    """

    def __init__(
        self,
        world: SpatialWorld,
        autopilots: Sequence[TwinAutopilot],
        start: float = 0.0,
        period: float = PERIOD,
    ) -> None:
        """Puts autopilots, one a vehicle, on the vehicles of a world of quadrotors."""
        assert len(autopilots) == world.count
        self.world, self.autopilots, self.start = world, tuple(autopilots), start
        self.motions = Motions(world, period)
        self._count = 0

    @property
    def now(self) -> float:
        """The autopilots' clock, s."""
        return self.start + self._count * self.motions.period

    def body(self, k: int) -> Body:
        """Vehicle k as the plant has it."""
        return self.motions.body(k)

    def step(self, lives: Sequence[bool] | None = None) -> None:
        """Lets every autopilot hear, speak and steer once, and the plant move on.

        Args:
            lives: whose autopilot does; the motors of others stand still. Left out: all.
        """
        now = self.now
        self._count += 1
        drives = [
            pilot.step(self.body(k), now) if lives is None or lives[k] else NOTHING
            for k, pilot in enumerate(self.autopilots)
        ]
        self.motions.step(drives, any(pilot.armed for pilot in self.autopilots))


def _vector(row: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Vector:
    x, y, z = row.tolist()
    return x, y, z


def _quaternion(row: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Quaternion:
    w, x, y, z = row.tolist()
    return w, x, y, z
