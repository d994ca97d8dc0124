"""What the report's page shows of planar runs: the animation and the interactive curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from multilift.report.contents import View

_DEGREE = 180.0 / math.pi


def _panel(
    column: str,
    symbol: str,
    meaning: str,
    unit: str,
    *,
    side: int = 0,
    factor: float = 1.0,
    desired: str = "",
) -> dict[str, Any]:
    return {
        "column": column,
        "symbol": symbol,
        "meaning": meaning,
        "unit": unit,
        "side": side,
        "factor": factor,
        "desired": desired,
    }


def _per_vehicle(
    names: Sequence[tuple[str, str, str]], unit: str, *, goal: bool = False
) -> list[dict[str, Any]]:
    """Panels of vehicle 1, then as many of vehicle 2."""
    return [
        _panel(*name, unit, side=2 * k // len(names), desired=f"goal{k}" if goal else "")
        for k, name in enumerate(names)
    ]


def _angles(names: Sequence[tuple[str, str, str]], unit: str, desired: str) -> list[dict[str, Any]]:
    return [_panel(*name, unit, factor=_DEGREE, desired=desired) for name in names]


# What the interactive curves can show; `side` is the column of panels, one for each vehicle.
_CURVES: list[dict[str, Any]] = [
    {
        "name": "Positions",
        "panels": _per_vehicle(
            [
                ("y1", "y₁", "vehicle 1 to the right"),
                ("z1", "z₁", "vehicle 1 up"),
                ("y2", "y₂", "vehicle 2 to the right"),
                ("z2", "z₂", "vehicle 2 up"),
            ],
            "m",
            goal=True,
        ),
    },
    {
        "name": "Angles",
        "panels": _angles(
            [
                ("theta1", "θ₁", "cable 1"),
                ("theta2", "θ₂", "cable 2"),
                ("theta3", "θ₃", "bar"),
            ],
            "°",
            "zero",
        ),
    },
    {
        "name": "Velocities",
        "panels": _per_vehicle(
            [
                ("y1_dot", "dy₁/dt", "vehicle 1 to the right"),
                ("z1_dot", "dz₁/dt", "vehicle 1 up"),
                ("y2_dot", "dy₂/dt", "vehicle 2 to the right"),
                ("z2_dot", "dz₂/dt", "vehicle 2 up"),
            ],
            "m/s",
        ),
    },
    {
        "name": "Angle rates",
        "panels": _angles(
            [
                ("theta1_dot", "dθ₁/dt", "cable 1"),
                ("theta2_dot", "dθ₂/dt", "cable 2"),
                ("theta3_dot", "dθ₃/dt", "bar"),
            ],
            "°/s",
            "",
        ),
    },
    {
        "name": "Commands",
        "panels": _per_vehicle(
            [
                ("u1", "u₁", "vehicle 1 along y"),
                ("u2", "u₂", "vehicle 1 along z"),
                ("u3", "u₃", "vehicle 2 along y"),
                ("u4", "u₄", "vehicle 2 along z"),
            ],
            "N",
        ),
        "note": "As the law gave them; u₂ and u₄ come on top of the force that carries the weight.",
    },
    {
        "name": "Commands as they act",
        "panels": _per_vehicle(
            [
                ("u1_applied", "u₁", "as it acts on vehicle 1 along y"),
                ("u2_applied", "u₂", "as it acts on vehicle 1 along z"),
                ("u3_applied", "u₃", "as it acts on vehicle 2 along y"),
                ("u4_applied", "u₄", "as it acts on vehicle 2 along z"),
            ],
            "N",
        ),
        "note": "After the limits, delays and lags of the vehicles.",
    },
    {
        "name": "Thrust and tilt",
        "panels": [
            _panel("thrust1", "thrust", "vehicle 1", "N"),
            _panel("attitude1", "tilt", "vehicle 1", "°", factor=_DEGREE),
            _panel("thrust2", "thrust", "vehicle 2", "N", side=1),
            _panel("attitude2", "tilt", "vehicle 2", "°", side=1, factor=_DEGREE),
        ],
    },
    {
        "name": "Tensions",
        "panels": _per_vehicle(
            [("tension1", "tension", "cable 1"), ("tension2", "tension", "cable 2")], "N"
        ),
    },
    {
        "name": "Drag estimates",
        "panels": _per_vehicle(
            [
                ("d_hat_y1", "estimate along y", "vehicle 1"),
                ("d_hat_z1", "estimate along z", "vehicle 1"),
                ("d_hat_y2", "estimate along y", "vehicle 2"),
                ("d_hat_z2", "estimate along z", "vehicle 2"),
            ],
            "N s/m",
        ),
        "note": "The estimates need not approach the drag that acts.",
    },
    {
        "name": "Storage function",
        "panels": [_panel("storage", "storage function", "", "J")],
        "note": "Each law has its own storage function: compare its course with another law's, not "
        "its level.",
    },
]

VIEW = View(
    animated=("t", "y1", "z1", "y2", "z2", "theta1", "theta2"),
    traced=("bar_y", "bar_z"),
    curves=_CURVES,
    applied={f"u{k}_applied": f"u{k}" for k in (1, 2, 3, 4)},
    ranges={"tension": ("tension1", "tension2"), "thrust": ("thrust1", "thrust2")},
    player="player.js",
)
