"""A scenario of the spatial plant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift import pushes, validation
from multilift.errors import ScenarioError
from multilift.models.spatial import checks, references, rows
from multilift.models.spatial.formation import Rest
from multilift.overrides import Columns
from multilift.scenario import Scenario


class SpatialScenario(Scenario):
    """A checked scenario of n vehicles and a payload in space; see :class:`multilift.Scenario`.

    Attributes:
        rest: how the vehicles stand about the payload at rest, arrays with one world.
        payload_start: position, attitude (w, x, y, z), velocity, rate at the start, shape (13,).
        vehicle_start: positions and velocities at the start, shape (n, 6), m and m/s.
    """

    rest: Rest
    payload_start: NDArray[np.float64]
    vehicle_start: NDArray[np.float64]

    def _check(self) -> None:
        values, where = self.values, self.where
        checks.check_kind(values, where)
        checks.check_limits(values, where)
        checks.check_payload(values, where)
        checks.check_happenings(values, where)
        block = rows.Block(Columns(self, None, 1), np.zeros(1, dtype=np.intp))
        self.rest = rows.rest_of(block)
        checks.check_formation(values, self.rest, where)
        payload, vehicles = rows.starts(block, self.rest)
        self.payload_start, self.vehicle_start = payload[0], vehicles[0]
        with np.errstate(over="ignore"):  # an infinite length is too long
            lengths = rows.cable_lengths(block, payload, vehicles)[0]
        checks.check_start(lengths, values, where)
        validation.check_timing(self.model, values, where)
        pushes.check_steps(values, where)
        references.pieces(values, where)

    @property
    def count(self) -> int:
        """How many vehicles there are."""
        return int(self.values["plant"]["vehicles"])


def spatial_only(scenario: Scenario, what: str) -> SpatialScenario:
    """The scenario as a spatial one, for what knows no other plant.

    Args:
        scenario: of any model.
        what: is asked for, to begin the error with.

    Raises:
        ScenarioError: for a scenario of another model.
    """
    if not isinstance(scenario, SpatialScenario):
        raise ScenarioError(
            f"is not the plant that {what} knows",
            where=scenario.where,
            key="plant.model",
            value=scenario.model.name,
            permitted="spatial",
        )
    return scenario
