"""The shipped tuned gains, made again, and the table of docs/tuning.md.

python benchmarks/tuned.py --folder out/tuned [--ship scenarios/tuned] [--part planar|space]

For each of the paper's tests and both laws: gains for the nominal test, and gains for worlds whose
load and cables are wrong and whose commands are late, each by the shipped tunings; then all gains
judged in both. An interrupted run goes on where it was. An hour on two cores.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import multilift as ml
from multilift import tune
from multilift.limit.bound import law_force
from multilift.tune import judge
from multilift.tune.run import TUNED, run

#: Time-optimal from rest to rest, s: multilift limit, docs/limit.md. That of Exp 2 is of the way
#: back from a push, and its settling counts from the end of the last one.
BOUND = {"sim1": 1.93, "sim2": 2.03, "exp1_1": 1.88, "exp1_2": 1.87, "exp2": 1.00}
LAST_PUSH_ENDS = {"exp2": 51.0, "exp2_quadrotors": 51.0}  # s
LAWS = ("energy_coupled", "pd")
#: Sets of gains over worlds; Exp 2 lasts so long that it gets fewer.
SETS = {"planar": 1536, "space": 512}
SETS_EXP2 = {"planar": 512, "space": 160}


def plain(scenario: ml.Scenario, robust: str) -> dict[str, Any]:
    """One flight of a scenario, and the 95 % quantile over worlds with wrong numbers."""
    side = judge.before(tune.load(robust, base=scenario))
    return {"nominal": side.run.metrics["combined_settling"],
            "quantile": side.judged["combined_settling"], "never": side.never,
            "peaks": list(side.peaks)}  # fmt: skip


def one(name: str, law: str, folder: Path, ship: Path | None) -> dict[str, Any]:
    """All three sets of gains of one test under one law."""
    scenario = ml.load(name).with_law(law)
    part = "planar" if scenario.model.name == "planar" else "space"
    suffix = "" if part == "planar" else "_space"
    settle, robust = f"settle{suffix}", f"settle{suffix}_robust"
    sets = (SETS_EXP2 if name.startswith("exp2") else SETS)[part]
    plans = {
        "tuned": tune.load(settle, base=scenario),
        "robust": tune.load(robust, base=scenario, budget=sets),
    }
    result: dict[str, Any] = {"paper": plain(scenario, robust)}
    for kind, plan in plans.items():
        where = folder / f"{name}_{law}_{kind}"
        run(plan, where)
        made = ml.load(where / TUNED)
        result[kind] = plain(made, robust)
        if ship is not None:
            ship.mkdir(parents=True, exist_ok=True)
            (ship / f"{made.name}.toml").write_text((where / TUNED).read_text())
    if part == "planar" and name != "exp2":
        result["force"] = list(law_force(ml.load(name)))
    return result


def main() -> None:
    """Prints the table and keeps the numbers as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("out/tuned"))
    parser.add_argument("--ship", type=Path)
    parser.add_argument("--part", choices=("planar", "space"), default=None)
    given = parser.parse_args()
    names = [*BOUND] if given.part != "space" else []
    if given.part != "planar":
        names += [f"{name}_quadrotors" for name in ("exp1_1", "exp1_2", "exp2")]
    kept: dict[str, Any] = {}
    for name in names:
        for law in LAWS:
            found = one(name, law, given.folder, given.ship)
            kept[f"{name} {law}"] = found
            print(line(name, law, found), flush=True)
            text = json.dumps(kept, indent=2)
            (given.folder / f"table_{given.part or 'all'}.json").write_text(text)


def line(name: str, law: str, found: dict[str, Any]) -> str:
    """A row of the table."""
    bound = BOUND[name.removesuffix("_quadrotors")]
    begun = LAST_PUSH_ENDS.get(name, 0.0)
    cells = [name, law]
    for kind in ("paper", "tuned", "robust"):
        for what in ("nominal", "quantile"):
            time = found[kind][what]
            cells.append(f"{time - begun:.2f} ({(time - begun) / bound:.2f})"
                         if math.isfinite(time) else "never")  # fmt: skip
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main()
