"""What varies in a study: one number for each world, and the keys that it sets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import keys, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.scenario import Scenario

Array = NDArray[np.float64]

#: Times that count whole integration steps, at least one; beside them the model's delays.
TIMES = ("simulation.duration", "simulation.record_period")

#: What the number does to a key's own value.
APPLY = ("set", "multiply", "add")

# What each distribution must be given, then what it may be given.
_PARAMETERS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "list": (("values",), ()),
    "grid": (("low", "high", "points"), ("spacing",)),
    "uniform": (("low", "high"), ()),
    "log_uniform": (("low", "high"), ()),
    "normal": (("mean", "std"), ("low", "high")),
}
CROSSED = ("list", "grid")


@dataclass(frozen=True)
class Target:
    """A scenario key and what the drawn number x does to it.

    Attributes:
        key: dotted, with or without indices.
        factor, offset: the key is set to, multiplied by or increased by ``factor x + offset``.
    """

    key: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Vary:
    """One number that differs between worlds.

    Attributes:
        name: of its column in the results.
        label: for figures and tables, with its unit.
        unit: of the number.
        targets: the keys that move with it.
        apply: "set", "multiply" or "add".
        distribution: "list" or "grid", which are crossed; "uniform", "normal", "log_uniform".
        values: of a list or grid.
        low, high: bounds; infinite where a normal distribution has none.
        mean, std: of a normal distribution before its bounds cut it.
    """

    name: str
    label: str
    unit: str
    targets: tuple[Target, ...]
    apply: str
    distribution: str
    values: tuple[float, ...] = ()
    low: float = -np.inf
    high: float = np.inf
    mean: float = 0.0
    std: float = 0.0

    @property
    def crossed(self) -> bool:
        """Whether every value meets every value of the other lists and grids."""
        return self.distribution in CROSSED

    def bounds(self) -> tuple[float, float]:
        """The least and the greatest number that can be drawn."""
        return (min(self.values), max(self.values)) if self.crossed else (self.low, self.high)

    def overrides(self, scenario: Scenario, x: Array) -> dict[str, Array]:
        """What the keys become for drawn numbers `x`, shape (N,) or (N, the key's shape).

        Args:
            scenario: supplies the keys' own values.
            x: the drawn numbers, one a world.
        """
        result: dict[str, Array] = {}
        for target in self.targets:
            amount = x if (target.factor, target.offset) == (1.0, 0.0) else (
                target.factor * x + target.offset
            )  # fmt: skip
            if self.apply != "set":
                own = np.asarray(scenario[target.key], dtype=float)
                amount = amount.reshape(-1, *[1] * own.ndim)
                amount = own * amount if self.apply == "multiply" else own + amount
            if target.key in (*TIMES, *scenario.model.delays):
                step = float(scenario["simulation.step"])
                least = 1.0 if target.key in TIMES else 0.0
                amount = np.maximum(np.rint(amount / step), least) * step
            result[target.key] = amount
        return result


def parse(raw: Any, prefix: str, scenario: Scenario, where: str) -> Vary:
    """Reads one ``[[vary]]`` table.

    Args:
        raw: the table.
        prefix: its place in the file, such as ``vary[0]``.
        scenario: whose keys it may name.
        where: the file, for errors.

    Raises:
        ScenarioError: naming file, key, value, permitted values and what to do.
    """
    reader = Reader(raw, prefix, where)
    apply = reader.text("apply", default="set", choices=APPLY)
    distribution = reader.text("distribution", choices=tuple(_PARAMETERS))
    targets, field = _targets(reader, scenario)
    unit = "" if apply == "multiply" or _is_scaled(targets[0]) else field.unit
    needed, allowed = _PARAMETERS[distribution]
    reader.refuse_unknown(("key", "name", "label", "unit", "apply", "distribution",
                           *needed, *allowed))  # fmt: skip
    given = {p: reader.number(p, unit) for p in (*needed, *allowed)
             if p not in ("values", "points", "spacing") and (p in needed or p in raw)}  # fmt: skip
    values = _values(distribution, reader, unit, given)
    _check(distribution, reader, given)
    unit = reader.text("unit", default=unit)
    suffix = {"set": "", "multiply": ".factor", "add": ".added"}[apply]
    label = reader.text("label", default=targets[0].key + {"multiply": ", factor"}.get(apply, ""))
    return Vary(
        name=reader.text("name", default=targets[0].key + suffix),
        label=f"{label} ({unit})" if unit else label,
        unit=unit,
        targets=targets,
        apply=apply,
        distribution=distribution,
        values=values,
        low=given.get("low", -np.inf),
        high=given.get("high", np.inf),
        mean=given.get("mean", 0.0),
        std=given.get("std", 0.0),
    )


class Reader:
    """Reads a table's entries one by one, with errors that name their place in the file."""

    def __init__(self, raw: Any, prefix: str, where: str) -> None:
        if not isinstance(raw, Mapping):
            raise ScenarioError(
                "is not a table", where=where, key=prefix, value=raw,
                advice=f"write [[{prefix.split('[', maxsplit=1)[0]}]] with keys below",
            )  # fmt: skip
        self.raw, self.prefix, self.where = raw, prefix, where

    def fail(self, key: str, problem: str, permitted: str = "", advice: str = "") -> ScenarioError:
        """The error for one entry."""
        return ScenarioError(
            problem, where=self.where, key=f"{self.prefix}.{key}", value=self.raw.get(key),
            permitted=permitted, advice=advice,
        )  # fmt: skip

    def text(self, key: str, *, default: str | None = None, choices: tuple[str, ...] = ()) -> str:
        """A text entry; `default` None means that it must be there."""
        if key not in self.raw:
            if default is None:
                raise self.fail(key, "is missing", ", ".join(choices), f"add it to {self.prefix}")
            return default
        field = Field(key, "", "text", choices=choices)
        return str(field.normalise(self.raw[key], self.where, f"{self.prefix}.{key}"))

    def number(self, key: str, unit: str = "") -> float:
        """A number that must be there, in `unit` or as a text with one of its multiples."""
        if key not in self.raw:
            raise self.fail(key, "is missing", "a number", f"add it to {self.prefix}")
        field = Field(key, "", unit=unit)
        return float(field.normalise(self.raw[key], self.where, f"{self.prefix}.{key}"))

    def refuse_unknown(self, known: tuple[str, ...]) -> None:
        """Raises for the first entry that is not known."""
        for key, value in self.raw.items():
            if key not in known:
                raise schema.unknown_key(self.where, f"{self.prefix}.{key}", value, known)


def _targets(reader: Reader, scenario: Scenario) -> tuple[tuple[Target, ...], Field]:
    if "key" not in reader.raw:
        raise reader.fail("key", "is missing", "a scenario key or a list of keys",
                          "such as key = \"plant.bar_mass\"")  # fmt: skip
    given = reader.raw["key"]
    targets, fields = [], []
    for entry in given if isinstance(given, list) else [given]:
        if isinstance(entry, Mapping):
            inner = Reader(entry, f"{reader.prefix}.key", reader.where)
            inner.refuse_unknown(("key", "factor", "offset"))
            target = Target(
                inner.text("key"),
                inner.number("factor") if "factor" in entry else 1.0,
                inner.number("offset") if "offset" in entry else 0.0,
            )
        elif isinstance(entry, str):
            target = Target(entry)
        else:
            raise reader.fail("key", "is not a key", "a text such as \"plant.bar_mass\", a list of "
                              "these, or {key = ..., factor = ..., offset = ...}")  # fmt: skip
        field = keys.field_of(target.key, scenario.values, f"{reader.where}, {reader.prefix}.key")
        if field.kind != "number":
            raise reader.fail("key", f"names a {field.kind}, not a number", "keys with numbers",
                              "fix it with [set], or make a study for each value")  # fmt: skip
        targets.append(target)
        fields.append(field)
    if not targets:
        raise reader.fail("key", "is empty", "one key or more")
    return tuple(targets), fields[0]


def _is_scaled(target: Target) -> bool:
    return target.factor != 1.0


def _values(
    distribution: str, reader: Reader, unit: str, given: Mapping[str, float]
) -> tuple[float, ...]:
    if distribution == "list":
        if "values" not in reader.raw:
            raise reader.fail("values", "is missing", "a list of numbers")
        field = Field("values", "", "list", unit=unit)
        values = field.normalise(reader.raw["values"], reader.where, f"{reader.prefix}.values")
        if not values:
            raise reader.fail("values", "is empty", "one number or more")
        if len(set(values)) < len(values):
            raise reader.fail("values", "names a value twice", "distinct numbers", "drop one")
        return tuple(values)
    if distribution == "grid":
        points = reader.number("points")
        if points != int(points) or not 2 <= points <= 1_000_000:
            raise reader.fail("points", "is not a count of points", "whole, 2 to 1000000")
        spacing = reader.text("spacing", default="linear", choices=("linear", "log"))
        low, high = given["low"], given["high"]
        if spacing == "log" and low <= 0:
            raise reader.fail("low", "has no logarithm", "> 0 where spacing is log")
        if low >= high:
            raise reader.fail("low", "is not below high", f"< {high:g}", "swap them")
        make = np.geomspace if spacing == "log" else np.linspace
        return tuple(float(x) for x in make(low, high, int(points)))
    return ()


def _check(distribution: str, reader: Reader, given: Mapping[str, float]) -> None:
    low, high = given.get("low", -np.inf), given.get("high", np.inf)
    if low >= high:
        raise reader.fail("low", "is not below high", f"< {high:g}", "swap them")
    if distribution == "log_uniform" and low <= 0:
        raise reader.fail("low", "has no logarithm", "> 0", 'or use distribution = "uniform"')
    if distribution == "normal":
        if given["std"] <= 0:
            raise reader.fail("std", "is not positive", "> 0", "to fix a value, use [set]")
        far = max(low - given["mean"], given["mean"] - high) / given["std"]
        if far > 6:
            raise reader.fail("mean", f"lies {far:.3g} standard deviations outside its bounds",
                              "at most 6", "move the mean or the bounds")  # fmt: skip
