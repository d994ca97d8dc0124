"""How hard the cables pull, from the thrust that was asked for and the motion that is seen."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from multilift.flight.estimate.state import BodyState, Estimate
from multilift.models.spatial.scenario import SpatialScenario

#: A cable that is so much shorter between its ends than it is long is slack, m.
_SLACK = 0.02

#: Accelerations are noisy: time constant of what is told, s.
_SMOOTHING = 0.3


class Pulls:
    """Tensions of all cables of a scenario.

    A vehicle of mass m moves by ``m a = f - m g z - T d``, with d from the load to the vehicle:
    hence ``T = d (f - m (a + g z))``.

    Attributes:
        tension: of each cable, N; 0 where it is slack.
        slack: whether each is.
    """

    def __init__(self, masses: Sequence[float], flown: SpatialScenario) -> None:
        """Of vehicles of these masses, kg."""
        plant = flown.values["plant"]
        self._masses = tuple(masses)
        self._gravity = float(plant["gravity"])
        lengths = np.broadcast_to(np.array(plant["cable_length"], dtype=float), len(masses))
        self._lengths = lengths.tolist()
        self.tension = [0.0] * len(masses)
        self.slack = [True] * len(masses)

    def needed(self, k: int, body: BodyState) -> float:
        """Thrust along its own z that vehicle k's motion shows, without a cable, N."""
        _w, x, y, _z = body.attitude
        w, z = _w, _z
        up = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        a, b, c = body.acceleration
        return self._masses[k] * (a * up[0] + b * up[1] + (c + self._gravity) * up[2])

    def sees(self, estimate: Estimate, forces: NDArray[np.float64] | None, elapsed: float) -> None:
        """Takes in a tick.

        Args:
            estimate: now.
            forces: of the rotors as last asked for, shape (n, 3), N; None where nothing was.
            elapsed: since the last, s.
        """
        part = min(max(elapsed, 0.0) / _SMOOTHING, 1.0)
        for k, cable in enumerate(estimate.cables):
            self.slack[k] = not cable.distance > self._lengths[k] - _SLACK
            if self.slack[k] or forces is None:
                self.tension[k] = 0.0
                continue
            a, b, c = estimate.bodies[f"vehicle_{k + 1}"].acceleration
            m, (x, y, z), (f, g, h) = self._masses[k], cable.direction, forces[k].tolist()
            pull = x * (f - m * a) + y * (g - m * b) + z * (h - m * (c + self._gravity))
            if math.isfinite(pull):
                self.tension[k] += part * (pull - self.tension[k])
