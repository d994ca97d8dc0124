"""A move as an optimal control problem: equations, inputs, limits, and both ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.limit.errors import LimitError, casadi

Vector = NDArray[np.float64]

#: What rounding may add to a limit, in its own unit.
SLIGHT = 1e-9

#: Expressions of CasADi at one instant: coordinates, rates, accelerations and inputs.
Equations = Callable[[Any, Any, Any, Any], "Instant"]


@dataclass(frozen=True)
class Instant:
    """What holds at one instant, as CasADi's expressions.

    Attributes:
        residual: zero where the equations of motion hold; one entry a coordinate.
        limited: what `Move.lower` and `Move.upper` hold.
        swing: angles, rad, or chords like them, whose squares least-swing control keeps small.
    """

    residual: Any
    limited: Any
    swing: Any


@dataclass(frozen=True)
class Move:
    """From a state to rest at another place.

    Attributes:
        equations: of motion, with what is limited.
        start: coordinates at the start, shape (coordinates,).
        start_rate: their rates there; empty for rest.
        goal: coordinates at the end, at rest.
        input_start: where the search for inputs begins, shape (inputs,).
        input_goal: what holds the goal.
        input_scale: size of the inputs, for conditioning, shape (inputs,).
        input_lower: least inputs, shape (inputs,).
        input_upper: greatest inputs.
        lower: least values of `Instant.limited`, shape (limits,).
        upper: greatest ones.
        limit_names: of each of these, in words.
        time_guess: about how long the move takes, s.
    """

    equations: Equations
    start: Vector
    goal: Vector
    input_start: Vector
    input_goal: Vector
    input_scale: Vector
    input_lower: Vector
    input_upper: Vector
    lower: Vector
    upper: Vector
    limit_names: tuple[str, ...]
    time_guess: float
    start_rate: Vector = field(default_factory=lambda: np.zeros(0))

    @property
    def coordinates(self) -> int:
        """How many coordinates there are."""
        return len(self.start)

    @property
    def inputs(self) -> int:
        """How many inputs there are."""
        return len(self.input_start)

    def check_rest(self, where: str) -> None:
        """Refuses limits that rest itself exceeds.

        Args:
            where: the scenario, for the error.

        Raises:
            LimitError: naming the end and the limit.
        """
        ca = casadi()
        zero = ca.DM.zeros(self.coordinates)
        ends = [("goal", self.goal, self.input_goal)]
        if not self.start_rate.any():
            ends.insert(0, ("start", self.start, self.input_start))
        for end, q, u in ends:
            held = np.array(ca.DM(self.equations(ca.DM(q), zero, zero, ca.DM(u)).limited)).ravel()
            broken = [
                name
                for name, x, low, high in zip(
                    self.limit_names, held, self.lower, self.upper, strict=True
                )
                if not low - SLIGHT <= x <= high + SLIGHT
            ]
            inside = (self.input_lower - SLIGHT <= u) & (u <= self.input_upper + SLIGHT)
            broken += ["force of a vehicle"] * (not inside.all())
            if broken:
                raise LimitError(
                    f"{where}: no move: what holds the load at rest at the {end} exceeds the limit "
                    f"of {broken[0]}\n  what to do: widen that limit"
                )


def time_guess(plant: Mapping[str, Any], way: Vector) -> float:
    """A swing's period, or how long a quarter of the weight takes for the way, s.

    Args:
        plant: its table.
        way: from start to goal along each axis, m.
    """
    period = 2 * np.pi * np.sqrt(max(plant["cable_length"]) / plant["gravity"])
    farthest = float(np.abs(way).max())
    return float(max(period, 2.0 * np.sqrt(farthest / (0.25 * plant["gravity"]))))
