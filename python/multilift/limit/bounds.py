"""What a move may not exceed, besides what its scenario says."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from multilift.errors import ScenarioError
from multilift.run import finite


@dataclass(frozen=True)
class Limits:
    """Limits of a move that no key of a scenario holds.

    Attributes:
        force: greatest control force of a vehicle along each axis, beyond what holds it at rest,
            N: (y, z) in the plane, (x, y, z) in space; infinite where only the scenario's limits of
            thrust and tilt hold; None: the greatest that the scenario's own law commands.
        speed: of each vehicle, m/s.
        swing: of each angle of the load, rad.
        tension: of each cable, at least, N.
    """

    force: tuple[float, ...] | None = None
    speed: float = math.inf
    swing: float = math.radians(89.0)
    tension: float = 0.0

    def check(self, where: str, axes: int) -> None:
        """Refuses limits that cannot be meant.

        Args:
            where: the scenario, for the error.
            axes: how many numbers the force has.

        Raises:
            ScenarioError: naming the option.
        """
        force = self.force
        if force is not None and (len(force) != axes or not all(f > 0 for f in force)):
            raise ScenarioError(
                "is no limit of force", where=where, key="--forces", value=list(force),
                permitted=f"{axes} positive numbers, N",
            )  # fmt: skip
        if not self.speed > 0:
            raise ScenarioError(
                "is no limit of speed", where=where, key="--speed", value=self.speed,
                permitted="a positive number, m/s",
            )  # fmt: skip
        if not 0 < self.swing < math.pi / 2:
            raise ScenarioError(
                "is no limit of swing", where=where, key="--swing",
                value=round(math.degrees(self.swing), 6), permitted="above 0 and below 90 deg",
            )  # fmt: skip
        if not 0 <= self.tension < math.inf:
            raise ScenarioError(
                "is no least tension", where=where, key="--tension", value=self.tension,
                permitted="a number of at least 0, N",
            )  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """As values for JSON; what is not limited is None."""
        kept = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self).items()}
        return {
            k: [finite(x) for x in v] if isinstance(v, list) else v if v is None else finite(v)
            for k, v in kept.items()
        }
