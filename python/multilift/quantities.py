"""What the numbers of a run are called, measured in and mean: columns, metrics, audit entries.

Each model has its own: ``scenario.quantities`` and ``run.quantities``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Quantity:
    """One named number: unit and meaning come from the compiled core, where it is computed."""

    name: str
    unit: str
    doc: str


@dataclass(frozen=True)
class Quantities:
    """The numbers of a run by name, in order.

    Attributes:
        columns: of a trajectory; "t" is the first.
        metrics: of the whole run.
        audit: entries of the energy audit.
        final_state: names of the numbers of a batch's final state.
        residuals: by how much a run misses what must hold exactly.
        law_columns: columns that only compiled laws have.
    """

    columns: Mapping[str, Quantity]
    metrics: Mapping[str, Quantity]
    audit: Mapping[str, Quantity]
    final_state: tuple[str, ...]
    residuals: Mapping[str, Quantity] = field(default_factory=dict)
    law_columns: tuple[str, ...] = ()


def table(entries: Iterable[tuple[str, str, str]]) -> dict[str, Quantity]:
    """Quantities by name, from name, unit and meaning as the compiled core describes them."""
    return {name: Quantity(name, unit, doc) for name, unit, doc in entries}
