"""How time and memory grow with the number of worlds: ``python benchmarks/growth.py``.

Each size runs in a process of its own, so that its peak memory is its own. The numbers go to
``docs/_static/growth.csv``, where docs/speed.md reads them too, and the plot beside them.
"""

from __future__ import annotations

import argparse
import csv
import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import multilift as ml
import numpy as np

TABLE = Path(__file__).parents[1] / "docs" / "_static" / "growth.csv"
COLUMNS = ("worlds", "seconds", "kernel_seconds", "peak_mib", "start_mib")


def one(worlds: int) -> dict[str, float]:
    """Time and memory of so many worlds of Sim 1, measured in this process."""
    scenario = ml.load("sim1")
    mass = np.random.default_rng(1).uniform(0.4, 1.2, worlds)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.perf_counter()
    batch = ml.simulate_batch(scenario, {"plant.bar_mass": mass})
    seconds = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return dict(
        zip(COLUMNS, (worlds, seconds, batch.kernel_seconds, peak / 1024, before / 1024),
            strict=True)
    )  # fmt: skip


def measure(most: int) -> list[dict[str, float]]:
    """Every power of ten up to `most`, each in its own process."""
    rows = []
    worlds = 1
    while worlds <= most:
        done = subprocess.run(
            [sys.executable, __file__, "--one", str(worlds)],
            check=True, capture_output=True, text=True,
        )  # fmt: skip
        rows.append(json.loads(done.stdout))
        print(line(rows[-1]), flush=True)
        worlds *= 10
    return rows


def line(row: dict[str, float]) -> str:
    """One size in words."""
    each = 1e6 * row["seconds"] / row["worlds"]
    return (
        f"{row['worlds']:>9,.0f} worlds: {row['seconds']:9.3f} s, {each:10,.0f} us a world, "
        f"peak {row['peak_mib']:6.0f} MiB, {row['start_mib']:4.0f} of these before the first"
    )


def plot(rows: list[dict[str, float]], file: Path) -> None:
    """Time and memory against worlds, beside what grows in proportion."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from multilift.plot import RC

    worlds = np.array([row["worlds"] for row in rows])
    panels = (
        ("wall time (s)", np.array([row["seconds"] for row in rows]), "in proportion"),
        ("peak memory (MiB)", np.array([row["peak_mib"] for row in rows]), "what it began with"),
    )
    with rc_context(RC):
        figure = Figure(figsize=(6.4, 2.6), layout="constrained")
        for ax, (label, values, guide) in zip(figure.subplots(1, 2), panels, strict=True):
            if guide == "in proportion":
                ax.plot(worlds, values[-1] * worlds / worlds[-1], color="0.6", ls="--", label=guide)
            else:
                ax.axhline(rows[0]["start_mib"], color="0.6", ls="--", label=guide)
            ax.plot(worlds, values, "o-", color="#0072B2", ms=4, label="measured")
            ax.set(xscale="log", yscale="log", xlabel="worlds", ylabel=label)
            ax.legend(frameon=False)
        figure.savefig(file, metadata={"Software": None})


def main() -> None:
    """Measures, prints, stores and draws."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=1_000_000, help="worlds of the greatest size")
    parser.add_argument("--one", type=int, help="measure this size here and print it as JSON")
    parser.add_argument("--table", type=Path, default=TABLE, help="where the numbers go")
    given = parser.parse_args()
    if given.one is not None:
        print(json.dumps(one(given.one)))
        return
    rows = measure(given.most)
    with given.table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: f"{v:.7g}" for k, v in row.items()} for row in rows)
    plot(rows, given.table.with_suffix(".png"))


if __name__ == "__main__":
    main()
