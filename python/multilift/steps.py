"""The times of a run, counted in integration steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol


class Clock(Protocol):
    """What gives the values of dotted keys: a scenario or a mapping."""

    def __getitem__(self, key: str, /) -> Any:
        """The value of a key."""


@dataclass(frozen=True)
class Steps:
    """The times of a run in integration steps.

    Attributes:
        step: s.
        steps: of the whole run.
        control_steps: between two steps of the law.
        record_steps: between two rows of the trajectory.
    """

    step: float
    steps: int
    control_steps: int
    record_steps: int

    @classmethod
    def of(cls, clock: Clock) -> Steps:
        """From a scenario, or from the values of its clock's keys."""
        step = float(clock["simulation.step"])
        return cls(
            step,
            round(clock["simulation.duration"] / step),
            round(1.0 / clock["controller.rate"] / step),
            round(clock["simulation.record_period"] / step),
        )

    @property
    def rows(self) -> int:
        """Rows of the trajectory at most: a world may end between two record periods."""
        return self.steps // self.record_steps + 2
