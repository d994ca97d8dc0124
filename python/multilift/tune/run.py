"""Running a tuning: from its tables to the tuned scenario, the report and what checks it."""

from __future__ import annotations

import csv
import json
import math
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from multilift import provenance, toml_text
from multilift.errors import OutputError
from multilift.run import finite
from multilift.storage import LOCK, as_output_error, held, write_whole
from multilift.study.vary import Vary
from multilift.tune import judge
from multilift.tune.judge import Side, Slice
from multilift.tune.search import FILE, Found, search
from multilift.tune.spec import Tuning

#: Says whose the folder is, and what is being tuned there.
MANIFEST = "tuning.json"
TUNED, CHECK, REPORT, RESULT = "tuned.toml", "check.toml", "report.html", "result.json"
_FIGURES = "figures"

#: Another version or machine may round differently, and so choose other sets.
_SAME = ("multilift", "compiler", "machine", "isa")


@dataclass(frozen=True)
class Result:
    """A finished tuning.

    Attributes:
        folder: where everything lies.
        found: every set that was flown.
        before, after: the scenario's own numbers and the best, judged.
        slices: the sensitivity, one number each.
        check: the command that flies the tuned scenario again.
        least_time: of the move's bound, s; None if none was given.
    """

    folder: Path
    found: Found
    before: Side
    after: Side
    slices: list[Slice]
    check: str
    least_time: float | None

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / REPORT

    def to_json(self) -> dict[str, Any]:
        """The numbers of the report; what has no value is null."""
        tuning = self.found.tuning
        goal = tuning.goal
        numbers: dict[str, Any] = {
            "scenario": tuning.scenario.name,
            "controller": tuning.scenario.law,
            "statistic": goal.statistic if tuning.over is not None else "nominal",
            "quantile": goal.quantile if goal.statistic == "quantile" else None,
            "worlds": tuning.worlds,
            "sets": len(self.found.points),
            "seed": tuning.seed,
            "least_time": self.least_time,
            "before": _side(self.before),
            "after": _side(self.after),
            "sensitivity": [
                {"name": s.name, "numbers": s.numbers.tolist(), "values": s.values.tolist(),
                 "low": s.low, "high": s.high} for s in self.slices
            ],
            "check": self.check,
            "made_by": provenance.describe(),
        }  # fmt: skip
        if goal.combine == "front":
            numbers["front"] = [
                {**self.found.numbers(int(k)), **self.found.values(int(k))}
                for k in self.found.front()
            ]
        return dict(finite(numbers))


def run(
    tuning: Tuning,
    folder: str | Path,
    *,
    threads: int | None = None,
    force: bool = False,
    least_time: float | None = None,
    progress: Callable[[Found], None] | None = None,
) -> Result:
    """Tunes, or goes on with a tuning that was interrupted.

    Args:
        tuning: from `load` or `parse`.
        folder: for the tuned scenario, report and generations; made if it is not there.
        threads: of the batch engine; its own choice if None.
        force: remove an earlier result there.
        least_time: of the time-optimal move, s; settling is then shown as its multiple.
        progress: called after each generation.

    Raises:
        MissingExtraError: without cma or matplotlib.
        OutputError: if the folder cannot be used or written.
        ScenarioError: if the scenario does not permit a set of numbers.
    """
    from multilift.tune import figures, page  # noqa: PLC0415 - loads the plotting packages

    folder = Path(folder)
    check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with held(folder):
            _begin(folder, tuning, force=force)
            before = judge.before(tuning, threads)
            found = search(tuning, folder / FILE, threads=threads, progress=progress)
            after = judge.after(found, threads)
            slices = judge.sensitivity(found, threads)
            write_whole(folder / TUNED, toml_text.document(after.scenario.raw()).encode())
            result = Result(folder, found, before, after, slices,
                            _write_check(folder, tuning), least_time)  # fmt: skip
            if tuning.goal.combine == "front":
                _write_front(folder, found)
            (folder / _FIGURES).mkdir(exist_ok=True)
            drawings = {
                "flights": figures.png(figures.flights(before, after)),
                "progress": figures.png(figures.progress(found)),
                "sensitivity": figures.png(figures.slices(found, slices)),
            }
            if tuning.goal.combine == "front" and len(found.front()):
                drawings["front"] = figures.png(figures.front(found))
            for name, content in drawings.items():
                write_whole(folder / _FIGURES / f"{name}.png", content)
            text = json.dumps(result.to_json(), indent=2) + "\n"
            write_whole(folder / RESULT, text.encode())
            write_whole(folder / REPORT, page.render(result, drawings).encode())
            return result
    except OSError as error:
        raise as_output_error(error, folder) from error


