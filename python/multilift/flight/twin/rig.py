"""One plant flown by as many twin autopilots as it has vehicles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilift.flight.link.frames import Quaternion, Vector
from multilift.flight.twin.autopilot import Body, TwinAutopilot
from multilift.models.spatial import SpatialWorld

#: Between two looks of the autopilots, s: PX4's at 250 Hz.
PERIOD = 0.004


class Rig:
    """The plant and its autopilots, in step.

    Attributes:
        world: the plant.
        autopilots: one a vehicle.
        start: the autopilots' clock when the plant began, s.
    """

    def __init__(
        self, world: SpatialWorld, autopilots: Sequence[TwinAutopilot], start: float = 0.0
    ) -> None:
        """Puts autopilots, one a vehicle, on the vehicles of a world of quadrotors."""
        assert len(autopilots) == world.count
        self.world, self.autopilots, self.start = world, tuple(autopilots), start
        self._steps = max(round(PERIOD / world.period), 1)

    @property
    def now(self) -> float:
        """The autopilots' clock, s."""
        return self.start + self.world.t

    def body(self, k: int) -> Body:
        """Vehicle k as the plant has it."""
        world = self.world
        return Body(
            _vector(world.vehicle[k]),
            _vector(world.vehicle_velocity[k]),
            _quaternion(world.vehicle_attitude[k]),
            bool(world.standing[k]),
        )

    def step(self) -> None:
        """Lets every autopilot hear, speak and steer once, and the plant move on."""
        now = self.now
        drives = [pilot.step(self.body(k), now) for k, pilot in enumerate(self.autopilots)]
        attitudes = np.array([d.attitude for d in drives])
        attitudes /= np.linalg.norm(attitudes, axis=1)[:, None]
        self.world.step_set_points(attitudes, [d.thrust for d in drives], steps=self._steps)

    def run_to(self, now: float) -> None:
        """Steps until the autopilots' clock is there; a world that has ended stays."""
        while self.now < now - 0.5 * PERIOD and self.world.status == "running":
            self.step()


def _vector(row: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Vector:
    x, y, z = row.tolist()
    return x, y, z


def _quaternion(row: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Quaternion:
    w, x, y, z = row.tolist()
    return w, x, y, z
