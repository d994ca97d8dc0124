"""Shipped and own vehicles: TOML files whose numbers stand in where a scenario gives none."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from multilift import library
from multilift.errors import ScenarioError

#: What a vehicle file may hold: these tables, their keys as in a scenario.
_TABLES = ("plant", "vehicle", "autopilot", "limits")
_TEXTS = ("title", "source")


def names() -> list[str]:
    """The shipped vehicles."""
    return sorted(f.stem for f in library.folder("vehicles").glob("*.toml"))


def fill_in(raw: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """The tables with what the file of ``vehicle.type`` says where they say nothing.

    Raises:
        ScenarioError: for a type that is neither shipped nor a file, or a file with other tables.
    """
    vehicle = raw.get("vehicle", {})
    kind = vehicle.get("type", "") if isinstance(vehicle, Mapping) else ""
    if not isinstance(kind, str) or not kind:
        return raw
    filled = dict(deepcopy(raw))
    for name, table in _read(kind, where).items():
        given = filled.get(name, {})
        if isinstance(given, Mapping):
            filled[name] = {**table, **given}
    return filled


def _read(kind: str, where: str) -> dict[str, Any]:
    shipped = library.folder("vehicles") / f"{kind}.toml"
    file = shipped if shipped.is_file() else Path(where).parent / kind
    try:
        raw = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ScenarioError(
            f"names no vehicle: {error}",
            where=where,
            key="vehicle.type",
            value=kind,
            permitted=", ".join(names()) + ", or a TOML file beside the scenario",
        ) from None
    for name in raw:
        if name not in (*_TABLES, *_TEXTS):
            raise ScenarioError(
                "is not a table of a vehicle file",
                where=str(file),
                key=name,
                permitted=", ".join((*_TEXTS, *_TABLES)),
            )
    return {name: raw[name] for name in _TABLES if name in raw}
