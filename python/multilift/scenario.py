"""A scenario: one file that says everything about a run, read, checked and complete."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
import tomli_w

from multilift import keys, models, schema, validation
from multilift.models import Model
from multilift.quantities import Quantities


class Scenario:
    """A checked scenario. Immutable: changes make a new one.

    Tables read as attributes with NumPy arrays: ``scenario.plant.vehicle_mass[0]``. All values
    are SI and radians; see ``docs/scenario-reference``.

    ``Scenario(raw)`` gives one of its model's class, which has more to say of it, as ``Path(name)``
    gives one of the system's: a :class:`~multilift.models.planar.scenario.PlanarScenario` where
    ``plant.model`` is "planar".

    Attributes:
        where: the file it came from, or a description.
        values: every table complete with defaults, as plain Python values.
    """

    def __new__(cls, raw: Mapping[str, Any] | None = None, where: str = "scenario") -> Scenario:
        """Of the class of the model that `raw` names; unpickling knows its class already."""
        named = cls is Scenario and raw is not None
        return object.__new__(models.of(raw or {}, where).scenario_type if named else cls)

    def __init__(self, raw: Mapping[str, Any], where: str = "scenario") -> None:
        """Checks `raw`, the tables as a TOML file holds them.

        Raises:
            ScenarioError: naming file, key, value, permitted range and what to do.
        """
        self.where = where
        self._raw: dict[str, Any] = deepcopy(dict(raw))
        self.values = validation.normalise(models.of(self._raw, where), self._raw, where)
        self._check()

    def _check(self) -> None:
        """Checks what the complete tables must satisfy together; of the model's class."""
        raise NotImplementedError

    @property
    def model(self) -> Model:
        """The model that ``plant.model`` names."""
        return models.by_name(self.values["plant"]["model"])

    @property
    def quantities(self) -> Quantities:
        """Names, units and meanings of what a run of this scenario returns."""
        return self.model.quantities(self)

    @property
    def name(self) -> str:
        """Short name; the file's, unless the scenario gives one."""
        return str(self.values["name"])

    @property
    def title(self) -> str:
        """One line for figures and tables."""
        return str(self.values["title"])

    @property
    def law(self) -> str:
        """Name of the control law that the scenario asks for."""
        return str(self.values["controller"]["law"])

    def __getattr__(self, table: str) -> SimpleNamespace:
        values = self.__dict__.get("values", {})
        if table not in values or not isinstance(values[table], dict):
            raise AttributeError(f"a scenario has no table {table!r}")
        return SimpleNamespace(
            **{k: np.array(v) if isinstance(v, list) else v for k, v in values[table].items()}
        )

    def __getitem__(self, key: str) -> Any:
        """A value by its dotted key: ``scenario["controller.k_lambda"]``, ``["push[0].start"]``."""
        return keys.look_up(self.values, key)

    def __repr__(self) -> str:
        return f"Scenario({self.name!r}, law={self.law!r}, from {self.where})"

    def with_values(self, values: Mapping[str, Any]) -> Scenario:
        """A new scenario with some dotted keys changed, checked again.

        Args:
            values: such as ``{"controller.k_lambda": 0.8, "plant.bar_mass": "600 g"}``; one place
                of an array by its indices, ``{"controller.k_d[0][1]": 5.0}``. Keys without
                indices are set first.

        Raises:
            ScenarioError: as for a file.
        """
        raw = deepcopy(self._raw)
        plain = {
            str(k): v.tolist() if isinstance(v, (np.ndarray, np.generic)) else v
            for k, v in values.items()
        }
        for key, value in plain.items():
            if keys.has_index(key):
                continue
            *tables, last = key.split(".")
            node = raw
            for part in tables:
                node = node.setdefault(part, {})
                if not isinstance(node, dict):
                    raise schema.unknown_key(self.where, key, value, sorted(self.values))
            node[last] = value
        for key, value in plain.items():
            if keys.has_index(key):
                complete = validation.normalise(models.of(raw, self.where), raw, self.where)
                keys.put(raw, complete, key, value, self.where)
        return Scenario(raw, self.where)

    def with_law(self, law: str) -> Self:
        """The same scenario under another compiled law; gains that both know carry over.

        Raises:
            ScenarioError: if the law is unknown or needs gains that the scenario lacks.
        """
        choice = schema.controller_fields(tuple(self.model.laws))[0]
        known = self.model.controller_keys(choice.normalise(law, self.where, "controller.law"))
        raw = deepcopy(self._raw)
        raw["controller"] = {k: v for k, v in raw["controller"].items() if k in known}
        raw["controller"]["law"] = law
        return type(self)(raw, self.where)

    def raw(self) -> dict[str, Any]:
        """The tables as the file and later changes give them, without defaults."""
        return deepcopy(self._raw)

    def to_toml(self) -> str:
        """The complete scenario, defaults included, as a file that loads to the same one."""
        return tomli_w.dumps(_without_none({"schema": validation.SCHEMA_VERSION, **self.values}))

    def gives(self, key: str) -> bool:
        """Whether the file or a later change gives a key itself, so that it is no default."""
        try:
            keys.look_up(self._raw, key)
        except KeyError:
            return False
        return True

    def control_period(self) -> float:
        """Time between two steps of the law, s."""
        return 1.0 / float(self.values["controller"]["rate"])


def load(path: str | Path) -> Scenario:
    """Reads and checks a scenario file.

    Args:
        path: a TOML file, or the name of a scenario that multilift ships, such as "sim1".

    Raises:
        ScenarioError: for a missing or unreadable file and for anything wrong in it.
    """
    from multilift import library  # noqa: PLC0415 - library lists scenarios by loading them

    file = library.find(path)
    raw = library.read(file, str(path))
    raw.setdefault("name", file.stem)
    return Scenario(raw, str(path))


def _without_none(node: Any) -> Any:
    if isinstance(node, dict):
        return {k: _without_none(v) for k, v in node.items() if v is not None}
    if isinstance(node, list):
        return [_without_none(v) for v in node]
    return node
