"""How near planned moves come to the time-optimal ones under the same limits of force.

python benchmarks/planning_bound.py

The limit along each axis is the greatest force that the paper's law commands for the same move as a
step, all being ideal. For each kind of move this finds the shortest duration whose commands stay
within it, flown by the tracking law with the paper's gains, and the time after which every vehicle
stays within 0.02 m of its goal and every angle within 1 degree.
"""

from __future__ import annotations

import multilift as ml
import numpy as np
from multilift.models.planar.tables import ACTUATORS, SENSORS

#: Time-optimal from rest to rest under these limits, s, by collocation.
BOUND = {"sim1": 1.98, "sim2": 2.03, "exp1_1": 1.88, "exp1_2": 1.87}
IDEAL = {f"{t.name}.{f.name}": f.default for t in (ACTUATORS, SENSORS) for f in t.fields}


def settling(run: ml.Run) -> float:
    """Combined settling time, s."""
    goal = np.array(run.scenario["goal.vehicle_position"]).ravel()
    far = np.zeros(len(run["t"]), dtype=bool)
    for i in (1, 2):
        miss = np.hypot(run[f"y{i}"] - goal[2 * i - 2], run[f"z{i}"] - goal[2 * i - 1])
        far |= miss > 0.02
    for k in (1, 2, 3):
        far |= np.abs(np.degrees(run[f"theta{k}"])) > 1.0
    return float("nan") if far[-1] else float(run["t"][np.flatnonzero(far)[-1]])


def forces(run: ml.Run) -> np.ndarray:
    """Greatest commanded force along y and z, N."""
    return np.array([max(np.abs(run[a]).max(), np.abs(run[b]).max())
                     for a, b in (("u1", "u3"), ("u2", "u4"))])  # fmt: skip


def main() -> None:
    """Prints a line a test and kind."""
    for name, bound in BOUND.items():
        scenario = ml.load(name).with_values(IDEAL)
        step = ml.simulate(scenario)
        limit = forces(step)
        print(f"{name}: bound {bound:.2f} s, the law to a step {settling(step):.2f} s, "
              f"forces {limit[0]:.2f}, {limit[1]:.2f} N")  # fmt: skip
        for kind in ("flat", "least_snap"):
            low, high = 1.0, 6.0
            while high - low > 1e-3:
                middle = 0.5 * (low + high)
                run = ml.simulate(scenario.with_values(
                    {"reference.kind": kind, "reference.duration": middle,
                     "simulation.duration": 8.0}
                ))  # fmt: skip
                if (forces(run) <= limit).all():
                    high, best = middle, run
                else:
                    low = middle
            late = best["t"] >= high
            swing = max(np.abs(best[f"theta{k}"][late]).max() for k in (1, 2))
            time = settling(best)
            print(f"  {kind:10s} {high:.2f} s long, settles at {time:.2f} s, "
                  f"{time / bound:.2f} times the bound, then swings "
                  f"{np.degrees(swing):.2f} deg")  # fmt: skip


if __name__ == "__main__":
    main()
