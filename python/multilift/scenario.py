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

from multilift import _core, geometry, linear, schema
from multilift.errors import ScenarioError
from multilift.geometry import Vector

SCHEMA_VERSION = 1

_TEXTS = ("name", "title", "source", "description")
_TABLES = {
    "plant": schema.PLANT,
    "start": schema.START,
    "goal": schema.GOAL,
    "simulation": schema.SIMULATION,
    "actuators": schema.ACTUATORS,
    "sensors": schema.SENSORS,
}


class Scenario:
    """A checked scenario. Immutable: changes make a new one.

    Tables read as attributes with NumPy arrays: ``scenario.plant.vehicle_mass[0]``. All values
    are SI and radians; see ``docs/scenario-reference``.

    Attributes:
        where: the file it came from, or a description.
        values: every table complete with defaults, as plain Python values.
        q_start, q_dot_start: the seven coordinates and rates at the start, shape (7,).
    """

    def __init__(self, raw: Mapping[str, Any], where: str = "scenario") -> None:
        """Checks `raw`, the tables as a TOML file holds them.

        Raises:
            ScenarioError: naming file, key, value, permitted range and what to do.
        """
        self.where = where
        self._raw: dict[str, Any] = deepcopy(dict(raw))
        self.values = _normalise(self._raw, where)
        self._plant_values = schema.flatten(self.values["plant"], schema.PLANT.fields[1:])
        _check_limits(self.values, where)
        self.q_start, self.q_dot_start = geometry.start_coordinates(
            self.values["plant"], self._plant_values, self.values["start"], where
        )
        _check_goal(self.values, where)
        linear.check_step(self)
        _check_timing(self.values, where)

    @property
    def name(self) -> str:
        """Short name: the file's, unless the scenario gives one."""
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
        """A value by its dotted key, such as ``scenario["controller.k_lambda"]``."""
        node: Any = self.values
        for part in key.split("."):
            if not isinstance(node, dict) or part not in node:
                raise KeyError(key)
            node = node[part]
        return node

    def __repr__(self) -> str:
        return f"Scenario({self.name!r}, law={self.law!r}, from {self.where})"

    def with_values(self, values: Mapping[str, Any]) -> Scenario:
        """A new scenario with some dotted keys changed, checked again.

        Args:
            values: such as ``{"controller.k_lambda": 0.8, "plant.bar_mass": "600 g"}``.

        Raises:
            ScenarioError: as for a file.
        """
        raw = deepcopy(self._raw)
        for key, value in values.items():
            *tables, last = key.split(".")
            node = raw
            for part in tables:
                node = node.setdefault(part, {})
                if not isinstance(node, dict):
                    raise schema.unknown_key(self.where, key, value, sorted(self.values))
            node[last] = value.tolist() if isinstance(value, np.ndarray) else value
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

    def to_toml(self) -> str:
        """The complete scenario, defaults included, as a file that loads to the same one."""
        return tomli_w.dumps(_without_none({"schema": SCHEMA_VERSION, **self.values}))

    # What the compiled core takes.

    def plant_values(self) -> list[float]:
        """The plant's numbers in the core's order."""
        return list(self._plant_values)

    def assumed_values(self) -> list[float]:
        """The plant as the law assumes it, in the core's order."""
        return schema.flatten(self.values["controller"]["assumed"], schema.PLANT.fields[1:])

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
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(
            f"is not valid TOML: {error}", where=str(path), advice="mend the line named"
        ) from None
    raw.setdefault("name", file.stem)
    return Scenario(raw, str(path))


def _normalise(raw: dict[str, Any], where: str) -> dict[str, Any]:
    known = ("schema", *_TEXTS, *_TABLES, "controller", "push")
    for key, value in raw.items():
        if key not in known:
            raise schema.unknown_key(where, key, value, known)
    if raw.get("schema", SCHEMA_VERSION) != SCHEMA_VERSION:
        raise ScenarioError(
            "is not a version this multilift reads",
            where=where,
            key="schema",
            value=raw["schema"],
            permitted=str(SCHEMA_VERSION),
        )
    values: dict[str, Any] = {}
    for key in _TEXTS:
        text = schema.Field(key, "", "text").normalise(raw.get(key, ""), where, key)
        values[key] = text.strip()
    values["name"] = values["name"] or "scenario"
    values["title"] = values["title"] or values["name"]
    for key, table in _TABLES.items():
        values[key] = table.normalise(raw.get(key, {}), where)
    values["controller"] = _normalise_controller(raw.get("controller", {}), values["plant"], where)
    values["push"] = _normalise_pushes(raw.get("push", []), where)
    return values


def _normalise_controller(given: Any, plant: dict[str, Any], where: str) -> dict[str, Any]:
    if not isinstance(given, Mapping) or "law" not in given:
        raise ScenarioError(
            "is missing",
            where=where,
            key="controller.law",
            permitted=", ".join(schema.LAW_TITLES),
            advice="add [controller] with law and its gains",
        )
    law = schema.CONTROLLER_COMMON[0].normalise(given["law"], where, "controller.law")
    given = dict(given)
    assumed = given.pop("assumed", {})
    values = schema.controller_table(law).normalise(given, where)
    if not isinstance(assumed, Mapping):
        assumed = {"": assumed}
    values["assumed"] = schema.PLANT.normalise(
        {**plant, **assumed}, where, prefix="controller.assumed"
    )
    return values


