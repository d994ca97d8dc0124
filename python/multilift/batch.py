"""Many worlds of one scenario: the same results as one run after the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import controllers, quantities
from multilift.simulate import simulate

if TYPE_CHECKING:
    import pandas as pd

    from multilift.scenario import Scenario


class Batch:
    """Metrics, audit and ending of every world, one row a world."""

    def __init__(self, scenario: Scenario, controller: str, runs: list[Any]) -> None:
        self.scenario = scenario
        self.controller = controller
        self.count = len(runs)
        self.status: NDArray[np.str_] = np.array([r.status for r in runs], dtype=str)
        self.culprit = np.array([r.culprit for r in runs], dtype=np.int64)
        self.end_time = np.array([r.end_time for r in runs], dtype=float)
        self.metrics = {
            k: np.array([r.metrics[k] for r in runs], dtype=float) for k in quantities.METRICS
        }
        self.audit = {
            k: np.array([r.audit[k] for r in runs], dtype=float) for k in quantities.AUDIT
        }


def simulate_batch(
    scenario: Scenario,
    overrides: Mapping[str, ArrayLike] | pd.DataFrame | None = None,
    *,
    controller: str | None = None,
    count: int | None = None,
    threads: int | None = None,
    isa: str | None = None,
    trajectories: bool = False,
    progress: Callable[[int], None] | None = None,
) -> Batch:
    """Simulates every world; `progress` is told how many are done."""
    del threads, isa, trajectories
    columns = {k: np.asarray(v) for k, v in (overrides or {}).items()}
    worlds = len(next(iter(columns.values()))) if columns else count or 1
    law, scenario = controllers.resolve(controller, scenario)
    runs = []
    for k in range(worlds):
        changes = {
            key: int(v[k]) if v.dtype.kind in "iu" else v[k].tolist() for key, v in columns.items()
        }
        runs.append(simulate(scenario.with_values(changes), law.name))
        if progress is not None:
            progress(k + 1)
    return Batch(scenario, law.name, runs)
