"""How much arithmetic a step of a world is, and how fast this core multiplies and adds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from multilift import _core
from multilift import isa as instruction_sets
from multilift.models.planar import layout
from multilift.overrides import Columns
from multilift.scenario import Scenario
from multilift.steps import Steps

#: Steps between which operations are counted, away from a run's first and last.
_COUNTED = (200, 1200)

#: Turns of the pure loops: some milliseconds.
_TURNS = 200_000


@dataclass(frozen=True)
class Operations:
    """Operations in one step of one world, as the equations are written.

    Attributes:
        add, multiply, divide, root: on floating-point numbers.
        other: comparisons, selections, magnitudes and signs, which are no flops.
    """

    add: float
    multiply: float
    divide: float
    root: float
    other: float

    @property
    def flops(self) -> float:
        """Floating-point operations."""
        return self.add + self.multiply + self.divide + self.root


def operations(scenario: Scenario) -> Operations:
    """Counts the operations of a step by running the rollout itself over counting scalars.

    Args:
        scenario: planar, with ideal actuators and sensors and without pushes.
    """
    row = layout.rows(Columns(scenario, None, 1), np.arange(1))[0][0]
    steps = Steps.of(scenario)
    less, more = (
        _core.planar_operations(scenario.law, row.tolist(), steps.step, n, steps.control_steps)
        for n in _COUNTED
    )
    span = _COUNTED[1] - _COUNTED[0]
    return Operations(**{kind: (more[kind] - less[kind]) / span for kind in less})


def multiply_add_rate(isa: str) -> float:
    """GFLOP/s of a pure loop of products and sums, each rounded as in the kernels."""
    return float(instruction_sets.kernel(isa).multiply_add_rate(_TURNS))


def fused_rate(isa: str) -> float | None:
    """GFLOP/s of a pure loop of fused products and sums; None if the set has none."""
    rate = float(instruction_sets.kernel(isa).fused_rate(_TURNS))
    return None if math.isnan(rate) else rate
