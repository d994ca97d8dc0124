"""How the time of a step grows with the number of vehicles: ``python benchmarks/vehicles.py``.

Sizes are measured in turns, in processor time, on one thread. The numbers go to
``docs/_static/vehicles.csv``, where docs/speed.md reads them too, and the plot beside them.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np
from multilift import isa
from multilift.bench.ours import many_worlds, one_world
from multilift.bench.space import ring

TABLE = Path(__file__).parents[1] / "docs" / "_static" / "vehicles.csv"
COLUMNS = ("vehicles", "one", "lanes")
LEAST = 2
#: Many worlds need not fly long.
SHORT = {"simulation.duration": 2.0, "simulation.record_period": 2.0}


def measure(most: int, worlds: int, turns: int) -> list[dict[str, float]]:
    """The least ns a step of one world, alone and in lanes, for n doubling up to `most`."""
    sizes = [LEAST * 2**k for k in range((most // LEAST).bit_length())]
    each = {
        n: (one_world(ring(n)), many_worlds(ring(n).with_values(SHORT), worlds, isa.available()[0]))
        for n in sizes
    }
    times: dict[int, list[tuple[float, ...]]] = {n: [] for n in sizes}
    for _ in range(turns):
        for n, measures in each.items():
            times[n].append(tuple(m() for m in measures))
    return [dict(zip(COLUMNS, (n, *np.min(times[n], axis=0)), strict=True)) for n in sizes]


def exponent(rows: list[dict[str, float]], column: str) -> float:
    """Of the power of n that fits the times best."""
    slope, _ = np.polyfit(*(np.log([row[key] for row in rows]) for key in ("vehicles", column)), 1)
    return float(slope)


def plot(rows: list[dict[str, float]], file: Path) -> None:
    """Both times against n, with the straight lines through them."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from multilift.plot import RC

    n = np.array([row["vehicles"] for row in rows])
    with rc_context(RC):
        figure = Figure(figsize=(6.4, 2.6), layout="constrained")
        titles = {"one": "one world", "lanes": "in lanes, a world of the batch"}
        for ax, (column, title) in zip(figure.subplots(1, 2), titles.items(), strict=True):
            times = np.array([row[column] for row in rows]) / 1e3
            slope, start = np.polyfit(n, times, 1)
            ax.plot(n, start + slope * n, color="0.6", ls="--", label="straight line")
            ax.plot(n, times, "o", color="#0072B2", ms=4, label="measured")
            ax.set(xlabel="vehicles", ylabel="time a step (us)", title=title, ylim=(0, None))
            ax.legend(frameon=False)
        figure.savefig(file, metadata={"Software": None})


def main() -> None:
    """Measures, prints, stores and draws."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=64, help="vehicles of the greatest size")
    parser.add_argument("--worlds", type=int, default=32, help="in each batch")
    parser.add_argument("--turns", type=int, default=5, help="how often each size is measured")
    parser.add_argument("--table", type=Path, default=TABLE, help="where the numbers go")
    given = parser.parse_args()
    rows = measure(given.most, given.worlds, given.turns)
    for row in rows:
        print(
            f"{row['vehicles']:3.0f} vehicles: {row['one']:7,.0f} ns a step, "
            f"{row['lanes']:7,.0f} ns in lanes"
        )
    for column in COLUMNS[1:]:
        print(f"exponent of n, {column}: {exponent(rows, column):.3f}; goal: at most 1.1")
    with given.table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: f"{v:.6g}" for k, v in row.items()} for row in rows)
    plot(rows, given.table.with_suffix(".png"))


if __name__ == "__main__":
    main()
