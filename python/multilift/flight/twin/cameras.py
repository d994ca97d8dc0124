"""Motion capture of a plant: its noise and delay, and what can be wrong with it."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from random import Random

from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Pose, Quaternion, Vector
from multilift.flight.mocap.rt_protocol import Capture
from multilift.models.spatial import SpatialWorld
from multilift.models.spatial.scenario import SpatialScenario

#: What systems capture where the scenario's is ideal, s.
_PERIOD = 0.01


@dataclass(frozen=True)
class CaptureFault:
    """Something wrong with motion capture.

    Attributes:
        kind: "silent": no frames; "frozen": the same poses again; "jump": a body is seen
            elsewhere; "swap": two bodies under each other's names; "drop": a body is not seen;
            "noise": `size` times the noise; "clock": capture times jump by `size` seconds.
        start, end: when, by the cameras' clock, s.
        body: which, by its place; the next one, too, where two are swapped.
        size: of noise as a factor, of jumps in m or s.
    """

    kind: str
    start: float
    end: float
    body: int = 0
    size: float = 1.0


class Cameras:
    """Captures vehicles and payload, in this order, at the scenario's rate, late as it says.

    Attributes:
        period: between two captures, s.
        faults: what goes wrong.
    """

    def __init__(
        self, flown: SpatialScenario, seed: int, faults: tuple[CaptureFault, ...] = ()
    ) -> None:
        """Of a scenario's ``[motion_capture]``, with its noise drawn from a seed."""
        table = flown.values["motion_capture"]
        self.period = float(table["period"]) or _PERIOD
        self.faults = faults
        self._delay = float(table["delay"])
        self._noise = float(table["position_noise"]), float(table["attitude_noise"])
        self._dice = Random(seed)
        self._waiting: deque[tuple[float, Capture]] = deque()
        self._number = 0
        self._last: list[Pose | None] = []

    def look(self, world: SpatialWorld, now: float) -> None:
        """Captures what is there; called once a period.

        Args:
            world: the plant.
            now: the cameras' clock, s.
        """
        wrong = {f.kind: f for f in self.faults if f.start <= now < f.end}
        self._number += 1
        factor = wrong["noise"].size if "noise" in wrong else 1.0
        poses: list[Pose | None] = [
            self._pose(_vector(world.vehicle[k]), _quaternion(world.vehicle_attitude[k]), factor)
            for k in range(world.count)
        ]
        load = _vector(world.payload), _quaternion(world.payload_attitude)
        poses.append(self._pose(*load, factor))
        time = now + (wrong["clock"].size if "clock" in wrong else 0.0)
        if "frozen" in wrong:
            poses = self._last
        self._last = list(poses)
        if "jump" in wrong:
            jump = wrong["jump"]
            seen = poses[jump.body]
            if seen is not None:
                x, y, z = seen.position
                poses[jump.body] = Pose((x + jump.size, y, z), seen.attitude, seen.residual)
        if "drop" in wrong:
            poses[wrong["drop"].body] = None
        if "swap" in wrong:
            a, b = wrong["swap"].body, (wrong["swap"].body + 1) % len(poses)
            poses[a], poses[b] = poses[b], poses[a]
        if "silent" not in wrong:
            self._waiting.append((now + self._delay, Capture(self._number, time, tuple(poses))))

    def due(self, now: float) -> list[Capture]:
        """What has been worked out by now, oldest first."""
        found = []
        # Half a nanosecond: times of periods that are added up are not exact.
        while self._waiting and self._waiting[0][0] <= now + 5e-10:
            found.append(self._waiting.popleft()[1])
        return found

    def _pose(self, position: Vector, attitude: Quaternion, factor: float) -> Pose:
        place, turn = self._noise
        x, y, z = position
        seen = (x + self._error(factor * place), y + self._error(factor * place),
                z + self._error(factor * place))  # fmt: skip
        error = rotations.from_vector((
            self._error(factor * turn), self._error(factor * turn), self._error(factor * turn)
        ))  # fmt: skip
        turned = rotations.product(attitude, error)
        size = math.hypot(*turned)
        w, a, b, c = (q / size for q in turned)
        return Pose(seen, (w, a, b, c), place)

    def _error(self, sigma: float) -> float:
        return self._dice.gauss(0.0, sigma) if sigma else 0.0


def _vector(row: object) -> Vector:
    x, y, z = row.tolist()  # type: ignore[attr-defined]
    return x, y, z


def _quaternion(row: object) -> Quaternion:
    w, x, y, z = row.tolist()  # type: ignore[attr-defined]
    return w, x, y, z
