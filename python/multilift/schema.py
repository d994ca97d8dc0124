"""The tables of a scenario file, made of fields.

Each model has its own (`multilift.models`); what is in all of them is here. The scenario reference
in the documentation is generated from the same tables.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilift.errors import ScenarioError
from multilift.fields import Field, did_you_mean, type_name


@dataclass(frozen=True)
class Table:
    """A table of a scenario, such as ``[plant]``: its fields in order and its meaning.

    Attributes:
        name: dotted where it lies in another table.
        repeated: given any number of times, as ``[[push]]``.
        follows: the table whose values are the defaults of this one's fields, if any.
    """

    name: str
    doc: str
    fields: tuple[Field, ...]
    repeated: bool = False
    follows: str = ""

    def field(self, name: str) -> Field:
        """The field of a name."""
        return next(f for f in self.fields if f.name == name)

    def resolved(self, sizes: Mapping[str, int]) -> Table:
        """The table with numbers for the names of sizes; see Field.resolved."""
        return replace(self, fields=tuple(f.resolved(sizes) for f in self.fields))

    def normalise(self, values: Any, where: str, prefix: str = "") -> dict[str, Any]:
        """Every field's value, given or default; see Field.normalise."""
        prefix = prefix or self.name
        values = _as_table(values, where, prefix)
        by_name = {f.name: f for f in self.fields}
        for key, value in values.items():
            if key not in by_name:
                raise unknown_key(where, f"{prefix}.{key}", value, by_name)
        result = {}
        for field in self.fields:
            if field.name in values:
                result[field.name] = field.normalise(
                    values[field.name], where, f"{prefix}.{field.name}"
                )
            elif field.required:
                raise ScenarioError(
                    "is missing",
                    where=where,
                    key=f"{prefix}.{field.name}",
                    permitted=field.permitted,
                    advice=f"add it to [{prefix}]: {field.doc}",
                )
            else:
                result[field.name] = field.default
        return result


def unknown_key(where: str, key: str, value: Any, known: Iterable[str]) -> ScenarioError:
    """The error for a key that no table has."""
    known = list(known)
    return ScenarioError(
        "is not a known key",
        where=where,
        key=key,
        value=value,
        permitted=", ".join(known),
        advice=did_you_mean(key.rsplit(".", 1)[-1], known) or "remove it",
    )


def _as_table(values: Any, where: str, prefix: str) -> Mapping[str, Any]:
    if not isinstance(values, Mapping):
        raise ScenarioError(
            f"is {type_name(values)}, not a table",
            where=where,
            key=prefix,
            value=values,
            advice=f"write it as [{prefix}] with keys below",
        )
    return values


def core_fields(table: Iterable[tuple[Any, ...]]) -> tuple[Field, ...]:
    """Fields as the compiled core describes them; the ones without defaults are required.

    Where a shape holds the name of a size, the defaults are one number, or those of the dimensions
    behind it: three of ("n", 3).
    """
    fields = []
    for name, unit, bound, shape, defaults, doc in table:
        names = [k for k, n in enumerate(shape) if isinstance(n, str)]
        known = tuple(shape[names[-1] + 1 :]) if names else tuple(shape)
        array = np.array(defaults).reshape(() if names and len(defaults) == 1 else known)
        required = bool(np.isnan(array).any())
        fields.append(
            Field(
                name,
                doc,
                shape=tuple(shape),
                unit=unit,
                range=bound,
                default=None if required else array.tolist(),
                required=required,
            )
        )
    return tuple(fields)


#: In every model's tables.
SIMULATION = Table(
    "simulation",
    "how the run is computed",
    (
        Field("duration", "simulated time", unit="s", range="positive", required=True),
        Field("step", "fixed step of the Runge-Kutta integrator of order 4", unit="s",
              range="positive", default=0.001),
        Field("record_period", "between two rows of the trajectory; a multiple of the step",
              unit="s", range="positive", default=0.01),
        Field("seed", "of the measurement noise; a whole number", range="non_negative",
              default=0.0),
    ),
)  # fmt: skip


def controller_fields(laws: tuple[str, ...]) -> tuple[Field, Field]:
    """What ``[controller]`` has under every law of a model."""
    return (
        Field("law", "which control law", "text", required=True, choices=laws),
        Field("rate", "how often the law is stepped; its command is held in between", unit="Hz",
              range="positive", default=1000.0),
    )  # fmt: skip


def flatten(table: Mapping[str, Any], fields: Iterable[Field]) -> list[float]:
    """The numbers of a normalised table, in the order in which the core unpacks them."""
    return [float(x) for f in fields for x in np.ravel(table[f.name])]
