"""A scenario of the planar plant: its start and goal, and its numbers as the core takes them."""

from __future__ import annotations

import numpy as np

from multilift import pushes, validation
from multilift.errors import ScenarioError
from multilift.models.planar import checks, geometry, linear, references, tables
from multilift.models.planar.geometry import Vector
from multilift.scenario import Scenario
from multilift.schema import flatten
from multilift.splines import Piece


class PlanarScenario(Scenario):
    """A checked scenario of two vehicles and a bar; see :class:`multilift.Scenario`.

    Attributes:
        q_start: the seven coordinates at the start, shape (7,), m and rad.
        q_dot_start: their rates, shape (7,), m/s and rad/s.
        path: the pieces of the bar's way to its goal, and when it ends, s; none for a step.
    """

    q_start: Vector
    q_dot_start: Vector
    path: tuple[list[Piece], float]

    def _check(self) -> None:
        values, where = self.values, self.where
        checks.check_pushes(values, where)
        checks.check_limits(values, where)
        self.q_start, self.q_dot_start = geometry.start_coordinates(
            values["plant"], self.plant_values(), values["start"], where
        )
        checks.check_goal(values, where)
        checks.check_reference(values, where)
        self.path = references.pieces(
            values,
            self.plant_values(),
            self.assumed_values(),
            self.q_start,
            self.q_dot_start,
            where,
        )
        linear.check_step(self, where)
        counts = validation.check_timing(self.model, values, where)
        checks.check_capacity(values, counts, where)
        pushes.check_steps(values, where)

    def plant_values(self) -> list[float]:
        """The plant's numbers in the core's order."""
        return flatten(self.values["plant"], tables.PLANT_NUMBERS)

    def assumed_values(self) -> list[float]:
        """The plant as the law assumes it, in the core's order."""
        return flatten(self.values["controller"]["assumed"], tables.PLANT_NUMBERS)

    def assumes(self, name: str) -> bool:
        """Whether the scenario says what the law assumes of a plant's key, right or wrong."""
        return self.gives(f"controller.assumed.{name}")

    def gain_values(self) -> list[float]:
        """The law's gains in the core's order."""
        return flatten(self.values["controller"], tables.LAWS[self.law].gains)

    def goal_vector(self) -> Vector:
        """[y1d, z1d, y2d, z2d], m."""
        return np.ravel(np.array(self.values["goal"]["vehicle_position"]))

    def view(self) -> tuple[float, float, float]:
        """How the law looks at its way.

        Returns:
            How far ahead it gives forces and how old its measurements are, both in s, and 1 where
            the way counts damping, else 0.
        """
        reference = self.values["reference"]
        return (
            float(reference["lead"]),
            float(reference["measured_delay"]),
            float(reference["damping"]),
        )

    def moves_target(self) -> bool:
        """Whether the target takes a way to the goal."""
        return bool(self.path[0])

    def is_ideal(self) -> bool:
        """True where actuators and sensors have no imperfection, so that none is simulated."""
        return all(
            self.values[t.name][f.name] == f.default
            for t in (tables.ACTUATORS, tables.SENSORS)
            for f in t.fields
        )


def planar_only(scenario: Scenario, what: str) -> PlanarScenario:
    """The scenario as a planar one, for what knows no other plant.

    Args:
        scenario: of any model.
        what: is asked for, to begin the error with.

    Raises:
        ScenarioError: for a scenario of another model.
    """
    if not isinstance(scenario, PlanarScenario):
        raise ScenarioError(
            f"is not the plant that {what} knows",
            where=scenario.where,
            key="plant.model",
            value=scenario.model.name,
            permitted="planar",
        )
    return scenario
