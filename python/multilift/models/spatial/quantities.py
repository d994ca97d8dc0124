"""Columns, metrics and audit entries of a spatial run, as the compiled core describes them."""

from __future__ import annotations

from functools import cache

from multilift import _core
from multilift.quantities import Quantities, table

_AXES = ("x", "y", "z")


@cache
def quantities(n: int, quadrotors: bool) -> Quantities:
    """Those of runs with n vehicles, ideal ones or quadrotors."""
    tables = _core.spatial_describe(n, quadrotors)
    body = [f"{kind}_{axis}" for kind in ("payload",) for axis in _AXES]
    body += [f"payload_q{part}" for part in "wxyz"]
    body += [f"payload_v_{axis}" for axis in _AXES] + [f"payload_rate_{axis}" for axis in _AXES]
    vehicles = [
        f"vehicle{k}{kind}_{axis}" for k in range(1, n + 1) for kind in ("", "_v") for axis in _AXES
    ]
    return Quantities(
        columns=table(tables["columns"]),
        metrics=table(tables["metrics"]),
        audit=table(tables["audit"]),
        final_state=(*body, *vehicles),
        # Only where a law has a drag estimate of its own.
        law_columns=tuple(f"d_hat{k}_{axis}" for k in range(1, n + 1) for axis in _AXES),
    )
