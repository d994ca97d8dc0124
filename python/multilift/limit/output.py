"""What `multilift limit` writes: the bound as JSON, CSV and figure, and its run to replay."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from multilift import provenance, storage
from multilift.errors import OutputError
from multilift.limit.bound import Bound
from multilift.run import Run, write_json

#: The file that says how long the move takes.
FILE = "bound.json"


def save(bound: Bound, target: Path, beside: Sequence[Run] = (), *, force: bool = False) -> Path:
    """Writes a bound into a new folder.

    Args:
        bound: what was found.
        target: folder to make; it appears only when complete.
        beside: runs of the same scenario under laws.
        force: replace an earlier result there.

    Returns:
        The folder, with ``bound.json``, ``bound.csv``, the check's run as `Run.save` writes it in
        ``run``, and, where matplotlib is installed, ``bound.png``.

    Raises:
        OutputError: if the folder is taken or cannot be written.
        MissingExtraError: without pyarrow (``multilift[data]``).
    """
    with storage.new_folder(target, force=force) as folder:
        write_json(folder / FILE, bound.to_json(beside))
        write_json(folder / storage.MARKER, {**provenance.describe(),
                                             "scenario": bound.scenario.name})  # fmt: skip
        _write_csv(bound.run, folder / "bound.csv")
        bound.run.save(folder / "run")
        from multilift.limit import figure  # noqa: PLC0415 - loads matplotlib

        figure.draw(bound, beside).savefig(folder / "bound.png")
    return target


def read_time(folder: str | Path, scenario: str) -> float:
    """How long a saved bound's move takes, s.

    Args:
        folder: that `save` or ``multilift limit -o`` wrote.
        scenario: name of the scenario that it must be of.

    Raises:
        OutputError: if it holds no time-optimal bound of this scenario.
    """
    file = Path(folder) / FILE
    try:
        kept: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        name, least, time = str(kept["scenario"]), str(kept["least"]), float(kept["time"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OutputError(
            f"{file} holds no bound that can be read: {error!s}\n"
            "  what to do: give a folder that 'multilift limit SCENARIO -o FOLDER' wrote"
        ) from None
    if name != scenario or least != "time":
        raise OutputError(
            f"{file} is of least {least} of {name}, not the time-optimal bound of {scenario}\n"
            f"  what to do: multilift limit {scenario} -o FOLDER"
        )
    return time


def _write_csv(run: Run, file: Path) -> None:
    names = [name for name in run.columns if not name.startswith(("power_", "storage"))]
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(names)
        writer.writerows(zip(*(run[name].tolist() for name in names), strict=True))
