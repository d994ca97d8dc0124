"""How sets of numbers are chosen: generators of points of the unit cube that are sent figures.

Each yields points, shape (N, dimensions), and is sent their figures, one row each. Their choices
follow from the seed and from what they were sent and from nothing else, so that a search goes on
where it was killed once it has been told again what it knew.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

import numpy as np

from multilift.errors import MissingExtraError
from multilift.study.draws import sobol
from multilift.study.vary import Array
from multilift.tune.goals import Goal, not_dominated

Strategy = Generator[Array, Array, None]
#: From figures to what they are sorted by; see `Goal.order`.
Order = Callable[[Array], Array]

#: Sobol points before the first generation, for each dimension.
_SPREAD = 32
#: First step of a descent, in units of the cube.
_SIGMA = 0.2
#: A descent ends where its points lie closer together than this, or after this many generations
#: without a better one.
_CLOSE = 1e-4
_PATIENCE = 25


def descents(
    goal: Goal, dimensions: int, seed: int, budget: int, population: int, start: Array
) -> Strategy:
    """CMA-ES again and again, each time from the best of the spread points left and larger.

    Args:
        goal: which of two is better.
        dimensions: of the cube.
        seed: of all draws.
        budget: points in all.
        population: points of a generation of the first descent.
        start: a point to begin with beside the spread ones.

    Raises:
        MissingExtraError: without cma.
    """
    points, figures = yield from _spread(dimensions, seed, budget, start)
    yield from _descend(goal.order, goal, seed, budget - len(points), population, points, figures)


def front(
    goal: Goal, dimensions: int, seed: int, budget: int, population: int, start: Array
) -> Strategy:
    """Sets of which none is better than another: each objective, then compromises between them.

    After the spread points and the least of each objective, descents make the greatest weighted
    share of the way from the best to the worst of each objective small (augmented Chebyshev), for
    weights spread evenly; parts of the front that are not convex are found as well.

    Args:
        goal: objectives and constraints.
        dimensions: of the cube.
        seed: of all draws.
        budget: points in all.
        population: points of a generation.
        start: a point to begin with beside the spread ones.

    Raises:
        MissingExtraError: without cma.
    """
    points, figures = yield from _spread(dimensions, seed, budget, start)
    count = len(goal.objectives)
    weights = _weights(count, 8 if count == 2 else 4)
    each = (budget - len(points)) // len(weights)
    for k, w in enumerate(weights):
        kept = np.isfinite(figures[:, :count]).all(axis=1) & (goal.violations(figures) == 0)
        known = figures[kept][:, :count]
        if len(known):
            best = known[not_dominated(known)]
            ideal, worst = best.min(axis=0), best.max(axis=0)
        else:
            ideal, worst = np.zeros(count), np.ones(count)
        scales = (w, ideal, np.where(worst > ideal, worst - ideal, 1.0))

        def order(rows: Array, scales: Any = scales) -> Array:
            return goal.order(rows, scales)

        more_points, more_figures = yield from _descend(
            order, goal, seed + 1 + k, each, population, points, figures, again=False
        )
        points = np.concatenate([points, more_points])
        figures = np.concatenate([figures, more_figures])


def _spread(
    dimensions: int, seed: int, budget: int, start: Array
) -> Generator[Array, Array, tuple[Array, Array]]:
    count = max(1, min(_SPREAD * dimensions, budget // 4) - 1)
    points = np.concatenate([start[None], sobol(dimensions, seed, 0, count)])[:budget]
    figures = yield points
    return points, figures


def _descend(
    order: Order, goal: Goal, seed: int, budget: int, population: int, points: Array,
    figures: Array, *, again: bool = True,
) -> Generator[Array, Array, tuple[Array, Array]]:  # fmt: skip
    """Descents from known points; returns what was tried."""
    cma = _cma()
    rng = np.random.default_rng([seed, 1])
    tried, told = [points[:0]], [figures[:0]]
    begun = np.lexsort(order(figures).T[::-1])
    taken: list[Array] = []
    size = population
    left = budget
    while left > 0:
        place = _next_start(points[begun], taken)
        taken.append(place)
        steps = cma.CMAEvolutionStrategy(
            np.clip(place, 0.02, 0.98), _SIGMA,
            {"bounds": [0, 1], "popsize": size, "verbose": -9, "seed": np.nan,
             "randn": lambda *shape: rng.standard_normal(shape)},
        )  # fmt: skip
        best: tuple[float, ...] | None = None
        stale = 0
        while left > 0 and stale < _PATIENCE and max(steps.stds) > _CLOSE:
            asked = steps.ask()
            flown = np.clip(np.array(asked[:left]), 0.0, 1.0)
            rows = yield flown
            left -= len(flown)
            tried.append(flown)
            told.append(rows)
            if len(flown) < len(asked):
                break
            keys = order(rows)
            steps.tell(asked, [float(place) for place in goal.ranks(keys)])
            least = min(tuple(float(x) for x in row) for row in keys)
            stale = 0 if best is None or least < best else stale + 1
            best = least if best is None else min(best, least)
        if not again:
            break
        size = min(2 * size, 8 * population)
    return np.concatenate(tried), np.concatenate(told)


def _next_start(ordered: Array, taken: list[Array]) -> Array:
    """The best point that is not near an earlier start; then the farthest one."""
    if not taken:
        return np.asarray(ordered[0])
    gaps = np.min([np.linalg.norm(ordered - t, axis=1) for t in taken], axis=0)
    far = np.flatnonzero(gaps > 0.15 * np.sqrt(ordered.shape[1]))
    return np.asarray(ordered[far[0] if len(far) else int(np.argmax(gaps))])


def _weights(count: int, steps: int) -> Array:
    """Weights that sum to 1, evenly spread, the corners first; none is quite 0."""
    grid = np.array(np.meshgrid(*[np.arange(steps + 1)] * count)).reshape(count, -1).T
    grid = grid[grid.sum(axis=1) == steps]
    corners = grid.max(axis=1) == steps
    return np.maximum(np.concatenate([grid[corners], grid[~corners]]) / steps, 1e-3)


def _cma() -> Any:
    try:
        import cma  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("cma", "tune", "multilift tune") from None
    return cma
