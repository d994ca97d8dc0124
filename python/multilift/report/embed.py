"""The data behind the animation and the interactive curves, compact enough to carry along."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.packed import encoded, stride_of, thinned
from multilift.report.contents import PaperTest, RunView, View
from multilift.report.text import listed, ordinal
from multilift.styles import DESIRED_STYLE, law_styles


def _embedded(view: View) -> list[str]:
    """The columns to embed, where a run has them, in order."""
    shown = [panel["column"] for group in view.curves for panel in group["panels"]]
    return list(dict.fromkeys(["t", *view.traced, *shown, *view.animated]))


def _checked(test: PaperTest, run: RunView, view: View) -> dict[str, NDArray[np.float64]]:
    """The columns to embed; raises ValueError for a series that cannot be drawn."""
    where = f"test {test.key!r}, law {run.law!r}"
    absent = [name for name in view.animated if name not in run.series]
    if absent:
        raise ValueError(f"{where}: the series lacks {listed(absent)}")
    columns = {
        name: np.asarray(run.series[name], dtype=np.float64)
        for name in _embedded(view)
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


def _acts_as_commanded(columns: Mapping[str, NDArray[np.float64]], view: View) -> bool:
    for name, commanded in view.applied.items():
        command = columns.get(commanded)
        if name not in columns or command is None:
            continue
        if not np.array_equal(columns[name], command, equal_nan=True):
            return False
    return True


def _test_data(test: PaperTest, view: View, max_points: int) -> dict[str, Any]:
    checked = [_checked(test, run, view) for run in test.runs]
    if all(_acts_as_commanded(columns, view) for columns in checked):  # the same curves twice
        checked = [{k: v for k, v in c.items() if k not in view.applied} for c in checked]
    runs = []
    for run, columns in zip(test.runs, checked, strict=True):
        stride = stride_of(len(columns["t"]), max_points)
        runs.append(
            {
                "law": run.law,
                "title": run.title,
                "finished": run.status == "finished",
                "status": run.status_sentence,
                "columns": {
                    name: encoded(thinned(column, stride), run.status == "diverged")
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
        **{name: _range(bounded, columns) for name, columns in view.ranges.items()},
        "runs": runs,
    }


def page_data(tests: Sequence[PaperTest], view: View, max_points: int) -> dict[str, Any]:
    """Everything that the page's scripts draw.

    Args:
        tests: with their runs.
        view: what is shown of them.
        max_points: about how many records of each run.

    Raises:
        ValueError: A series cannot be drawn.
    """
    styles = law_styles([run.law for test in tests for run in test.runs])
    return {
        "styles": {name: asdict(style) for name, style in styles.items()},
        "desired": asdict(DESIRED_STYLE),
        "quantities": view.curves,
        "tests": [_test_data(test, view, max_points) for test in tests],
    }


def drawn_note(test: PaperTest, max_points: int) -> str:
    """Which records the animation and the curves of a test show."""
    strides = [stride_of(len(run.series["t"]), max_points) for run in test.runs]
    parts = []
    for stride in dict.fromkeys(strides):
        which = (
            "every record" if stride == 1 else f"every {ordinal(stride)} record and the last one"
        )
        who = [r.title for r, s in zip(test.runs, strides, strict=True) if s == stride]
        parts.append(which if len(who) == len(strides) else f"{which} of {listed(who)}")
    return f"Drawn at {' and '.join(parts)}, to six digits, straight lines between."
