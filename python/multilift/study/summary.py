"""What a study's rows say: counts, quantiles, success rates, paired differences, worst cases."""

from __future__ import annotations

import math
import shlex
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.run import finite
from multilift.study.draws import draw
from multilift.study.rows import overrides
from multilift.study.spec import Criterion, Study
from multilift.study.statistics import Interval, paired_mean, paired_share, quantiles, wilson
from multilift.study.store import Store
from multilift.toml_text import inline

PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)

#: How many worlds of each kind are named as worst cases.
WORST = 5


@dataclass(frozen=True)
class MetricSummary:
    """A metric over the worlds of one law that ran to their end.

    Attributes:
        count: worlds that ran to their end.
        missing: of these, the ones without a value, such as a swing that never settled.
        least, greatest, mean: over the values; NaN if there is none.
        quantiles: at ``PROBABILITIES``, no value counted as greater than every value.
    """

    count: int
    missing: int
    least: float
    mean: float
    greatest: float
    quantiles: tuple[float, ...]


@dataclass(frozen=True)
class LawSummary:
    """One law: how its worlds ended, how many succeeded, its metrics."""

    law: str
    outcomes: dict[str, int]
    success: Interval
    successes: int
    criteria: tuple[int, ...]
    metrics: dict[str, MetricSummary]


@dataclass(frozen=True)
class Pair:
    """Two laws on the same worlds; differences are the first less the second.

    Attributes:
        first, second: the laws.
        both, only_first, only_second, neither: worlds by who succeeded.
        success: difference of the success rates.
        metrics: mean difference over worlds where both laws have a value, and how many these are.
    """

    first: str
    second: str
    both: int
    only_first: int
    only_second: int
    neither: int
    success: Interval
    metrics: dict[str, tuple[Interval, int]]


@dataclass(frozen=True)
class WorstCase:
    """A world worth a look: where it stands, what happened, the command that replays it."""

    law: str
    world: int
    kind: str
    what: str
    drawn: dict[str, float]
    command: str


@dataclass(frozen=True)
class Summary:
    """Everything that the report says in numbers."""

    study: Study
    laws: tuple[LawSummary, ...]
    pairs: tuple[Pair, ...]
    worst: tuple[WorstCase, ...]

    def to_json(self) -> dict[str, Any]:
        """JSON-ready; numbers that do not exist are None."""
        study = self.study
        pairs = [
            {**asdict(p), "metrics": {n: {**asdict(i), "count": c}
                                      for n, (i, c) in p.metrics.items()}}
            for p in self.pairs
        ]  # fmt: skip
        content: dict[str, Any] = finite({
            "study": study.name, "worlds": study.worlds, "cells": study.cells,
            "count": study.count, "seed": study.seed, "method": study.method,
            "success": [c.sentence() for c in study.success], "quantiles_at": PROBABILITIES,
            "confidence": "95 %: Wilson for rates, bootstrap for paired differences",
            "laws": [asdict(law) for law in self.laws],
            "pairs": pairs,
            "worst_cases": [asdict(w) for w in self.worst],
        })  # fmt: skip
        return content


def summarise(store: Store) -> Summary:
    """Summarises a complete store, reading one column after the other."""
    study = store.study
    outcome = store.column("outcome")
    finished = outcome == 0
    success, criteria = successes(store, finished)
    metrics: list[dict[str, MetricSummary]] = [{} for _ in study.controllers]
    differences: dict[tuple[int, int], dict[str, tuple[Interval, int]]] = {
        pair: {} for pair in _pairs(study)
    }
    for name in study.metrics:
        values = store.column(name)
        for k in range(len(study.controllers)):
            metrics[k][name] = metric_summary(values[k][finished[k]])
        for (a, b), found in differences.items():
            usable = finished[a] & finished[b] & np.isfinite(values[a]) & np.isfinite(values[b])
            delta = values[a][usable] - values[b][usable]
            found[name] = (paired_mean(delta), len(delta))
    laws = tuple(
        LawSummary(
            law,
            {name: int((outcome[k] == code).sum()) for code, name in enumerate(study.outcomes)},
            wilson(int(success[k].sum()), study.worlds),
            int(success[k].sum()),
            tuple(int(c[k].sum()) for c in criteria),
            metrics[k],
        )
        for k, law in enumerate(study.controllers)
    )
    pairs = tuple(_pair(study, a, b, success, found) for (a, b), found in differences.items())
    return Summary(study, laws, pairs, tuple(worst_cases(store, outcome)))


