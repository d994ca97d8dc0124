"""What tuning wants: objectives, constraints, and which of two sets of numbers is better.

A set of numbers flies one world or many, and its figures are the metrics, a statistic over these
worlds, in which a metric without a value (never settled, ended early) counts as infinite. Of two
sets the better one is

1. the one that breaks the constraints less,
2. then the one with the lesser objective; after that the lesser second objective, where they are
   lexicographic,
3. where neither has an objective, the one with fewer worlds that have none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift.batch import Batch
from multilift.study.spec import Criterion
from multilift.study.vary import Array

STATISTICS = ("nominal", "worst", "quantile", "mean")
COMBINATIONS = ("weighted", "lexicographic", "front")

#: A constraint keeps to a metric's bounds as a study's criterion of success does.
Constraint = Criterion


@dataclass(frozen=True)
class Objective:
    """A metric to be made small or great.

    Attributes:
        metric: by name; ``audit.`` and an entry of the audit.
        weight: in a weighted sum.
        within: differences below this decide nothing where objectives are lexicographic.
        maximise: great instead of small.
        unit: of the metric.
    """

    metric: str
    weight: float = 1.0
    within: float = 0.0
    maximise: bool = False
    unit: str = ""

    @property
    def sign(self) -> float:
        """By which the metric is multiplied to be made small."""
        return -1.0 if self.maximise else 1.0


@dataclass(frozen=True)
class Goal:
    """Objectives and constraints.

    Attributes:
        objectives: one or more.
        constraints: none or more.
        combine: "weighted", "lexicographic" or "front".
        statistic: "nominal" for one world; "worst", "quantile" or "mean" over many.
        quantile: between 0 and 1, for that statistic.
    """

    objectives: Sequence[Objective]
    constraints: Sequence[Constraint] = ()
    combine: str = "lexicographic"
    statistic: str = "nominal"
    quantile: float = 0.95

    def figures(self, batch: Batch, worlds: int) -> Array:
        """The figures of each set, from a batch in which every set flew `worlds` worlds in turn.

        Returns:
            One row a set: the objectives, to be made small; the constraints' violations, 0 where
            they hold; the share of worlds in which some objective has no value; the mean end time.
        """
        done = batch.status == "finished"

        def column(metric: str) -> Array:
            values = _quantity(batch, metric)
            if metric != "end_time":
                values = np.where(done, values, np.nan)
            return values.reshape(-1, worlds)

        wanted = [o.sign * column(o.metric) for o in self.objectives]
        missing = np.any([np.isnan(values) for values in wanted], axis=0)
        columns = [self._statistic(values) for values in wanted]
        columns += [self._statistic(violation(c, column(c.metric))) for c in self.constraints]
        return np.column_stack(
            [*columns, missing.mean(axis=1), batch.end_time.reshape(-1, worlds).mean(axis=1)]
        )

    def values(self, figures: Array) -> Array:
        """The objectives themselves, as metrics, of rows of figures; NaN where they have none."""
        signs = np.array([o.sign for o in self.objectives])
        values = figures[..., : len(self.objectives)]
        return np.where(np.isfinite(values), signs * values, np.nan)

    def violations(self, figures: Array) -> Array:
        """The sum of the constraints' violations of each row."""
        first = len(self.objectives)
        return np.asarray(figures[..., first : first + len(self.constraints)].sum(axis=-1))

    def order(self, figures: Array, scales: tuple[Array, Array, Array] | None = None) -> Array:
        """What to sort rows of figures by, the first column first, the less the better.

        Args:
            figures: of sets.
            scales: of a front's part: its weights, the ideal point and the span from there to the
                worst; the objective is then the greatest weighted share of the span.
        """
        count = len(self.objectives)
        values = figures[:, :count]
        if scales is not None:
            weights, ideal, span = scales
            with np.errstate(invalid="ignore"):
                shares = weights * (values - ideal) / span
            first = shares.max(axis=1) + 1e-3 * shares.sum(axis=1)
            rest: list[Array] = []
        elif self.combine == "weighted":
            first = values @ np.array([o.weight for o in self.objectives])
            rest = []
        else:
            first, *rest = (_stepped(values[:, k], o) for k, o in enumerate(self.objectives))
            rest += [values[:, k] for k in range(count)]
        first = np.where(np.isnan(first), np.inf, first)
        share = np.where(np.isfinite(first), 0.0, figures[:, -2])
        return np.column_stack([self.violations(figures), first, share, *rest, -figures[:, -1]])

    def ranks(self, order: Array) -> NDArray[np.intp]:
        """The place of each row, 0 for the best; rows alike share one."""
        _, places = np.unique(order, axis=0, return_inverse=True)
        return np.asarray(places.ravel(), dtype=np.intp)

    def _statistic(self, values: Array) -> Array:
        values = np.where(np.isnan(values), np.inf, values)
        if self.statistic == "mean":
            return np.asarray(values.mean(axis=1))
        if self.statistic == "quantile":
            return np.asarray(np.quantile(values, self.quantile, axis=1, method="higher"))
        return np.asarray(values.max(axis=1))


def violation(constraint: Constraint, values: Array) -> Array:
    """By how much values break a constraint, as a share of the bound; 0 where they hold."""
    over = np.zeros_like(values)
    for bound, sign in ((constraint.below, 1.0), (constraint.above, -1.0)):
        if np.isfinite(bound):
            # What is at a bound breaks it, as it fails a study's criterion.
            excess = sign * (values - bound) / max(abs(bound), 1.0)
            over = np.where(excess >= 0, np.maximum(over, np.maximum(excess, 1e-12)), over)
    return np.where(np.isnan(values), np.inf, over)


def not_dominated(values: Array) -> NDArray[np.intp]:
    """Rows to which none is better in one column and as good in all others; one of equals."""
    order = np.lexsort(values.T[::-1])
    front: list[int] = []
    for k in order:
        if not any((values[j] <= values[k]).all() for j in front):
            front.append(int(k))
    return np.array(front, dtype=np.intp)


def _quantity(batch: Batch, name: str) -> Array:
    if name == "end_time":
        return np.asarray(batch.end_time, dtype=float)
    if name.startswith("audit."):
        return batch.audit[name.removeprefix("audit.")]
    return batch.metrics[name]


def _stepped(values: Array, objective: Objective) -> Array:
    return np.floor(values / objective.within) if objective.within > 0 else values
