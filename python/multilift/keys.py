"""Dotted keys with indices, such as ``controller.k_d[0][1]`` or ``push[0].force[0]``."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from multilift import models, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.schema import Table

#: One step into a scenario: a name in a table, or a place in a list.
Step = str | int

_PART = re.compile(r"([^.\[\]]+)((?:\[\d+\])*)")


def parse(key: str, where: str = "key") -> tuple[Step, ...]:
    """The steps of a key: ``"push[0].force[1]"`` is ``("push", 0, "force", 1)``.

    Raises:
        ScenarioError: if the key is not well-formed.
    """
    steps: list[Step] = []
    for part in key.split("."):
        match = _PART.fullmatch(part)
        if match is None:
            raise ScenarioError(
                "is not a key",
                where=where,
                key=key,
                permitted="names joined by dots, with indices such as [0] behind them",
                advice="write it like plant.bar_mass, controller.k_d[0][1] or push[0].force[1]",
            )
        steps.append(match[1])
        steps += [int(k) for k in re.findall(r"\d+", match[2])]
    return tuple(steps)


def split_index(key: str) -> tuple[str, tuple[int, ...]]:
    """A key less the indices at its end, and those: ``("push[0].force", (1,))``."""
    base = re.sub(r"(\[\d+\])+$", "", key)
    return base, tuple(int(k) for k in re.findall(r"\d+", key[len(base) :]))


def has_index(key: str) -> bool:
    """Whether a key names one place of a list."""
    return "[" in key


def look_up(values: Any, key: str) -> Any:
    """The value at a key.

    Raises:
        KeyError: if there is none.
        ScenarioError: if the key is not well-formed.
    """
    node = values
    for step in parse(key):
        if not isinstance(node, Mapping if isinstance(step, str) else list):
            raise KeyError(key)
        container: Any = node
        try:
            node = container[step]
        except (KeyError, IndexError):
            raise KeyError(key) from None
    return node


def put(raw: dict[str, Any], complete: Mapping[str, Any], key: str, value: Any, where: str) -> None:
    """Sets one place of a list inside `raw`, which may say it shorter or leave it out.

    Args:
        raw: the tables as a file gives them; changed.
        complete: the same with defaults, every array in its full shape.
        key: with at least one index.
        value: for that place.
        where: for errors.

    Raises:
        ScenarioError: if there is no such place.
    """
    steps = parse(key, where)
    node: Any = raw
    full: Any = complete
    for k, step in enumerate(steps):
        if isinstance(step, str):
            if not isinstance(full, Mapping):
                raise _no_place(where, key, value, full)
            if step not in full:
                raise schema.unknown_key(where, key, value, full)
            if k == len(steps) - 1:
                node[step] = value
                return
            full = full[step]
            if _is_table(full):
                node = node.setdefault(step, {} if isinstance(full, Mapping) else deepcopy(full))
                continue
            node[step] = deepcopy(full)  # an array: written out, then changed at one place
            _put_in_array(node[step], steps[k + 1 :], key, value, where)
            return
        if not isinstance(full, list) or step >= len(full):
            raise _no_place(where, key, value, full)
        if k == len(steps) - 1:
            raise _no_place(where, key, value, full[step])
        node, full = node[step], full[step]


def field_of(key: str, values: Mapping[str, Any], where: str) -> Field:
    """The field that a key names in a complete scenario, indices checked against its shape.

    Args:
        key: dotted, with or without indices.
        values: complete, as ``Scenario.values``.
        where: for errors.

    Raises:
        ScenarioError: if there is no such key.
    """
    steps = parse(key, where)
    tables = models.of(values, where).tables_of(values, where)
    table, rest = find_table(steps, tables, values)
    fields = {f.name: f for f in table.fields} if table is not None else None
    if fields is None or not rest or rest[0] not in fields:
        try:
            look_up(values, key)
            known = _all_names(values, tables)
        except KeyError:
            known = list(fields) if fields is not None else _all_names(values, tables)
        raise schema.unknown_key(where, key, None, known)
    field = fields[str(rest[0])]
    shape = field.dims
    for step in rest[1:]:
        if not isinstance(step, int) or not shape or step >= shape[0]:
            raise _no_place(where, key, None, values)
        shape = shape[1:]
    return field


def find_table(
    steps: tuple[Step, ...], tables: Mapping[str, Table], values: Mapping[str, Any]
) -> tuple[Table | None, tuple[Step, ...]]:
    """The table in which a key lies, and the key's steps behind it.

    Args:
        steps: of the key; see `parse`.
        tables: of the scenario, as ``Model.tables_of`` gives them.
        values: complete; a repeated table must be there.

    Returns:
        None for the table if there is none.
    """
    names = list(itertools.takewhile(lambda step: isinstance(step, str), steps))
    for k in range(len(names), 0, -1):
        table = tables.get(".".join(map(str, names[:k])))
        if table is None:
            continue
        rest = steps[k:]
        if not table.repeated:
            return table, rest
        if rest and isinstance(rest[0], int) and rest[0] < len(values[table.name]):
            return table, rest[1:]
        return None, rest
    return None, steps


def _all_names(values: Mapping[str, Any], tables: Mapping[str, Table]) -> list[str]:
    return sorted(k for k in values if k in tables)


def _is_table(node: Any) -> bool:
    return isinstance(node, Mapping) or (
        isinstance(node, list) and bool(node) and isinstance(node[0], Mapping)
    )


def _put_in_array(array: Any, steps: tuple[Step, ...], key: str, value: Any, where: str) -> None:
    for k, step in enumerate(steps):
        if not isinstance(array, list) or not isinstance(step, int) or step >= len(array):
            raise _no_place(where, key, value, array)
        if k == len(steps) - 1:
            array[step] = value
        else:
            array = array[step]


def _no_place(where: str, key: str, value: Any, found: Any) -> ScenarioError:
    if isinstance(found, list):
        permitted = f"indices 0 to {len(found) - 1}" if found else "no index: there is none"
        advice = "count from 0"
    elif found is None:
        permitted, advice = "", "the scenario does not give this array: set all of it"
    else:
        permitted, advice = "", "drop the last index, or look the key's shape up"
    return ScenarioError(
        "names no place in the scenario",
        where=where,
        key=key,
        value=value,
        permitted=permitted,
        advice=advice,
    )
