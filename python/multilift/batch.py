"""Many worlds of one scenario at once: SIMD lanes and threads, the same bits as one at a time."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import isa as instruction_sets
from multilift.errors import ControllerError, MissingExtraError, MultiliftError
from multilift.overrides import Columns
from multilift.scenario import Scenario
from multilift.steps import Steps

if TYPE_CHECKING:
    import pandas as pd

#: Worlds whose numbers are laid out at a time, so that memory does not grow with the batch.
CHUNK = 16384


class Batch:
    """What became of each world; every array has one entry, or one leading row, a world.

    Attributes:
        scenario: what the worlds have in common, under the law they fly.
        controller: name of that law.
        count: number of worlds.
        status: "finished", or what ended it early: one of the model's, for the planar plant
            "slack", "swing_limit" or "diverged".
        culprit: index of what ended it, such as the slack cable or the angle at its limit; -1 for
            none.
        end_time: when each world ended, s.
        metrics, audit: by name, as of a single run; NaN where there is no value.
        final_state: numbers named by ``scenario.quantities.final_state``, shape (count, numbers):
            for the planar plant bar (y, z), theta1..3 and their rates.
        samples: trajectories, shape (count, rows, columns), NaN after a world's end; None unless
            asked for. ``scenario.quantities.columns`` names the columns.
        kernel_seconds: wall time in the compiled kernel and in laying out its rows.
    """

    def __init__(self, scenario: Scenario, count: int, rows: int | None) -> None:
        self.scenario = scenario
        self.controller = scenario.law
        self.count = count
        self.kernel_seconds = 0.0
        self._status = np.zeros(count, dtype=np.int8)
        self.culprit = np.zeros(count, dtype=np.int8)
        self.end_time = np.zeros(count)
        names = scenario.quantities
        self._metrics = np.zeros((count, len(names.metrics)))
        self._audit = np.zeros((count, len(names.audit)))
        self.final_state = np.zeros((count, len(names.final_state)))
        self.samples: NDArray[np.float64] | None = None
        if rows is not None:
            self.samples = np.full((count, rows, len(names.columns)), np.nan)

    def arrays(self) -> dict[str, NDArray[Any] | None]:
        """The arrays that a kernel fills, by the names it knows them by."""
        return {
            "metrics": self._metrics,
            "audit": self._audit,
            "final_state": self.final_state,
            "end_time": self.end_time,
            "status": self._status,
            "culprit": self.culprit,
            "samples": self.samples,
        }

    def fill(self, worlds: NDArray[np.intp], part: Batch) -> None:
        """Takes over the results of some worlds; its own may have room for more rows."""
        for name, array in self.arrays().items():
            there = part.arrays()[name]
            if array is not None and there is not None and name != "samples":
                array[worlds] = there
        if self.samples is not None and part.samples is not None:
            self.samples[worlds, : part.samples.shape[1]] = part.samples

    @property
    def status(self) -> NDArray[np.str_]:
        """How each world ended."""
        return np.array(self.scenario.model.statuses)[self._status]

    @property
    def metrics(self) -> dict[str, NDArray[np.float64]]:
        """Each metric over all worlds."""
        return {
            name: self._metrics[:, k] for k, name in enumerate(self.scenario.quantities.metrics)
        }

    @property
    def audit(self) -> dict[str, NDArray[np.float64]]:
        """Each audit entry over all worlds."""
        return {name: self._audit[:, k] for k, name in enumerate(self.scenario.quantities.audit)}

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
    model = scenario.model
    if controller is not None and controller not in model.laws:
        raise ControllerError(
            f"a batch flies compiled laws: {', '.join(model.laws)}, not {controller!r}\n"
            "  what to do: step a law of your own with multilift.Worlds"
        )
    if controller is not None and controller != scenario.law:
        scenario = scenario.with_law(controller)
    if threads is not None and not (isinstance(threads, int) and threads > 0):
        raise MultiliftError(f"threads = {threads!r}: give a whole number above 0, or None")
    columns = Columns(scenario, as_mapping(overrides), count)
    model.check_worlds(columns)
    kernel = instruction_sets.kernel(isa)
    groups = _groups(columns)
    rows = max(steps.rows for steps, _ in groups) if trajectories else None
    batch = Batch(scenario, columns.count, rows)
    finished = 0
    for steps, members in groups:
        for begin in range(0, len(members), CHUNK):
            worlds = members[begin : begin + CHUNK]
            part = Batch(scenario, len(worlds), steps.rows if trajectories else None)
            begun = time.perf_counter()
            model.run_worlds(
                kernel, columns, worlds, steps, part.arrays(),
                threads=threads or os.cpu_count() or 1,
                progress=None if progress is None else partial(_add, progress, finished),
            )  # fmt: skip
            batch.kernel_seconds += time.perf_counter() - begun
            batch.fill(worlds, part)
            finished += len(worlds)
    return batch


def _add(progress: Callable[[int], None], before: int, done: int) -> None:
    progress(before + done)


def as_mapping(overrides: Any) -> Mapping[str, ArrayLike] | None:
    """Overrides as a mapping, where a DataFrame may be given."""
    if overrides is None or isinstance(overrides, Mapping):
        return overrides
    return {str(name): overrides[name].to_numpy() for name in overrides.columns}


def _groups(columns: Columns) -> list[tuple[Steps, NDArray[np.intp]]]:
    """Worlds of equal clock and kind: their times in steps, their indices."""
    scenario = columns.scenario
    keys = [key for key in scenario.model.clock if columns.is_own(key)]
    common = {key: float(scenario[key]) for key in scenario.model.clock}
    kinds = scenario.model.kinds(columns)
    if not keys and (kinds == kinds[0]).all():
        return [(Steps.of(common), np.arange(columns.count))]
    table = np.column_stack([*(columns.own(key) for key in keys), kinds])
    values, which = np.unique(table, axis=0, return_inverse=True)
    groups = []
    for k, row in enumerate(values):
        changed = dict(zip(keys, row.tolist(), strict=False))
        scenario.with_values(changed)  # checks the combination
        groups.append((Steps.of({**common, **changed}), np.flatnonzero(which.ravel() == k)))
    return groups
