"""Tuning by draws: the same number for every law, one cost, the best set flown again."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from multilift.batch import Batch, simulate_batch
from multilift.compare.contenders import Contender
from multilift.errors import MissingExtraError
from multilift.models.spatial.run import SpatialRun
from multilift.models.spatial.scenario import SpatialScenario
from multilift.simulate import simulate

Array = NDArray[np.float64]

#: What weighs as much as being off the target for the whole flight.
ERROR = 0.5  # m, root mean square of the payload's distance from its target
SWING = 45.0  # deg, peak


@dataclass(frozen=True)
class Tuned:
    """A contender on a task after its draws.

    Attributes:
        contender: who.
        drawn: the numbers of the best set.
        cost: of the best set, under the seed of tuning; infinite if none flew to the end.
        course: least cost after 1, 2, ... draws.
        finished: how many sets flew to the end.
        run: the best set under the scenario's own seed.
    """

    contender: Contender
    drawn: Mapping[str, float]
    cost: float
    course: Array
    finished: int
    run: SpatialRun


def draws(ranges: Mapping[str, tuple[float, float]], count: int, seed: int) -> dict[str, Array]:
    """Sobol points between the ends of ranges, uniform in their logarithms, arrays of `count`.

    Raises:
        MissingExtraError: without SciPy.
    """
    try:
        from scipy.stats import qmc  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("scipy", "reference", "drawing gains") from None
    with warnings.catch_warnings():  # counts that are no power of two are the user's choice
        warnings.simplefilter("ignore", UserWarning)
        unit = qmc.Sobol(len(ranges), rng=np.random.default_rng(seed)).random(count)
    return {
        name: np.asarray(low * (high / low) ** unit[:, k], dtype=float)
        for k, (name, (low, high)) in enumerate(ranges.items())
    }


def costs(batch: Batch) -> Array:
    """What tuning makes small, for each world.

    The time after which the payload stays within 2 cm of its target, as a part of the flight and 2
    where it never does; plus the root mean square of its distance from the target, `ERROR` counting
    1; plus the cables' peak swing, `SWING` counting 1. Infinite where a flight ended early.
    """
    metrics = batch.metrics
    settled = metrics["payload_settling_time"] / float(batch.scenario["simulation.duration"])
    cost = np.where(np.isnan(settled), 2.0, settled)
    cost = cost + metrics["payload_error_rms"] / ERROR + metrics["peak_swing"] / SWING
    return np.where(batch.status == "finished", cost, np.inf)


def tune(
    scenario: SpatialScenario,
    contender: Contender,
    count: int,
    seed: int,
    *,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Tuned:
    """The best of `count` sets of gains.

    Args:
        scenario: the task; its law is replaced.
        contender: whose gains.
        count: sets to draw and fly.
        seed: of the draws, and of the noise while tuning.
        threads: None for one a processor.
        progress: told how many are flown.

    Raises:
        MissingExtraError: without SciPy.
        MultiliftError: if the law has no gains for this formation.
    """
    drawn = draws(contender.ranges, count, seed)
    first = contender.fly(scenario, {name: float(rows[0]) for name, rows in drawn.items()})
    batch = simulate_batch(
        first.with_values({"simulation.seed": seed}), contender.overrides(scenario, drawn),
        threads=threads, progress=progress,
    )  # fmt: skip
    cost = costs(batch)
    best = int(np.argmin(cost))
    chosen = {name: float(rows[best]) for name, rows in drawn.items()}
    return Tuned(
        contender,
        chosen,
        float(cost[best]),
        np.minimum.accumulate(cost),
        int(np.isfinite(cost).sum()),
        cast("SpatialRun", simulate(contender.fly(scenario, chosen))),
    )
