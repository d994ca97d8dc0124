"""A study: one TOML file that says what varies, how often, under which laws; read and checked."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from multilift import library, scenario, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.keys import split_index
from multilift.quantities import Quantity
from multilift.scenario import Scenario
from multilift.study import checks, vary
from multilift.study.vary import Reader, Vary

METHODS = ("random", "sobol", "latin_hypercube")

_KEYS = ("schema", "name", "title", "description", "scenario", "controllers", "count", "seed",
         "method", "metrics", "set", "vary", "success", "map")  # fmt: skip


@dataclass(frozen=True)
class Criterion:
    """What a world must do to count as a success; where the quantity has no value it fails.

    Attributes:
        metric: a metric, ``end_time`` or ``audit.`` and an entry of the audit.
        below, above: what it must stay below and above; infinite where it need not.
        unit: of these.
    """

    metric: str
    below: float = math.inf
    above: float = -math.inf
    unit: str = ""

    def sentence(self) -> str:
        """In words, for tables."""
        parts = [f"above {self.above:g}"] * math.isfinite(self.above)
        parts += [f"below {self.below:g}"] * math.isfinite(self.below)
        return f"{self.metric} {' and '.join(parts)} {self.unit}".rstrip()


@dataclass(frozen=True)
class Map:
    """A figure over two varied numbers: success rate, or the median of a metric."""

    x: str
    y: str
    show: str = "success"


@dataclass(frozen=True)
class Study:
    """A checked study.

    Attributes:
        where: the file.
        name, title, description: texts of the file.
        reference: how a command line names the scenario: shipped name or path.
        changes: the fixed changes of ``[set]``, by dotted key.
        scenario: with these changes, under its own law.
        controllers: compiled laws, flown on identical draws.
        count: draws for each cell of the crossed lists and grids.
        seed: of all draws.
        method: "random", "sobol" or "latin_hypercube".
        vary: what differs between worlds.
        success, metrics, maps: what the summary says of the rows.
    """

    where: str
    name: str
    title: str
    description: str
    reference: str
    changes: dict[str, Any]
    scenario: Scenario
    controllers: tuple[str, ...]
    count: int
    seed: int
    method: str
    vary: tuple[Vary, ...]
    metrics: tuple[str, ...]
    success: tuple[Criterion, ...] = ()
    maps: tuple[Map, ...] = ()

    @property
    def crossed(self) -> tuple[Vary, ...]:
        """The lists and grids."""
        return tuple(v for v in self.vary if v.crossed)

    @property
    def sampled(self) -> tuple[Vary, ...]:
        """What is drawn."""
        return tuple(v for v in self.vary if not v.crossed)

    @property
    def cells(self) -> int:
        """Combinations of the lists and grids."""
        return math.prod(len(v.values) for v in self.crossed)

    @property
    def worlds(self) -> int:
        """Worlds under each law."""
        return self.cells * self.count

    @property
    def draws_noise(self) -> bool:
        """Whether worlds differ in the seed of their measurement noise."""
        keys = self.scenario.model.random_keys
        noisy = any(np.any(self.scenario[key]) for key in keys)
        targets = [split_index(t.key)[0] for v in self.vary for t in v.targets]
        return "simulation.seed" not in targets and (noisy or any(key in keys for key in targets))

    @property
    def outcomes(self) -> tuple[str, ...]:
        """How runs can end, in the order in which tables and figures show them."""
        return self.scenario.model.outcomes

    def under(self, law: str) -> Scenario:
        """The scenario under one of the laws."""
        return self.scenario.with_law(law) if law != self.scenario.law else self.scenario

    def quantity(self, name: str) -> Quantity:
        """Unit and meaning of a metric, of ``end_time`` or of ``audit.`` and an entry."""
        return quantities_of(self.scenario)[name]

    def digest(self) -> str:
        """Fingerprint of everything that decides the rows, and of nothing else."""
        raw = {k: v for k, v in self.scenario.raw().items()
               if k not in ("name", "title", "source", "description")}  # fmt: skip
        content = {
            "scenario": raw,
            "controllers": self.controllers,
            "count": self.count,
            "seed": self.seed,
            "method": self.method,
            "vary": [repr(replace(v, label="", unit="")) for v in self.vary],
        }
        text = json.dumps(content, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()


def load(path: str | Path, *, count: int | None = None) -> Study:
    """Reads and checks a study.

    Args:
        path: a TOML file, or the name of a study that multilift ships.
        count: draws for each cell, instead of the file's.

    Raises:
        ScenarioError: for a missing file and anything wrong in it: file, key, value, what is
            permitted and what to do.
    """
    file = library.find_study(path)
    raw = library.read(file, str(path))
    raw.setdefault("name", file.stem)
    if count is not None:
        raw["count"] = count
    return parse(raw, str(path), file.parent)


def parse(raw: Mapping[str, Any], where: str, folder: Path) -> Study:
    """Checks a study's tables.

    Args:
        raw: as a TOML file holds them.
        where: the file, for errors.
        folder: where a scenario's relative path begins.

    Raises:
        ScenarioError: see `load`.
    """
    for key, value in raw.items():
        if key not in _KEYS:
            raise schema.unknown_key(where, key, value, _KEYS)
    if raw.get("schema", 1) != 1:
        raise ScenarioError("is not a version this multilift reads", where=where, key="schema",
                            value=raw["schema"], permitted="1")  # fmt: skip
    base, reference = _scenario(raw, where, folder)
    changes = changes_of(raw.get("set", {}), where)
    with checks.naming(where, "set"):
        base = base.with_values(changes)
    return _study(raw, base, reference, changes, where)


def of_scenario(
    raw: Mapping[str, Any], base: Scenario, changes: dict[str, Any], where: str
) -> Study:
    """A study of a scenario at hand, under its own law.

    Args:
        raw: what a study's file holds besides ``scenario``, ``controllers`` and ``set``.
        base: the scenario.
        changes: what ``set`` has changed in it already.
        where: for errors.

    Raises:
        ScenarioError: see `load`.
    """
    permitted = ("schema", "count", "seed", "method", "vary")
    for key, value in raw.items():
        if key not in permitted:
            raise schema.unknown_key(where, key, value, (*permitted, "set"))
    return _study(raw, base, base.name, changes, where)


def _study(
    raw: Mapping[str, Any], base: Scenario, reference: str, changes: dict[str, Any], where: str
) -> Study:
    entries = raw.get("vary", [])
    if not isinstance(entries, list) or not entries:
        raise ScenarioError("is missing" if not entries else "is not a list of tables",
                            where=where, key="vary",
                            advice="write one [[vary]] for each number that varies")  # fmt: skip
    varied = tuple(vary.parse(v, f"vary[{k}]", base, where) for k, v in enumerate(entries))
    name = _text(raw, "name", where, "study")
    study = Study(
        where=where,
        name=name,
        title=_text(raw, "title", where, name),
        description=_text(raw, "description", where, ""),
        reference=reference,
        changes=changes,
        scenario=base,
        controllers=_controllers(raw, base, where),
        count=_count(raw, varied, where),
        seed=_whole(raw, "seed", where, default=0, least=0, most=2**63 - 1),
        method=_text(raw, "method", where, "random", METHODS),
        vary=varied,
        success=tuple(criteria(raw, base, where)),
        metrics=_metrics(raw, base, where),
        maps=tuple(_maps(raw, base, varied, where)),
    )
    checks.check(study)
    return study


def quantities_of(base: Scenario) -> dict[str, Quantity]:
    """What a study may ask of a scenario's runs: metrics, ``end_time``, the audit's entries."""
    names = base.quantities
    end = Quantity("end_time", "s", "when the run ended")
    return {**names.metrics, "end_time": end,
            **{f"audit.{name}": q for name, q in names.audit.items()}}  # fmt: skip


def _text(
    raw: Mapping[str, Any], key: str, where: str, default: str, choices: tuple[str, ...] = ()
) -> str:
    field = Field(key, "", "text", choices=choices)
    return str(field.normalise(raw.get(key, default), where, key)).strip()


def _whole(
    raw: Mapping[str, Any], key: str, where: str, *, default: int | None, least: int, most: int
) -> int:
    value = raw.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
        raise ScenarioError(
            "is missing" if value is None else "is not permitted", where=where, key=key,
            value=value, permitted=f"a whole number, {least} to {most}",
        )  # fmt: skip
    return value


def _scenario(raw: Mapping[str, Any], where: str, folder: Path) -> tuple[Scenario, str]:
    if "scenario" not in raw:
        raise ScenarioError("is missing", where=where, key="scenario",
                            permitted="a scenario file, or a shipped name: "
                            + ", ".join(f.stem for f in library.files()))  # fmt: skip
    given = _text(raw, "scenario", where, "")
    beside = folder / given
    path = str(beside) if beside.is_file() else given
    with checks.naming(where, "scenario"):
        loaded = scenario.load(path)
    return loaded, path if Path(path).is_file() else given


def changes_of(given: Any, where: str) -> dict[str, Any]:
    """``[set]`` with nested tables as dotted keys."""
    if not isinstance(given, Mapping):
        raise ScenarioError("is not a table", where=where, key="set", value=given,
                            advice="write [set] with scenario keys below")  # fmt: skip
    result: dict[str, Any] = {}

    def collect(node: Mapping[str, Any], prefix: str) -> None:
        for key, value in node.items():
            if isinstance(value, Mapping):
                collect(value, f"{prefix}{key}.")
            else:
                result[prefix + key] = value

    collect(given, "")
    if "controller.law" in result:
        raise ScenarioError("is not fixed here", where=where, key="set.controller.law",
                            value=result["controller.law"],
                            advice="name the laws in controllers = [...]")  # fmt: skip
    return result


def _controllers(raw: Mapping[str, Any], base: Scenario, where: str) -> tuple[str, ...]:
    given = raw.get("controllers", [base.law])
    if not isinstance(given, list) or not given:
        raise ScenarioError("is not a list of laws", where=where, key="controllers", value=given,
                            permitted=", ".join(base.model.laws))  # fmt: skip
    field = Field("controllers", "", "text", choices=tuple(base.model.laws))
    names = [field.normalise(law, where, f"controllers[{k}]") for k, law in enumerate(given)]
    if len(set(names)) < len(names):
        raise ScenarioError("names a law twice", where=where, key="controllers", value=given)
    for k, name in enumerate(names):
        with checks.naming(where, f"controllers[{k}]"):
            base.with_law(name)
    return tuple(names)


def _count(raw: Mapping[str, Any], varied: tuple[Vary, ...], where: str) -> int:
    drawn = any(not v.crossed for v in varied)
    count = _whole(raw, "count", where, default=None if drawn else 1, least=1, most=2**40)
    if raw.get("method") == "latin_hypercube" and count > 10_000_000:
        raise ScenarioError("is too many for a Latin hypercube, which is made in one piece",
                            where=where, key="count", value=count, permitted="at most 10000000",
                            advice='use method = "sobol" or "random"')  # fmt: skip
    if raw.get("method") == "sobol" and count > 2**30:
        raise ScenarioError("is more than SciPy's Sobol sequence has", where=where, key="count",
                            value=count, permitted=f"at most {2**30}",
                            advice='use method = "random"')  # fmt: skip
    return count


def criteria(
    raw: Mapping[str, Any], base: Scenario, where: str, table: str = "success"
) -> list[Criterion]:
    """What the entries of a list of tables ask of a scenario's metrics.

    Raises:
        ScenarioError: for unknown metrics, and bounds between which nothing lies.
    """
    result = []
    for k, entry in enumerate(_tables(raw, table, where)):
        reader = Reader(entry, f"{table}[{k}]", where)
        reader.refuse_unknown(("metric", "below", "above"))
        metric = reader.text("metric")
        _known_quantity(metric, base, where, f"{table}[{k}].metric")
        if "below" not in entry and "above" not in entry:
            raise reader.fail("below", "is missing, and so is above", "a number for one or both")
        unit = quantities_of(base)[metric].unit
        below = reader.number("below", unit) if "below" in entry else math.inf
        above = reader.number("above", unit) if "above" in entry else -math.inf
        if above >= below:
            raise reader.fail("above", "is not less than below: nothing succeeds", f"< {below:g}")
        result.append(Criterion(metric, below, above, unit))
    return result


def _metrics(raw: Mapping[str, Any], base: Scenario, where: str) -> tuple[str, ...]:
    given = raw.get("metrics", list(base.model.study_metrics))
    if not isinstance(given, list) or not given:
        raise ScenarioError("is not a list of metrics", where=where, key="metrics", value=given,
                            permitted=", ".join(quantities_of(base)))  # fmt: skip
    for k, name in enumerate(given):
        _known_quantity(name, base, where, f"metrics[{k}]")
    return tuple(dict.fromkeys(given))


def _maps(
    raw: Mapping[str, Any], base: Scenario, varied: tuple[Vary, ...], where: str
) -> list[Map]:
    names = tuple(v.name for v in varied)
    result = []
    for k, entry in enumerate(_tables(raw, "map", where)):
        reader = Reader(entry, f"map[{k}]", where)
        reader.refuse_unknown(("x", "y", "show"))
        x, y = reader.text("x", choices=names), reader.text("y", choices=names)
        if x == y:
            raise reader.fail("y", "is the same as x", ", ".join(n for n in names if n != x))
        show = reader.text("show", default="success")
        if show != "success":
            _known_quantity(show, base, where, f"map[{k}].show", "success")
        result.append(Map(x, y, show))
    return result


def _tables(raw: Mapping[str, Any], key: str, where: str) -> list[Any]:
    given = raw.get(key, [])
    if not isinstance(given, list):
        raise ScenarioError("is not a list of tables", where=where, key=key,
                            advice=f"write [[{key}]]")  # fmt: skip
    return given


def _known_quantity(name: Any, base: Scenario, where: str, key: str, *others: str) -> None:
    known = (*others, *quantities_of(base))
    Field(key, "", "text", choices=known).normalise(name, where, key)
