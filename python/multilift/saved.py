"""Runs read back from the folders that `Run.save` writes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from multilift.errors import MissingExtraError, OutputError, ScenarioError
from multilift.run import Run
from multilift.scenario import load
from multilift.storage import MARKER


@dataclass(frozen=True)
class SavedLaw:
    """A law of which only the name is left."""

    name: str
    title: str


def read(folder: str | Path) -> Run:
    """The run that a folder holds, with trajectory, metrics and audit as they were saved.

    Args:
        folder: of `Run.save` or ``multilift run -o``.

    Raises:
        OutputError: if it is no such folder, or something in it is missing or damaged.
        MissingExtraError: without pyarrow (``multilift[data]``).
    """
    folder = Path(folder)
    try:
        import pyarrow as pa  # noqa: PLC0415
        import pyarrow.parquet as pq  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("pyarrow", "data", "reading a saved run") from None
    try:
        about = json.loads((folder / MARKER).read_text(encoding="utf-8"))
        scenario = load(folder / "scenario.toml")
        controller = about["controller"]
        kept = json.loads((folder / "metrics.json").read_text(encoding="utf-8"))
        kept = kept[about["scenario"]][controller]
        table = pq.read_table(folder / "trajectory.parquet")
        columns = {name: table[name].to_numpy() for name in table.column_names
                   if name != "controller"}  # fmt: skip
        laws = scenario.model.laws
        title = laws[controller].title if controller in laws else controller
        result = {
            "status": kept["status"],
            "culprit": about.get("culprit", -1),
            "end_time": kept["end_time"],
            "metrics": _numbers(kept["metrics"]),
            "audit": _numbers(kept["audit"]),
            "columns": {name: columns[name] for name in scenario.quantities.columns
                        if name in columns or name not in scenario.quantities.law_columns},
        }  # fmt: skip
        return scenario.model.run_type(scenario, SavedLaw(controller, title), result)
    except (OSError, ValueError, KeyError, TypeError, ScenarioError, pa.ArrowException) as error:
        raise OutputError(
            f"{folder} holds no run of multilift that can be read: {error!s}\n"
            "  what to do: give a folder that 'multilift run SCENARIO -o FOLDER' wrote"
        ) from None


def is_saved(folder: str | Path) -> bool:
    """Whether a folder looks like a saved run."""
    return (Path(folder) / MARKER).is_file()


def _numbers(given: dict[str, Any]) -> dict[str, float]:
    return {name: np.nan if value is None else float(value) for name, value in given.items()}
