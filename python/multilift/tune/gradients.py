"""The last steps of a search along exact derivatives, where the metric has them.

CMA-ES finds the valley and then creeps; with the derivatives of the run itself L-BFGS-B walks down
the rest of it. That needs one objective, or a weighted sum, of one flight, that changes smoothly
with the numbers, and no constraints.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from multilift import gradient
from multilift.errors import MissingExtraError, ScenarioError
from multilift.study.vary import Array, Vary
from multilift.tune.spec import Tuning
from multilift.tune.strategies import Strategy

#: Runs with derivatives, at most, and as a share of the budget.
_MOST, _SHARE = 40, 8


def budget(tuning: Tuning) -> int:
    """Sets of numbers that are kept for the last steps; 0 where there are none."""
    goal = tuning.goal
    one = len(goal.objectives) == 1 or goal.combine == "weighted"
    smooth = not any(o.metric in _stepping(tuning) for o in goal.objectives)
    if tuning.over is not None or goal.constraints or goal.combine == "front":
        return 0
    if not (one and smooth):
        return 0
    try:
        slope(tuning, tuning.start())
    except ScenarioError:  # a number along which nothing can be differentiated
        return 0
    return min(_MOST, tuning.budget // _SHARE)


def polished(tuning: Tuning, first: Strategy) -> Strategy:
    """Another strategy's points, and then those of a walk down from its best."""
    points, figures = [], []
    asked = next(first, None)
    while asked is not None:
        told = yield asked
        points.append(asked)
        figures.append(told)
        try:
            asked = first.send(told)
        except StopIteration:
            asked = None
    every = np.concatenate(figures)
    best = np.concatenate(points)[np.lexsort(tuning.goal.order(every).T[::-1])[0]]
    steps = walk(tuning, best, budget(tuning))
    if len(steps):
        yield steps


def walk(tuning: Tuning, start: Array, most: int) -> Array:
    """The points at which L-BFGS-B looks on its way down, shape (N, dimensions).

    Args:
        tuning: whose objective it goes down.
        start: of the unit cube.
        most: points.

    Raises:
        MissingExtraError: without SciPy.
    """
    try:
        from scipy.optimize import minimize  # noqa: PLC0415 - only where it walks
    except ImportError:
        raise MissingExtraError("scipy", "tune", "multilift tune") from None
    seen: list[Array] = []

    def look(x: Array) -> tuple[float, Array]:
        value, along = slope(tuning, x)
        if len(seen) >= most or not (np.isfinite(value) and np.isfinite(along).all()):
            raise StopIteration  # where there is no value there is no way down
        seen.append(np.clip(x, 0.0, 1.0))
        return value, along

    with contextlib.suppress(StopIteration):
        minimize(look, start, jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * len(start))
    return np.array(seen).reshape(-1, len(start))


def slope(tuning: Tuning, point: Array) -> tuple[float, Array]:
    """The objective at a point of the unit cube, to be made small, and its derivatives there.

    Numbers are not rounded here.

    Raises:
        ScenarioError: for a number along which a run cannot be differentiated.
    """
    space = replace(tuning.space, digits=None)
    numbers = space.numbers(point[None])
    changes = space.overrides(tuning.scenario, numbers)
    scenario = tuning.scenario.with_values({key: x[0].tolist() for key, x in changes.items()})
    shares = [dict(_shares(tuning, v)) for v in space.varied]
    keys = list(dict.fromkeys(key for share in shares for key in share))
    found = gradient(scenario, keys)
    value, along = 0.0, np.zeros(len(point))
    for o in tuning.goal.objectives:
        value += o.weight * o.sign * found.values[o.metric]
        rows = dict(zip(keys, found[o.metric], strict=True))
        for k, v in enumerate(space.varied):
            per_number = sum(share * rows[key] for key, share in shares[k].items())
            along[k] += o.weight * o.sign * per_number * _stretch(v, float(numbers[v.name][0]))
    return float(value), along


def _shares(tuning: Tuning, varied: Vary) -> Iterator[tuple[str, float]]:
    """Each single number of the scenario that follows, and how much it follows."""
    for target in varied.targets:
        own = np.asarray(tuning.scenario[target.key], dtype=float)
        for place in np.ndindex(own.shape):
            index = "".join(f"[{k}]" for k in place)
            scale = float(own[place]) if varied.apply == "multiply" else 1.0
            yield f"{target.key}{index}", target.factor * scale


def _stretch(varied: Vary, number: float) -> float:
    """How much a number changes across the unit cube, here."""
    if varied.distribution == "log_uniform":
        return number * float(np.log(varied.high / varied.low))
    return varied.high - varied.low


def _stepping(tuning: Tuning) -> tuple[str, ...]:
    """What counts integration steps, and when a run ends."""
    return (*tuning.scenario.model.without_derivative, "end_time")
