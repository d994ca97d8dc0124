"""From a scenario's tables as given to complete ones, and what they must satisfy in every model.

Every function raises ScenarioError with file, key, value, permitted range and what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from multilift import keys, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.models import Model
from multilift.schema import Table

SCHEMA_VERSION = 1

#: Bounds of a single run: days of computing, and gigabytes of rows.
MOST_STEPS = 1e10
MOST_ROWS = 1e7

_TEXTS = ("name", "title", "source", "description")


def normalise(model: Model, raw: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Every table complete with defaults, each value in SI; unknown keys refused."""
    raw = model.given(raw, where)
    once = {n: t for n, t in model.tables.items() if not t.repeated and "." not in n}
    repeated = {n: t for n, t in model.tables.items() if t.repeated}
    known = ("schema", *_TEXTS, *once, "controller", *repeated)
    for key, value in raw.items():
        if key not in known:
            raise schema.unknown_key(where, key, value, known)
    version = raw.get("schema", SCHEMA_VERSION)
    if version != SCHEMA_VERSION or isinstance(version, bool):
        raise ScenarioError(
            "is not a version this multilift reads",
            where=where,
            key="schema",
            value=raw["schema"],
            permitted=str(SCHEMA_VERSION),
        )
    values: dict[str, Any] = {}
    for key in _TEXTS:
        text = Field(key, "", "text").normalise(raw.get(key, ""), where, key)
        values[key] = text.strip()
    values["name"] = values["name"] or "scenario"
    values["title"] = values["title"] or values["name"]
    sizes = model.sizes(raw, where)
    tables = {name: table.resolved(sizes) for name, table in model.tables.items()}
    for key in once:
        values[key] = _complete(key, tables, raw.get(key, {}), values, where)
    given = raw.get("controller", {})
    tables["controller"] = model.controller_table(_law(model, given, where)).resolved(sizes)
    values["controller"] = _complete("controller", tables, given, values, where)
    for key in repeated:
        values[key] = _entries(tables[key], raw.get(key, []), where)
    return values


def _law(model: Model, controller: Any, where: str) -> str:
    if not isinstance(controller, Mapping) or "law" not in controller:
        raise ScenarioError(
            "is missing",
            where=where,
            key="controller.law",
            permitted=", ".join(model.laws),
            advice="add [controller] with law and its gains",
        )
    choice = schema.controller_fields(tuple(model.laws))[0]
    return str(choice.normalise(controller["law"], where, "controller.law"))


def _complete(
    name: str, tables: Mapping[str, Table], given: Any, values: Mapping[str, Any], where: str
) -> dict[str, Any]:
    """A table with the ones inside it, from what is given and from the one that it follows."""
    table = tables[name]
    if not isinstance(given, Mapping):
        return table.normalise(given, where)
    if table.follows:
        given = {**values[table.follows], **given}
    inside = {n.rpartition(".")[2]: n for n in tables if n.rpartition(".")[0] == name}
    result = table.normalise({k: v for k, v in given.items() if k not in inside}, where)
    for key, inner in inside.items():
        result[key] = _complete(inner, tables, given.get(key, {}), values, where)
    return result


def _entries(table: Table, given: Any, where: str) -> list[dict[str, Any]]:
    if not isinstance(given, list):
        raise ScenarioError(
            "is not a list of tables", where=where, key=table.name, advice=f"write [[{table.name}]]"
        )
    return [table.normalise(v, where, prefix=f"{table.name}[{k}]") for k, v in enumerate(given)]


def check_timing(model: Model, values: dict[str, Any], where: str) -> dict[str, int]:
    """Refuses times that are no whole number of integration steps, and seeds that are no number.

    Returns:
        How many steps the control period and each of the model's delays take, by key.
    """
    step = float(values["simulation"]["step"])

    def multiple(key: str, time: float, zero_allowed: bool) -> int:
        ratio = time / step
        if not ratio <= MOST_STEPS:
            raise ScenarioError(
                f"takes {ratio:.3g} integration steps",
                where=where,
                key=key,
                value=time,
                permitted=f"at most {MOST_STEPS:.0g} steps of {step:g} s",
                advice="change it or simulation.step",
            )
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

    steps = multiple("simulation.duration", values["simulation"]["duration"], False)
    record = multiple("simulation.record_period", values["simulation"]["record_period"], False)
    if steps / record > MOST_ROWS:
        raise ScenarioError(
            f"keeps {steps / record:.3g} rows",
            where=where,
            key="simulation.record_period",
            value=values["simulation"]["record_period"],
            permitted=f"at most {MOST_ROWS:.0g} rows",
        )
    control = multiple("1 / controller.rate", 1.0 / values["controller"]["rate"], False)
    counts = {"controller.rate": control}
    for key in model.delays:
        counts[key] = multiple(key, keys.look_up(values, key), True)
    seed = values["simulation"]["seed"]
    if seed != int(seed) or seed >= 2**53:
        raise ScenarioError(
            "is not a whole number below 2^53", where=where, key="simulation.seed", value=seed
        )
    values["simulation"]["seed"] = int(seed)
    return counts
