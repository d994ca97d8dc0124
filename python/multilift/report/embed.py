"""The data behind the animation and the interactive curves, compact enough to carry along."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.report.contents import PaperTest, RunView
from multilift.report.text import listed, ordinal
from multilift.styles import DESIRED_STYLE, law_styles

_ANIMATED = ("t", "y1", "z1", "y2", "z2", "theta1", "theta2")
_APPLIED = ("u1_applied", "u2_applied", "u3_applied", "u4_applied")
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
_QUANTITIES: list[dict[str, Any]] = [
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
_EMBEDDED = (
    "t",
    "bar_y",
    "bar_z",
    *(panel["column"] for quantity in _QUANTITIES for panel in quantity["panels"]),
)


def _checked(test: PaperTest, run: RunView) -> dict[str, NDArray[np.float64]]:
    """The columns to embed; raises ValueError for a series that cannot be drawn."""
    where = f"test {test.key!r}, law {run.law!r}"
    absent = [name for name in _ANIMATED if name not in run.series]
    if absent:
        raise ValueError(f"{where}: the series lacks {listed(absent)}")
    columns = {
        name: np.asarray(run.series[name], dtype=np.float64)
        for name in dict.fromkeys(_EMBEDDED)
        if name in run.series
    }
    shape = columns["t"].shape
    if len(shape) != 1 or shape[0] < 1:
        raise ValueError(f"{where}: t must be one-dimensional and not empty")
    for name, column in columns.items():
        if column.shape != shape:
            raise ValueError(f"{where}: {name} has shape {column.shape}, t has {shape}")
    if not np.all(np.isfinite(columns["t"])) or np.any(np.diff(columns["t"]) < 0.0):
        raise ValueError(f"{where}: t must be finite and must not decrease")
    return columns


def _stride(records: int, max_points: int) -> int:
    return max(1, math.ceil((records - 1) / max_points))


def _decimated(column: NDArray[np.float64], stride: int) -> NDArray[np.float64]:
    """Every stride-th record and the last."""
    picked = column[::stride]
    return picked if (len(column) - 1) % stride == 0 else np.append(picked, column[-1])


def _encoded(column: NDArray[np.float64], diverged: bool) -> dict[str, Any]:
    """A column as compact JSON, to six digits of its largest value, or of each if it diverged.

    One of {"c": x, "n": count}, a constant; {"p": p, "d": [...]}, whole numbers of which the
    running sum over 10**p is the column; {"v": [...]}, the numbers themselves with null for what
    is not finite.
    """
    if np.all(column == column[0]) and math.isfinite(column[0]):
        return {"c": float(f"{column[0]:.6g}"), "n": len(column)}
    largest = float(np.max(np.abs(column)))  # NaN if there is one
    p = 5 - math.floor(math.log10(largest)) if math.isfinite(largest) else 0
    if diverged or not math.isfinite(largest) or abs(p) > 200:
        return {"v": [float(f"{x:.6g}") if math.isfinite(x) else None for x in column]}
    whole = np.rint(column * 10.0**p).astype(np.int64)
    return {"p": p, "d": np.diff(whole, prepend=0).tolist()}


def _range(runs: Sequence[Mapping[str, NDArray[np.float64]]], names: Sequence[str]) -> list[float]:
    """Least and greatest finite value of the named columns over runs; empty if there is none."""
    found = [run[name][np.isfinite(run[name])] for run in runs for name in names if name in run]
    found = [column for column in found if column.size]
    if not found:
        return []
    return [
        float(f"{min(float(c.min()) for c in found):.6g}"),
        float(f"{max(float(c.max()) for c in found):.6g}"),
    ]


def _acts_as_commanded(columns: Mapping[str, NDArray[np.float64]]) -> bool:
    for name in _APPLIED:
        command = columns.get(name.removesuffix("_applied"))
        if name not in columns or command is None:
            continue
        if not np.array_equal(columns[name], command, equal_nan=True):
            return False
    return True


def _test_data(test: PaperTest, max_points: int) -> dict[str, Any]:
    checked = [_checked(test, run) for run in test.runs]
    if all(_acts_as_commanded(columns) for columns in checked):  # the same curves twice
        checked = [{k: v for k, v in c.items() if k not in _APPLIED} for c in checked]
    runs = []
    for run, columns in zip(test.runs, checked, strict=True):
        stride = _stride(len(columns["t"]), max_points)
        runs.append(
            {
                "law": run.law,
                "title": run.title,
                "finished": run.status == "finished",
                "status": run.status_sentence,
                "columns": {
                    name: _encoded(_decimated(column, stride), run.status == "diverged")
                    for name, column in columns.items()
                },
            }
        )
    bounded = [c for r, c in zip(test.runs, checked, strict=True) if r.status != "diverged"]
    return {
        "key": test.key,
        "title": test.title,
        "short": test.short or test.title,
        "geometry": asdict(test.geometry),
        "start": [float(x) for x in test.start],
        "goal": [float(x) for x in test.goal],
        "pushes": [asdict(push) for push in test.pushes],
        "tension": _range(bounded, ("tension1", "tension2")),
        "thrust": _range(bounded, ("thrust1", "thrust2")),
        "runs": runs,
    }


def page_data(tests: Sequence[PaperTest], max_points: int) -> dict[str, Any]:
    """Everything that the page's scripts draw.

    Raises:
        ValueError: A series cannot be drawn.
    """
    styles = law_styles([run.law for test in tests for run in test.runs])
    return {
        "styles": {name: asdict(style) for name, style in styles.items()},
        "desired": asdict(DESIRED_STYLE),
        "quantities": _QUANTITIES,
        "tests": [_test_data(test, max_points) for test in tests],
    }


def drawn_note(test: PaperTest, max_points: int) -> str:
    """Which records the animation and the curves of a test show."""
    strides = [_stride(len(run.series["t"]), max_points) for run in test.runs]
    parts = []
    for stride in dict.fromkeys(strides):
        which = (
            "every record" if stride == 1 else f"every {ordinal(stride)} record and the last one"
        )
        who = [r.title for r, s in zip(test.runs, strides, strict=True) if s == stride]
        parts.append(which if len(who) == len(strides) else f"{which} of {listed(who)}")
    return f"Drawn at {' and '.join(parts)}, to six digits, straight lines between."
