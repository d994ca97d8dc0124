"""multilift's time for a step, one world or many, whatever the scenario."""

from __future__ import annotations

from collections.abc import Callable

from multilift.batch import simulate_batch
from multilift.bench.rows import nanoseconds
from multilift.scenario import Scenario
from multilift.simulate import simulate
from multilift.steps import Steps

#: Simulations in one repetition.
_RUNS = 5


def one_world(scenario: Scenario) -> Callable[[], float]:
    """Measures a simulation of the scenario, ns a step."""
    steps = Steps.of(scenario).steps
    return lambda: nanoseconds(lambda: [simulate(scenario) for _ in range(_RUNS)], _RUNS * steps)


def many_worlds(
    scenario: Scenario, worlds: int, name: str, threads: int = 1, *, wall: bool = False
) -> Callable[[], float]:
    """Measures a batch, ns a step of one world."""
    steps = Steps.of(scenario).steps

    def measure() -> float:
        return nanoseconds(
            lambda: simulate_batch(scenario, count=worlds, isa=name, threads=threads),
            worlds * steps,
            wall=wall,
        )

    return measure
