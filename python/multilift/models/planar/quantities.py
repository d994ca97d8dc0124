"""Columns, metrics and audit entries of a planar run, as the compiled core describes them."""

from __future__ import annotations

from multilift import _core
from multilift.quantities import Quantities, Quantity, table

_TABLES = _core.planar_describe()

#: Columns of a trajectory, in order.
COLUMNS = table(_TABLES["columns"])
#: Metrics of a run, in order.
METRICS = table(_TABLES["metrics"])
#: Entries of the energy audit, in order.
AUDIT = table(_TABLES["audit"])

#: The numbers of a final state, in order.
FINAL_STATE = (
    "bar_y", "bar_z", "theta1", "theta2", "theta3",
    "bar_y_dot", "bar_z_dot", "theta1_dot", "theta2_dot", "theta3_dot",
)  # fmt: skip

QUANTITIES = Quantities(
    columns=COLUMNS,
    metrics=METRICS,
    audit=AUDIT,
    final_state=FINAL_STATE,
    residuals={
        "closure_residual": Quantity("closure_residual", "m", "largest drift of the closure")
    },
    # Only where a law has a drag estimate and a storage function of its own.
    law_columns=("d_hat_y1", "d_hat_z1", "d_hat_y2", "d_hat_z2"),
)