def check_folder(folder: Path) -> None:
    """Refuses a folder that is not ours before any work is done.

    Raises:
        OutputError: if it is a file, or holds something that no tuning left there.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder} is a file, not a folder\n  what to do: choose another")
    if folder.exists() and not (folder / MANIFEST).is_file():
        left = [f.name for f in folder.iterdir()
                if f.name != LOCK and not f.name.startswith(".tmp-")]  # fmt: skip
        if left:
            raise OutputError(
                f"{folder} is not empty and holds no tuning, so it is not touched\n"
                "  what to do: choose another folder"
            )


def _begin(folder: Path, tuning: Tuning, *, force: bool) -> None:
    """Writes the manifest, or compares it with what is to be tuned."""
    file = folder / MANIFEST
    if force:
        for name in (FILE, TUNED, CHECK, REPORT, RESULT, MANIFEST):
            (folder / name).unlink(missing_ok=True)
    made_by = {k: v for k, v in provenance.describe().items() if k in _SAME}
    manifest = {"scenario": tuning.scenario.name, "controller": tuning.scenario.law,
                "digest": tuning.digest(), "made_by": made_by}  # fmt: skip
    if not file.is_file():
        write_whole(file, (json.dumps(manifest, indent=2) + "\n").encode())
        return
    advice = "\n  what to do: choose another folder, or replace what is there with --force"
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
        digest, before = kept["digest"], kept["made_by"]
    except (OSError, ValueError, KeyError, TypeError):
        raise OutputError(f"{file} cannot be read{advice}") from None
    if digest != manifest["digest"]:
        raise OutputError(
            f"{folder} holds another tuning, begun with another scenario, variables, goal, budget "
            f"or seed{advice}"
        )
    if before != made_by:
        changed = [k for k in _SAME if before.get(k) != made_by.get(k)]
        raise OutputError(
            f"{folder} was begun by another multilift or machine (other {', '.join(changed)}), "
            f"whose numbers may differ in their last bits{advice}"
        )


def _write_check(folder: Path, tuning: Tuning) -> str:
    """What flies the tuned scenario again; over draws, a study of fresh ones."""
    over = judge.fresh(tuning.over)
    if over is None:
        return shlex.join(["multilift", "run", str(folder / TUNED)])
    goal = tuning.goal
    study = {
        "schema": 1,
        "title": f"{tuning.scenario.title}, tuned, in worlds that tuning has not seen",
        "scenario": TUNED,
        "controllers": [tuning.scenario.law],
        "count": over.count,
        "seed": over.seed,
        "method": over.method,
        "metrics": [o.metric for o in goal.objectives],
        "set": over.changes,
        "vary": [_table(v) for v in over.vary],
        "success": [
            {"metric": c.metric, **{name: x for name in ("below", "above")
                                    if math.isfinite(x := getattr(c, name))}}
            for c in goal.constraints
        ]
        or [{"metric": goal.objectives[0].metric, "above": -1e300}],
    }  # fmt: skip
    write_whole(folder / CHECK, toml_text.document(study).encode())
    parts = ["multilift", "study", str(folder / CHECK), "-o", str(folder / "check")]
    return shlex.join(parts)


def _table(v: Vary) -> dict[str, Any]:
    """A varied number as a study's file has it."""
    unit = f" ({v.unit})"
    label = v.label.removesuffix(unit) if v.unit else v.label
    table: dict[str, Any] = {
        "key": [{"key": t.key, "factor": t.factor, "offset": t.offset} for t in v.targets],
        "name": v.name, "label": label, "unit": v.unit, "apply": v.apply,
    }  # fmt: skip
    if v.crossed:
        return {**table, "distribution": "list", "values": list(v.values)}
    table["distribution"] = v.distribution
    if v.distribution == "normal":
        table |= {"mean": v.mean, "std": v.std}
    return table | {k: x for k in ("low", "high") if math.isfinite(x := getattr(v, k))}


def _write_front(folder: Path, found: Found) -> None:
    rows = [{**found.numbers(int(k)), **found.values(int(k))} for k in found.front()]
    if not rows:
        return
    with (folder / "front.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def _side(side: Side) -> dict[str, Any]:
    kept = {k: v for k, v in vars(side).items() if k not in ("scenario", "run")}
    return {**kept, "metrics": side.run.metrics, "status": side.run.status}