def successes(store: Store, finished: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], list[Any]]:
    """Which worlds succeeded, shape (laws, worlds): ran to their end and met every criterion.

    Returns:
        This, and for each criterion alone which of the worlds that ran to their end met it.
    """
    met = [finished & meets(c, store.column(c.metric)) for c in store.study.success]
    result = finished.copy()
    for each in met:
        result &= each
    return result, met


def meets(criterion: Criterion, values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which values meet a criterion; no value never does."""
    return (values < criterion.below) & (values > criterion.above)


def metric_summary(values: NDArray[np.float64]) -> MetricSummary:
    """Summary of one metric's values, NaN where there is none."""
    there = values[np.isfinite(values)]
    least, mean, greatest = (
        (float(there.min()), float(there.mean()), float(there.max()))
        if len(there) else (math.nan, math.nan, math.nan)
    )  # fmt: skip
    return MetricSummary(len(values), len(values) - len(there), least, mean, greatest,
                         tuple(quantiles(values, PROBABILITIES)))  # fmt: skip


def replay_command(study: Study, law: str, world: int) -> str:
    """The command that runs one world in full: the same numbers as its row, to the last bit."""
    drawn = draw(study, world, world + 1)
    changes: dict[str, Any] = dict(study.changes)
    for key, value in overrides(study, study.scenario.law, drawn).items():
        changes[key] = value[0].tolist()
    parts = ["multilift", "run", study.reference]
    for key, value in changes.items():
        parts += ["--set", f"{key}={inline(value)}"]
    return shlex.join([*parts, "--controller", law])


def worst_cases(store: Store, outcome: NDArray[np.int8]) -> list[WorstCase]:
    """For each law: the worlds that ended first, and the greatest of each of two metrics."""
    study = store.study
    end_time, culprit = store.column("end_time"), store.column("culprit")
    result = []
    for k, law in enumerate(study.controllers):
        early = np.flatnonzero(outcome[k] != 0)
        for w in early[np.argsort(end_time[k][early], kind="stable")[:WORST]]:
            why = study.scenario.model.reason(study.outcomes[outcome[k][w]], int(culprit[k][w]))
            result.append(_case(study, law, int(w), "ended early",
                                f"{why} at t = {end_time[k][w]:.3f} s"))  # fmt: skip
    for name in study.metrics[:2]:
        values = store.column(name)
        for k, law in enumerate(study.controllers):
            whole = np.flatnonzero((outcome[k] == 0) & np.isfinite(values[k]))
            for w in whole[np.argsort(-values[k][whole], kind="stable")[:WORST]]:
                result.append(_case(study, law, int(w), f"greatest {name}",
                                    f"{values[k][w]:.4g}"))  # fmt: skip
    return result


def _case(study: Study, law: str, world: int, kind: str, what: str) -> WorstCase:
    numbers = draw(study, world, world + 1)
    drawn = {v.name: float(numbers[v.name][0]) for v in study.vary}
    return WorstCase(law, world, kind, what, drawn, replay_command(study, law, world))


def _pairs(study: Study) -> list[tuple[int, int]]:
    laws = range(len(study.controllers))
    return [(a, b) for a in laws for b in laws if a < b]


def _pair(
    study: Study, a: int, b: int, success: NDArray[np.bool_], metrics: dict[str, Any]
) -> Pair:
    both = int((success[a] & success[b]).sum())
    only_a, only_b = int((success[a] & ~success[b]).sum()), int((~success[a] & success[b]).sum())
    neither = study.worlds - both - only_a - only_b
    return Pair(study.controllers[a], study.controllers[b], both, only_a, only_b, neither,
                paired_share(only_a, only_b, both + neither), metrics)  # fmt: skip