def _normalise_pushes(given: Any, where: str) -> list[dict[str, Any]]:
    if not isinstance(given, list):
        raise ScenarioError(
            "is not a list of tables", where=where, key="push", advice="write [[push]]"
        )
    pushes = []
    for k, entry in enumerate(given):
        key = f"push[{k}]"
        push = schema.PUSH.normalise(entry, where, prefix=key)
        if push["torque"] and push["body"] != "bar":
            raise ScenarioError(
                "acts on a point mass", where=where, key=f"{key}.torque", value=push["torque"],
                advice="torques act on the bar only",
            )  # fmt: skip
        if push["shape"] == "sine" and push["frequency"] is None:
            raise ScenarioError(
                "is missing", where=where, key=f"{key}.frequency", permitted="> 0 Hz",
                advice="shape 'sine' needs it",
            )  # fmt: skip
        times, heights = push["sample_times"] or [], push["sample_values"] or []
        if push["shape"] == "samples" and (
            len(times) < 2 or len(times) != len(heights) or (np.diff(times) <= 0).any()
        ):
            raise ScenarioError(
                "does not make a profile",
                where=where,
                key=f"{key}.sample_times",
                value=times,
                permitted="two or more ascending times, as many as sample_values",
            )
        pushes.append(push)
    return pushes


def _check_limits(values: dict[str, Any], where: str) -> None:
    limits = values["actuators"]
    if limits["thrust_min"] >= limits["thrust_max"]:
        raise ScenarioError(
            "is not below thrust_max",
            where=where,
            key="actuators.thrust_min",
            value=limits["thrust_min"],
            permitted=f"< {limits['thrust_max']:g} N",
        )
    if limits["tilt_max"] > np.pi / 2 + 1e-12:
        raise ScenarioError(
            "is more than a quarter turn",
            where=where,
            key="actuators.tilt_max",
            value=limits["tilt_max"],
            permitted="0 < tilt_max <= pi/2 rad",
        )
    share = [
        (m + 0.5 * values["plant"]["bar_mass"]) * values["plant"]["gravity"]
        for m in values["plant"]["vehicle_mass"]
    ]
    if max(share) > limits["thrust_max"]:
        raise ScenarioError(
            "cannot hold a vehicle and its half of the bar",
            where=where,
            key="actuators.thrust_max",
            value=limits["thrust_max"],
            permitted=f">= {max(share):.6g} N",
        )


def _check_goal(values: dict[str, Any], where: str) -> None:
    goal = np.array(values["goal"]["vehicle_position"])
    along, up = geometry.goal_mismatch(values["plant"], goal)
    if max(abs(along), abs(up)) > 1e-6 and not values["goal"]["allow_mismatch"]:
        raise ScenarioError(
            f"breaks (17): y2 - y1 misses the bar's length by {along:.6g} m, the cables' lower "
            f"ends differ by {up:.6g} m in height",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
            permitted="y2 - y1 = plant.bar_length and z1 - l1 = z2 - l2",
            advice="mend the goal, or set goal.allow_mismatch = true to fly it anyway",
        )
    problem = geometry.linkage_problem(values["plant"], goal)
    if problem:
        raise ScenarioError(
            f"is impossible: {problem}",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
        )


def _check_timing(values: dict[str, Any], where: str) -> None:
    step = float(values["simulation"]["step"])

    def multiple(key: str, time: float, zero_allowed: bool) -> int:
        ratio = time / step
        count: int = round(ratio)
        if (count == 0 and not (zero_allowed and time == 0.0)) or abs(ratio - count) > 1e-6 * max(
            1, count
        ):
            raise ScenarioError(
                f"is {ratio:.6g} integration steps, not a whole number",
                where=where,
                key=key,
                value=time,
                permitted=f"multiples of simulation.step = {step:g} s"
                + (", or 0" if zero_allowed else ""),
                advice="change it or simulation.step",
            )
        return count

    multiple("simulation.duration", values["simulation"]["duration"], False)
    multiple("simulation.record_period", values["simulation"]["record_period"], False)
    control = multiple("1 / controller.rate", 1.0 / values["controller"]["rate"], False)
    delay = multiple("actuators.command_delay", values["actuators"]["command_delay"], True)
    sample = multiple("sensors.period", values["sensors"]["period"], True) or control
    lag = multiple("sensors.delay", values["sensors"]["delay"], True)
    capacity = _core.planar_delay_capacity - 2
    for key, steps, every in (
        ("actuators.command_delay", delay, control),
        ("sensors.delay", lag, sample),
    ):
        if steps > capacity * every:
            raise ScenarioError(
                "keeps too many values under way",
                where=where,
                key=key,
                value=steps * step,
                permitted=f"at most {capacity * every * step:g} s at this rate",
            )
    seed = values["simulation"]["seed"]
    if seed != int(seed) or seed >= 2**53:
        raise ScenarioError(
            "is not a whole number below 2^53", where=where, key="simulation.seed", value=seed
        )
    values["simulation"]["seed"] = int(seed)


def _without_none(node: Any) -> Any:
    if isinstance(node, dict):
        return {k: _without_none(v) for k, v in node.items() if v is not None}
    if isinstance(node, list):
        return [_without_none(v) for v in node]
    return node
