"""What tuning was worth: before and after, in worlds the search has not seen, and how sharp."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from multilift import linear, simulate
from multilift.errors import MultiliftError
from multilift.run import Run
from multilift.scenario import Scenario
from multilift.study.spec import Study
from multilift.study.vary import Array
from multilift.tune.search import Found, fly
from multilift.tune.spec import Tuning

#: Worlds on which a tuning over draws is judged, at least.
JUDGED = 1000

#: Points of each number's range in the sensitivity.
_POINTS = 25

#: A number may move as long as no objective becomes worse by more than this share.
TOLERATED = 0.10


@dataclass(frozen=True)
class Side:
    """One set of numbers, judged.

    Attributes:
        scenario: with these numbers.
        run: the scenario flown once, without draws.
        numbers: by the variables' names; NaN where the scenario's own are not one number.
        values: the objectives by metric, as the search counted them; NaN where there is none.
        violation: sum over constraints, shares of their bounds.
        judged: the objectives over fresh draws; those of `values` where nothing is drawn.
        never: share of these fresh worlds in which an objective has no value.
        slowest: of the linear closed loop's modes about rest: time constant, s; and
        damping: the least damping ratio of those that turn; NaN where there is no linearisation.
        peaks: greatest commanded force along each axis in `run`, N.
    """

    scenario: Scenario
    run: Run
    numbers: Mapping[str, float]
    values: Mapping[str, float]
    violation: float
    judged: Mapping[str, float]
    never: float
    slowest: float
    damping: float
    peaks: tuple[float, ...]


@dataclass(frozen=True)
class Slice:
    """One number moved through its range, the others resting at the best set.

    Attributes:
        name: of the number.
        numbers: shape (points,).
        values: of the first objective; NaN where there is none or a constraint is broken.
        low, high: between these no objective is worse than the best by more than `TOLERATED`
            and every constraint holds, as far as the points show.
    """

    name: str
    numbers: Array
    values: Array
    low: float
    high: float


def fresh(over: Study | None) -> Study | None:
    """Draws of the same study that a search over it has not seen."""
    if over is None:
        return None
    count = max(over.count, JUDGED // over.cells) if over.sampled else over.count
    return replace(over, seed=over.seed + 1, count=count)


def before(tuning: Tuning, threads: int | None = None) -> Side:
    """The scenario's own numbers."""
    return _side(tuning, None, tuning.scenario, tuning.own_numbers(), threads)


def after(found: Found, threads: int | None = None) -> Side:
    """The best set that was found."""
    numbers = found.numbers(found.best)
    point = found.points[found.best : found.best + 1]
    return _side(found.tuning, point, tuned(found), numbers, threads)


def tuned(found: Found) -> Scenario:
    """The scenario with the best numbers, and how it came by them in its description."""
    tuning, goal = found.tuning, found.tuning.goal
    scenario = tuning.tuned(found.numbers(found.best))
    law = "" if scenario.law == "energy_coupled" else f"_{scenario.law}"
    wanted = ", then ".join(
        f"{'greatest' if o.maximise else 'least'} {o.metric}" for o in goal.objectives
    )
    worlds = ""
    if tuning.over is not None:
        how = {"worst": "the worst", "mean": "the mean"}.get(
            goal.statistic, f"the {100 * goal.quantile:g} % quantile"
        )
        worlds = f", {how} of {tuning.worlds} worlds"
    text = (
        f"Tuned from {tuning.scenario.name} for the {wanted}{worlds}, by {len(found.points)} sets "
        f"of numbers. {scenario.values['description']}"
    )
    kind, what = ("tuned", "tuned") if tuning.over is None else ("robust", "tuned over worlds")
    return scenario.with_values(
        {
            "name": f"{tuning.scenario.name}{law}_{kind}",
            "title": f"{tuning.scenario.title}, {what}",
            "description": text.strip(),
        }
    )


def sensitivity(found: Found, threads: int | None = None) -> list[Slice]:
    """Every number moved through its range, from the best set."""
    tuning = found.tuning
    best = found.points[found.best]
    shares = np.linspace(0.0, 1.0, _POINTS)
    sets = []
    for k in range(tuning.space.dimensions):
        points = np.repeat(best[None], _POINTS, axis=0)
        points[:, k] = shares
        sets.append(points)
    rows = fly(tuning, np.concatenate([*sets, best[None]]), threads)
    count = len(tuning.goal.objectives)
    limit = rows[-1, :count] + TOLERATED * np.abs(rows[-1, :count])
    result = []
    for k, v in enumerate(tuning.space.varied):
        own = rows[k * _POINTS : (k + 1) * _POINTS]
        broken = tuning.goal.violations(own) > tuning.goal.violations(rows[-1:])[0]
        good = (own[:, :count] <= limit).all(axis=1) & ~broken
        numbers = tuning.space.numbers(sets[k])[v.name]
        low, high = _around(numbers, good, found.numbers(found.best)[v.name])
        values = np.where(broken, np.nan, tuning.goal.values(own)[:, 0])
        result.append(Slice(v.name, numbers, values, low, high))
    return result


def _side(
    tuning: Tuning,
    point: Array | None,
    scenario: Scenario,
    numbers: Mapping[str, float],
    threads: int | None,
) -> Side:
    figures = fly(tuning, point, threads)[0]
    judged = fly(tuning, point, threads, over=fresh(tuning.over))[0]
    goal = tuning.goal
    names = [o.metric for o in goal.objectives]
    run = simulate(scenario)
    slowest, damping = _modes(scenario)
    return Side(
        scenario=scenario,
        run=run,
        numbers=numbers,
        values=dict(zip(names, map(float, goal.values(figures)), strict=True)),
        violation=float(goal.violations(figures[None])[0]),
        judged=dict(zip(names, map(float, goal.values(judged)), strict=True)),
        never=float(judged[-2]),
        slowest=slowest,
        damping=damping,
        peaks=tuple(scenario.model.command_peaks(run)),
    )


def _modes(scenario: Scenario) -> tuple[float, float]:
    """Time constant of the slowest mode, s, and the least damping ratio."""
    try:
        modes = np.linalg.eigvals(linear.closed_loop_matrix(scenario))
    except (MultiliftError, ValueError):
        return math.nan, math.nan
    real = float(modes.real.max())
    turning = modes[np.abs(modes.imag) > 1e-9]
    ratio = float((-turning.real / np.abs(turning)).min()) if len(turning) else 1.0
    return (-1.0 / real if real < 0 else math.inf), ratio


def _around(numbers: Array, good: Array, own: float) -> tuple[float, float]:
    """The run of good numbers about the own one."""
    low = high = own
    for x in sorted(numbers[numbers < own], reverse=True):
        if not good[numbers == x].all():
            break
        low = float(x)
    for x in sorted(numbers[numbers > own]):
        if not good[numbers == x].all():
            break
        high = float(x)
    return low, high
