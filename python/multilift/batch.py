"""Many worlds of one scenario at once: SIMD lanes and threads, the same bits as one at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import isa as instruction_sets
from multilift import layout, quantities, schema
from multilift.errors import ControllerError, MissingExtraError, MultiliftError
from multilift.overrides import Columns
from multilift.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd

#: Names of the core's statuses, by their code.
STATUSES = np.array(["finished", "diverged", "slack", "swing_limit"])

#: Keys that set when things happen. Worlds that agree in all of them share a rollout.
TIMING = (
    "simulation.duration",
    "simulation.step",
    "simulation.record_period",
    "controller.rate",
    "sensors.period",
)

#: Worlds whose numbers are laid out at a time, so that memory does not grow with the batch.
CHUNK = 16384


class Batch:
    """What became of each world; every array has one entry, or one leading row, a world.

    Attributes:
        scenario: what the worlds have in common, under the law they fly.
        controller: name of that law.
        count: number of worlds.
        status: "finished", "slack", "swing_limit" or "diverged".
        culprit: index of the slack cable or of the angle at its limit; -1 for none.
        end_time: when each world ended, s.
        metrics, audit: by name, as of a single run; NaN where there is no value.
        final_state: bar (y, z), theta1..3 and their rates, shape (count, 10).
        samples: trajectories, shape (count, rows, columns), NaN after a world's end; None unless
            asked for. ``quantities.COLUMNS`` names the columns.
    """

    def __init__(self, scenario: Scenario, count: int, rows: int | None) -> None:
        self.scenario = scenario
        self.controller = scenario.law
        self.count = count
        self._status = np.zeros(count, dtype=np.int8)
        self.culprit = np.zeros(count, dtype=np.int8)
        self.end_time = np.zeros(count)
        self._metrics = np.zeros((count, len(quantities.METRICS)))
        self._audit = np.zeros((count, len(quantities.AUDIT)))
        self.final_state = np.zeros((count, 10))
        self.samples: NDArray[np.float64] | None = None
        if rows is not None:
            self.samples = np.full((count, rows, len(quantities.COLUMNS)), np.nan)

    @property
    def status(self) -> NDArray[np.str_]:
        """How each world ended."""
        return STATUSES[self._status]

    @property
    def metrics(self) -> dict[str, NDArray[np.float64]]:
        """Each metric over all worlds."""
        return {name: self._metrics[:, k] for k, name in enumerate(quantities.METRICS)}

    @property
    def audit(self) -> dict[str, NDArray[np.float64]]:
        """Each audit entry over all worlds."""
        return {name: self._audit[:, k] for k, name in enumerate(quantities.AUDIT)}

    def to_dataframe(self) -> pd.DataFrame:
        """One row a world: world, status, culprit, end_time, metrics, and audit.<entry>.

        Raises:
            MissingExtraError: without pandas (``multilift[data]``).
        """
        try:
            import pandas as pd  # noqa: PLC0415
        except ImportError:
            raise MissingExtraError("pandas", "data", "Batch.to_dataframe()") from None
        return pd.DataFrame(
            {
                "world": np.arange(self.count),
                "status": self.status,
                "culprit": self.culprit,
                "end_time": self.end_time,
                **self.metrics,
                **{f"audit.{name}": values for name, values in self.audit.items()},
            }
        )


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
    """Simulates many worlds that differ in any numbers of a scenario.

    A world's result is the same, to the last bit, as that of ``simulate`` with the same numbers,
    whatever the batch, its order, the number of threads and the instruction set.

    Args:
        scenario: what the worlds have in common.
        overrides: dotted keys, optionally with indices (``plant.vehicle_mass[0]``), to arrays with
            one entry a world; a mapping or a DataFrame.
        controller: name of a compiled law; None for the scenario's own.
        count: number of worlds, where no override says.
        threads: None for one a processor.
        isa: instruction set to use; None for the widest (:mod:`multilift.isa`).
        trajectories: keep every world's rows, a record period apart.
        progress: called about ten times a second with the number of worlds done.

    Raises:
        ScenarioError: for overrides that no scenario file may hold; the world is named.
        ControllerError: if the law is not compiled.
        KeyboardInterrupt: within a second of Ctrl-C, if a world lasts less than that.
    """
    if controller is not None and controller not in schema.LAW_TITLES:
        raise ControllerError(
            f"a batch flies compiled laws: {', '.join(schema.LAW_TITLES)}, not {controller!r}\n"
            "  what to do: step a law of your own with multilift.Worlds"
        )
    if controller is not None and controller != scenario.law:
        scenario = scenario.with_law(controller)
    if threads is not None and not (isinstance(threads, int) and threads > 0):
        raise MultiliftError(f"threads = {threads!r}: give a whole number above 0, or None")
    columns = Columns(scenario, as_mapping(overrides), count)
    layout.check_worlds(columns)
    kernel = instruction_sets.kernel(isa)
    groups = _timing_groups(columns)
    rows = max(_steps(t)["rows"] for t, _ in groups) if trajectories else None
    batch = Batch(scenario, columns.count, rows)
    finished = 0
    for timing, members in groups:
        for begin in range(0, len(members), CHUNK):
            worlds = members[begin : begin + CHUNK]
            report = None if progress is None else partial(_add, progress, finished)
            _run(kernel, columns, batch, timing, worlds, threads or os.cpu_count() or 1, report)
            finished += len(worlds)
    return batch


def _add(progress: Callable[[int], None], before: int, done: int) -> None:
    progress(before + done)


def as_mapping(overrides: Any) -> Mapping[str, ArrayLike] | None:
    """Overrides as a mapping, where a DataFrame may be given."""
    if overrides is None or isinstance(overrides, Mapping):
        return overrides
    return {str(name): overrides[name].to_numpy() for name in overrides.columns}


def _timing_groups(columns: Columns) -> list[tuple[dict[str, float], NDArray[np.intp]]]:
    """Worlds by equal timing, ideal ones apart: the timing keys' values, the worlds' indices."""
    keys = [key for key in TIMING if columns.is_own(key)]
    common = {key: float(columns.scenario[key]) for key in TIMING}
    ideal = layout.ideal_worlds(columns)
    if not keys and ideal.all() == ideal.any():
        return [(common, np.arange(columns.count))]
    table = np.column_stack([*(columns.own(key) for key in keys), ideal])
    values, which = np.unique(table, axis=0, return_inverse=True)
    groups = []
    for k, row in enumerate(values):
        changed = dict(zip(keys, row.tolist(), strict=False))
        columns.scenario.with_values(changed)  # checks the combination
        groups.append(({**common, **changed}, np.flatnonzero(which.ravel() == k)))
    return groups


def _steps(timing: Mapping[str, float]) -> dict[str, int]:
    step = timing["simulation.step"]
    steps = round(timing["simulation.duration"] / step)
    record = round(timing["simulation.record_period"] / step)
    # Every record period, and one row more for a world that ends between two.
    return {
        "steps": steps,
        "control": round(1.0 / timing["controller.rate"] / step),
        "record": record,
        "rows": steps // record + 2,
    }


def _run(
    kernel: Any,
    columns: Columns,
    batch: Batch,
    timing: Mapping[str, float],
    worlds: NDArray[np.intp],
    threads: int,
    progress: Callable[[int], None] | None,
) -> None:
    scenario = columns.scenario
    rows, seeds = layout.rows(columns, worlds)
    steps = _steps(timing)
    n = len(worlds)
    part = Batch(scenario, n, steps["rows"] if batch.samples is not None else None)
    kernel.run(
        law=scenario.law,
        rows=rows,
        seeds=seeds,
        pushes=layout.push_shapes(scenario),
        step=timing["simulation.step"],
        steps=steps["steps"],
        control_steps=steps["control"],
        record_steps=steps["record"],
        ideal=bool(layout.ideal_worlds(columns)[worlds[0]]),
        metrics=part._metrics,
        audit=part._audit,
        final_state=part.final_state,
        end_time=part.end_time,
        status=part._status,
        culprit=part.culprit,
        samples=part.samples,
        threads=threads,
        progress=progress,
    )
    for name in ("_metrics", "_audit", "final_state", "end_time", "_status", "culprit"):
        getattr(batch, name)[worlds] = getattr(part, name)
    if batch.samples is not None and part.samples is not None:
        batch.samples[worlds, : part.samples.shape[1]] = part.samples
