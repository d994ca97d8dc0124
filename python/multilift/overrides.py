"""Which numbers differ from world to world, as arrays under dotted scenario keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import keys, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.scenario import Scenario


class Columns:
    """A scenario's numbers, each once for all worlds or once a world.

    Attributes:
        count: number of worlds.
    """

    def __init__(
        self, scenario: Scenario, overrides: Mapping[str, ArrayLike] | None, count: int | None
    ) -> None:
        """Checks every override against the schema.

        Args:
            scenario: supplies what is not overridden.
            overrides: dotted keys, optionally with indices, such as ``plant.bar_mass``,
                ``plant.vehicle_mass[0]``, ``push[0].force[1]``; each an array with one entry a
                world, of the key's shape or broadcast to it.
            count: number of worlds, where no override says.

        Raises:
            ScenarioError: for unknown keys, wrong shapes or values out of range, naming the world.
        """
        self.scenario = scenario
        self._tables = scenario.model.tables_of(scenario.values, scenario.where)
        if overrides is not None and not isinstance(overrides, Mapping):
            raise self._error(
                "", f"are {type(overrides).__name__}, not a mapping of keys to arrays"
            )
        if count is not None and not isinstance(count, int):
            raise self._error("", f"count = {count!r} is not a whole number")
        given = {}
        for key, values in (overrides or {}).items():
            try:
                given[str(key)] = np.asarray(values)
            except ValueError:
                raise self._error(str(key), "is ragged", "give arrays of one shape") from None
        lengths = {key: len(a) if a.ndim else -1 for key, a in given.items()}
        if any(n < 0 for n in lengths.values()):
            key = next(k for k, n in lengths.items() if n < 0)
            raise self._error(key, "is a single value", "give one entry for each world")
        if len(set(lengths.values()) | ({count} if count is not None else set())) > 1:
            raise self._error(
                "", f"worlds are counted differently: {lengths or ''}", "give arrays of one length"
            )
        self.count = count if count is not None else next(iter(lengths.values()), 1)
        if self.count < 1:
            raise self._error("", "there are no worlds", "give at least one")
        self._own: dict[str, NDArray[np.float64]] = {}
        for key, values in given.items():
            self._apply(key, values)

    def get(self, table: str, field: Field) -> NDArray[np.float64]:
        """A field's numbers, shape (count, *field.dims) or (1, *field.dims) if all are equal."""
        key = f"{table}.{field.name}"
        if key in self._own:
            return self._own[key]
        value = self.scenario[key]
        if value is None:
            value = np.full(field.dims, np.nan)
        return np.asarray(value, dtype=float)[None]

    def numbers(self, key: str) -> NDArray[np.float64]:
        """A dotted key's numbers, as `get` gives them."""
        return self.get(key.rpartition(".")[0], self._field(key))

    def own(self, key: str) -> NDArray[np.float64]:
        """The numbers of a key that differs from world to world."""
        return self._own[key]

    def is_own(self, key: str) -> bool:
        """Whether a key differs from world to world."""
        return key in self._own

    def world(self, k: int) -> Scenario:
        """World k as a scenario of its own, checked like a file.

        Raises:
            ScenarioError: for numbers that no scenario may hold together.
        """
        return self.scenario.with_values(
            {
                key: values[k].tolist() if values.ndim > 1 else float(values[k])
                for key, values in self._own.items()
            }
        )

    def _field(self, key: str) -> Field:
        table, rest = keys.find_table(keys.parse(key), self._tables, self.scenario.values)
        if table is None:
            tops = [t for name, t in self._tables.items() if "." not in name]
            known = [t.name for t in tops if not t.repeated]
            known += [f"{t.name}[K]" for t in tops if t.repeated]
            raise schema.unknown_key(self.scenario.where, key, None, known)
        by_name = {f.name: f for f in table.fields if f.kind == "number"}
        if len(rest) != 1 or rest[0] not in by_name:
            raise schema.unknown_key(self.scenario.where, key, None, by_name)
        return by_name[str(rest[0])]

    def _apply(self, full_key: str, values: NDArray[Any]) -> None:
        key, place = keys.split_index(full_key)
        field = self._field(key)
        try:
            numbers = values.astype(float)
        except (TypeError, ValueError):
            raise self._error(full_key, "holds something that is not a number") from None
        if len(place) > len(field.dims) or any(
            k >= n for k, n in zip(place, field.dims, strict=False)
        ):
            raise self._error(full_key, "has no such element", f"its shape is {field.dims}")
        base = self._own.get(key)
        if base is None:
            table = key.rpartition(".")[0]
            base = np.broadcast_to(self.get(table, field), (self.count, *field.dims)).copy()
        where: Any = (slice(None), *place)
        part = base[where]
        # One entry a world: leading axis first, then broadcast over the element's own shape.
        numbers = numbers.reshape(numbers.shape + (1,) * (part.ndim - numbers.ndim))
        try:
            base[where] = np.broadcast_to(numbers, part.shape)
        except ValueError:
            raise self._error(
                full_key, f"has shape {values.shape}", f"give (worlds,) or {part.shape}"
            ) from None
        self._check(full_key, field, numbers)
        self._own[key] = base

    def _check(self, key: str, field: Field, numbers: NDArray[np.float64]) -> None:
        infinite_allowed = field.default is not None and np.isinf(np.asarray(field.default)).any()
        bad = np.isnan(numbers) | (np.isinf(numbers) & (not infinite_allowed))
        if field.range == "positive":
            bad |= numbers <= 0
        elif field.range == "non_negative":
            bad |= numbers < 0
        if bad.any():
            world = int(np.argwhere(bad)[0][0])
            raise ScenarioError(
                f"is out of range in world {world}",
                where=self.scenario.where,
                key=key,
                value=np.ravel(numbers[world]).tolist(),
                permitted=field.permitted,
            )

    def _error(self, key: str, problem: str, advice: str = "") -> ScenarioError:
        return ScenarioError(
            problem, where=f"{self.scenario.where}, overrides", key=key, advice=advice
        )
