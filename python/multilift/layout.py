"""What every model needs to check worlds and to lay them out as rows for a batch kernel."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.overrides import Columns


def refuse(columns: Columns, world: int) -> None:
    """Raises the error that a world would raise alone.

    Raises:
        ScenarioError: naming the world and what is wrong with it.
    """
    try:
        columns.world(world)
    except ScenarioError as error:
        raise ScenarioError(
            f"world {world} cannot be: {error}", where=columns.scenario.where, key=error.key
        ) from None
    raise AssertionError(f"world {world} is refused in a batch but not alone")


def refuse_first(columns: Columns, bad: NDArray[np.bool_]) -> None:
    """Raises the error of the first world that is marked, if any is.

    Raises:
        ScenarioError: naming the world and what is wrong with it.
    """
    if bad.any():
        refuse(columns, int(np.flatnonzero(bad)[0]))


def bad_timing(columns: Columns) -> NDArray[np.bool_]:
    """Which worlds have a seed or delays that `multilift.validation.check_timing` refuses.

    The clock is checked as worlds are grouped by it.
    """
    seed = columns.numbers("simulation.seed")
    bad = np.zeros(columns.count, dtype=bool)
    bad |= (seed != np.floor(seed)) | (seed >= 2**53)
    for key in columns.scenario.model.delays:
        time, count = columns.numbers(key), step_count(columns, key)
        ratio = time / columns.numbers("simulation.step")
        bad |= ~(np.abs(ratio - count) <= 1e-6 * np.maximum(1, count))
        bad |= (count == 0) & (time > 0)
    return bad


def step_count(columns: Columns, key: str) -> NDArray[np.float64]:
    """How many integration steps a time takes in each world, rounded."""
    return np.asarray(np.round(columns.numbers(key) / columns.numbers("simulation.step")))


def block(
    columns: Columns, worlds: NDArray[np.intp], table: str, fields: Iterable[Field]
) -> NDArray[np.float64]:
    """A table's numbers for some worlds, one row a world, fields and their places in order."""
    parts = []
    for field in fields:
        values = columns.get(table, field)
        shape = (len(worlds), *field.dims)
        values = values[worlds] if len(values) > 1 else np.broadcast_to(values, shape)
        parts.append(values.reshape(len(worlds), -1))
    return np.concatenate(parts, axis=1)


def seeds(columns: Columns, worlds: NDArray[np.intp]) -> NDArray[np.uint64]:
    """The seeds of some worlds."""
    every = np.broadcast_to(columns.numbers("simulation.seed"), (columns.count,))
    return np.ascontiguousarray(every[worlds].astype(np.uint64))
