"""What the numbers of a run are called, measured in and mean: columns, metrics, audit entries."""

from __future__ import annotations

from dataclasses import dataclass

from multilift import _core


@dataclass(frozen=True)
class Quantity:
    """One named number: unit and meaning come from the compiled core, where it is computed."""

    name: str
    unit: str
    doc: str


_TABLES = _core.planar_describe()

#: Columns of a trajectory, in order.
COLUMNS = {name: Quantity(name, unit, doc) for name, unit, doc in _TABLES["columns"]}
#: Metrics of a run, in order.
METRICS = {name: Quantity(name, unit, doc) for name, unit, doc in _TABLES["metrics"]}
#: Entries of the energy audit, in order.
AUDIT = {name: Quantity(name, unit, doc) for name, unit, doc in _TABLES["audit"]}

#: Columns that exist only where a law has a drag estimate and a storage function of its own.
LAW_COLUMNS = ("d_hat_y1", "d_hat_z1", "d_hat_y2", "d_hat_z2")
