"""A scenario: one file that says everything about a run, read, checked and complete."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import tomli_w

from multilift import geometry, keys, linear, schema, validation
from multilift.errors import ScenarioError
from multilift.geometry import Vector


class Scenario:
    """A checked scenario. Immutable: changes make a new one.

    Tables read as attributes with NumPy arrays: ``scenario.plant.vehicle_mass[0]``. All values
    are SI and radians; see ``docs/scenario-reference``.

    Attributes:
        where: the file it came from, or a description.
        values: every table complete with defaults, as plain Python values.
        q_start: the seven coordinates at the start, shape (7,), m and rad.
        q_dot_start: their rates, shape (7,), m/s and rad/s.
    """

    def __init__(self, raw: Mapping[str, Any], where: str = "scenario") -> None:
        """Checks `raw`, the tables as a TOML file holds them.

        Raises:
            ScenarioError: naming file, key, value, permitted range and what to do.
        """
        self.where = where
        self._raw: dict[str, Any] = deepcopy(dict(raw))
        self.values = validation.normalise(self._raw, where)
        self._plant_values = schema.flatten(self.values["plant"], schema.PLANT.fields[1:])
        validation.check_limits(self.values, where)
        self.q_start, self.q_dot_start = geometry.start_coordinates(
            self.values["plant"], self._plant_values, self.values["start"], where
        )
        validation.check_goal(self.values, where)
        linear.check_step(self, where)
        validation.check_timing(self.values, where)
        validation.check_pushes(self.values, where)

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
                complete = validation.normalise(raw, self.where)
                keys.put(raw, complete, key, value, self.where)
        return Scenario(raw, self.where)

    def with_law(self, law: str) -> Scenario:
        """The same scenario under another compiled law; gains that both know carry over.

        Raises:
            ScenarioError: if the law is unknown or needs gains that the scenario lacks.
        """
        schema.CONTROLLER_COMMON[0].normalise(law, self.where, "controller.law")
        known = {f.name for f in schema.controller_table(law).fields} | {"assumed"}
        raw = deepcopy(self._raw)
        raw["controller"] = {k: v for k, v in raw["controller"].items() if k in known}
        raw["controller"]["law"] = law
        return Scenario(raw, self.where)

    def raw(self) -> dict[str, Any]:
        """The tables as the file and later changes give them, without defaults."""
        return deepcopy(self._raw)

    def to_toml(self) -> str:
        """The complete scenario, defaults included, as a file that loads to the same one."""
        return tomli_w.dumps(_without_none({"schema": validation.SCHEMA_VERSION, **self.values}))

    # What the compiled core takes.

    def plant_values(self) -> list[float]:
        """The plant's numbers in the core's order."""
        return list(self._plant_values)

    def assumed_values(self) -> list[float]:
        """The plant as the law assumes it, in the core's order."""
        return schema.flatten(self.values["controller"]["assumed"], schema.PLANT.fields[1:])

    def assumes(self, name: str) -> bool:
        """Whether the scenario says what the law assumes of a plant's key, right or wrong."""
        return name in self._raw["controller"].get("assumed", {})

    def gain_values(self) -> list[float]:
        """The law's gains in the core's order."""
        return schema.flatten(self.values["controller"], schema.gain_fields(self.law))

    def goal_vector(self) -> Vector:
        """[y1d, z1d, y2d, z2d], m."""
        return np.ravel(np.array(self.values["goal"]["vehicle_position"]))

    def control_period(self) -> float:
        """Time between two steps of the law, s."""
        return 1.0 / float(self.values["controller"]["rate"])

    def is_ideal(self) -> bool:
        """True where actuators and sensors have no imperfection, so that none is simulated."""
        return all(
            self.values[t.name][f.name] == f.default
            for t in (schema.ACTUATORS, schema.SENSORS)
            for f in t.fields
        )


def load(path: str | Path) -> Scenario:
    """Reads and checks a scenario file.

    Args:
        path: a TOML file, or the name of a scenario that multilift ships, such as "sim1".

    Raises:
        ScenarioError: for a missing or unreadable file and for anything wrong in it.
    """
    from multilift import library  # noqa: PLC0415 - library lists scenarios by loading them

    file = library.find(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"cannot be read: {error}", where=str(path)) from None
    try:
        raw = tomllib.loads(text)
    except RecursionError:
        raise ScenarioError("is nested too deeply", where=str(path)) from None
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(
            f"is not valid TOML: {error}", where=str(path), advice="mend the line named"
        ) from None
    raw.setdefault("name", file.stem)
    return Scenario(raw, str(path))


def _without_none(node: Any) -> Any:
    if isinstance(node, dict):
        return {k: _without_none(v) for k, v in node.items() if v is not None}
    if isinstance(node, list):
        return [_without_none(v) for v in node]
    return node
