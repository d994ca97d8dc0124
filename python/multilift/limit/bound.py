"""The physical bound of a scenario's move: found, and checked on the plant that runs fly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilift.controllers import PythonLaw
from multilift.errors import ScenarioError
from multilift.limit import collocation
from multilift.limit.bounds import Limits
from multilift.limit.collocation import Solution
from multilift.limit.errors import LimitError
from multilift.limit.move import Move
from multilift.run import Run, finite
from multilift.scenario import Scenario
from multilift.simulate import simulate

#: Integration step of the check at most, s.
STEP = 0.001
#: How long the check holds the goal after the move, in parts of the move.
HOLD = 0.25
#: How far from the goal, m, and from hanging at rest, deg, the check may end.
FARTHEST, MOST_SWING = 1e-3, 0.05

TITLES = {"time": "time-optimal", "effort": "least effort", "swing": "least swing"}


@dataclass(frozen=True)
class Bound:
    """A move at its bound.

    Attributes:
        scenario: whose move it is.
        limits: that it keeps, with the force that was taken.
        least: "time", "effort" or "swing".
        solutions: on each mesh, the finest last.
        run: the found inputs on the scenario's own plant, with ideal actuators and sensors; then
            held at the goal for a while.
        arrival: how far that run is from rest at the goal when the move is over: ``position``, m,
            ``speed``, m/s, ``swing``, deg.
    """

    scenario: Scenario
    limits: Limits
    least: str
    solutions: list[Solution]
    run: Run
    arrival: dict[str, float]

    @property
    def time(self) -> float:
        """How long the move takes, s."""
        return self.solutions[-1].time

    def multiple(self, run: Run) -> float:
        """A run's combined settling time in parts of this move's; NaN where it never settled."""
        return run.metrics["combined_settling"] / self.time

    def to_json(self, beside: Sequence[Run] = ()) -> dict[str, Any]:
        """As values for JSON.

        Args:
            beside: runs of the scenario under laws, to be compared.
        """
        return {
            "scenario": self.scenario.name,
            "least": self.least,
            "time": self.time,
            "objective": self.solutions[-1].objective,
            "limits": self.limits.to_json(),
            "meshes": [
                {"intervals": len(s.inputs), "time": s.time, "objective": s.objective,
                 "iterations": s.iterations}
                for s in self.solutions
            ],
            "check": {**self.arrival, "step": self.run.scenario["simulation.step"]},
            "combined_settling": finite(self.run.metrics["combined_settling"]),
            "peak_swing": max(
                v for k, v in self.run.metrics.items() if k.startswith("peak_swing")
            ),
            "min_tension": self.run.metrics["min_tension"],
            "laws": {
                run.controller: {
                    "combined_settling": finite(run.metrics["combined_settling"]),
                    "multiple": finite(self.multiple(run)),
                }
                for run in beside
            },
        }  # fmt: skip


def find(
    scenario: Scenario,
    limits: Limits | None = None,
    *,
    least: str = "time",
    time: float | None = None,
    intervals: int = 24,
) -> Bound:
    """Finds the bound of a scenario's move and flies it once to check it.

    Args:
        scenario: of the planar or the spatial plant.
        limits: besides the scenario's own; where they say nothing of force, the greatest force
            that the scenario's own law commands along each axis on this move, all being ideal.
        least: "time", or "effort" or "swing" for a given time.
        time: how long the move lasts, s, for these.
        intervals: of the first mesh.

    Raises:
        ScenarioError: for a scenario without a move, and limits that cannot be meant.
        LimitError: if the limits leave no way, the search does not converge, or the check ends
            elsewhere.
        MissingExtraError: without CasADi (``multilift[limit]``).
    """
    _check(scenario, least, time, intervals)
    limits = limits or Limits()
    axes = 2 if scenario.model.name == "planar" else 3
    limits.check(scenario.where, axes)
    if limits.force is None:
        # What no force could move or hold is said before the law flies.
        scenario.model.move(scenario, replace(limits, force=(math.inf,) * axes))
        limits = replace(limits, force=law_force(scenario))
    move = scenario.model.move(scenario, limits)
    solutions = collocation.refine(move, least=least, time=time, intervals=intervals)
    run, arrival = fly(scenario, move, solutions[-1], least)
    if arrival["position"] > FARTHEST or arrival["swing"] > MOST_SWING:
        raise LimitError(
            f"{scenario.where}: the check on the plant ends {arrival['position']:.2g} m and "
            f"{arrival['swing']:.2g} deg off, so the bound is not reported\n"
            "  what to do: more --intervals"
        )
    return Bound(scenario, limits, least, solutions, run, arrival)


def of_the_scenario(scenario: Scenario) -> tuple[float, ...]:
    """No limit of force but those of the scenario's thrust and tilt, as `Limits.force`.

    Raises:
        ScenarioError: where the scenario limits no thrust, so that a move may be as fast as one
            likes.
    """
    key, greatest = scenario.model.thrust_limit(scenario)
    if not math.isfinite(greatest):
        raise ScenarioError(
            "is not limited, so that a move may be as fast as one likes", where=scenario.where,
            key=key, advice=f"say one: --set {key}=30, or take --forces law",
        )  # fmt: skip
    return (math.inf,) * (2 if scenario.model.name == "planar" else 3)


def law_force(scenario: Scenario) -> tuple[float, ...]:
    """The greatest force along each axis that the scenario's law commands, all being ideal, N.

    Beyond what holds a vehicle at rest; over vehicles and time.

    Raises:
        ScenarioError: if the law commands nothing, as where the start is the goal.
    """
    run = simulate(scenario.with_values(scenario.model.unhindered(scenario)))
    force = scenario.model.command_peaks(run)
    if not all(math.isfinite(f) for f in force) or max(force) < 1e-9:
        raise ScenarioError(
            f"its law, {run.controller}, commands {', '.join(f'{f:g}' for f in force)} N along the "
            "axes, which is no limit of force", where=scenario.where, key="controller",
            advice="check that start and goal differ, or say the limit with --forces",
        )  # fmt: skip
    # An axis without command stays free to move a little: what couples into it must be held.
    return tuple(max(f, 0.05 * max(force)) for f in force)


def fly(
    scenario: Scenario, move: Move, solution: Solution, least: str
) -> tuple[Run, dict[str, float]]:
    """The solution's inputs on the scenario's plant, and where that is when the move is over."""
    cells = solution.mesh.cells
    per_cell = max(1, math.ceil(solution.time / cells / STEP))
    step = solution.time / (cells * per_cell)
    moving = cells * per_cell
    steps = moving + math.ceil(HOLD * moving)
    ideal = scenario.with_values(
        {
            **scenario.model.unhindered(scenario),
            "simulation.step": step,
            "simulation.duration": steps * step,
            "simulation.record_period": step,
            "controller.rate": 1.0 / step,
        }
    )
    middles = (np.arange(moving) + 0.5) / moving
    inputs = solution.inputs[solution.mesh.owner(middles)]

    def law(measured: Any) -> list[float]:
        k = round(measured.t / step)
        force: list[float] = (inputs[k] if k < moving else move.input_goal).tolist()
        return force

    run = simulate(ideal, PythonLaw(f"least_{least}", TITLES[least], lambda _: law))
    if not run.finished:
        raise LimitError(
            f"{scenario.where}: the check on the plant {run.ending}, so the bound is not reported\n"
            "  what to do: more --intervals, or a least --tension above 0"
        )
    return run, dict(scenario.model.arrival(run, moving))


def _check(scenario: Scenario, least: str, time: float | None, intervals: int) -> None:
    if least not in collocation.OBJECTIVES:
        raise ScenarioError(
            "is nothing to make least", where=scenario.where, key="--least", value=least,
            permitted=", ".join(collocation.OBJECTIVES),
        )  # fmt: skip
    if (least == "time") != (time is None):
        raise ScenarioError(
            "is what least time looks for" if least == "time" else "is missing",
            where=scenario.where, key="--time", value=time,
            advice="leave it out" if least == "time" else f"say how long: --least {least} --time 3",
        )  # fmt: skip
    if time is not None and not (time > 0 and math.isfinite(time)):
        raise ScenarioError(
            "is no duration", where=scenario.where, key="--time", value=time,
            permitted="a positive number, s",
        )  # fmt: skip
    if not 4 <= intervals <= 400:
        raise ScenarioError(
            "is too few or too many", where=scenario.where, key="--intervals", value=intervals,
            permitted="4 to 400",
        )  # fmt: skip
