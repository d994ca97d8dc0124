"""NMPC where it believes wrong numbers: the worlds of planning_bound.py, fewer of them.

python benchmarks/nmpc_robust.py TEST [WORLDS]

Payload and both cables are wrong by up to 25 %, commands late by 50 ms; the law knows the nominal
numbers and the delay. A flight takes seconds of one core: some tens of worlds are flown, and the
share that settles is given with its interval (Clopper, Pearson).
"""

from __future__ import annotations

import sys

import multilift as ml
import numpy as np
from multilift.controllers import PythonLaw
from multilift.limit.bound import law_force
from multilift.nmpc import Nmpc
from multilift.nmpc.law import PERIOD
from planning_bound import DELAY, IDEAL, wrong
from rich.progress import track
from scipy.stats import binomtest

DURATION = 8.0  # s; what is not settled by then counts as never


def flight(name: str, mass: float, length: float) -> tuple[float, float, int]:
    """Flies one world.

    Args:
        name: of the test.
        mass: factor of the payload's.
        length: factor of both cables'.

    Returns:
        Combined settling, s, infinite where it never does; farthest from the goal over the last
        second, m; plans that failed.
    """
    base = ml.load(name)
    assumed = {f"controller.assumed.{k}": base[f"plant.{k}"] for k in ("bar_mass", "cable_length")}
    scenario = base.with_values(
        {
            **IDEAL,
            **assumed,
            "actuators.command_delay": DELAY,
            "simulation.duration": DURATION,
            "plant.bar_mass": mass * base["plant.bar_mass"],
            "plant.cable_length": [length * x for x in base["plant.cable_length"]],
        }
    )
    nominal = base.with_values({**IDEAL, "simulation.duration": DURATION})
    made: list[Nmpc] = []

    def make(given: ml.Scenario) -> object:
        # The same limits of force in every world: those of the nominal move.
        made.append(Nmpc(given, force=law_force(nominal), lead=DELAY))
        return made[-1].step

    run = ml.simulate(scenario, PythonLaw("nmpc", "NMPC", make))
    late = run["t"] >= DURATION - 1.0
    goal = np.array(scenario["goal.vehicle_position"])
    off = max(
        np.hypot(run[f"y{i + 1}"][late] - y, run[f"z{i + 1}"][late] - z).max()
        for i, (y, z) in enumerate(goal)
    )
    settled = run.metrics["combined_settling"]
    failed = sum(not p.solved for p in made[0].plans)
    return (float(settled) if np.isfinite(settled) else np.inf), float(off), failed


def main() -> None:
    """Prints the quantile and how sure it is."""
    name, worlds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 40
    rows = [
        flight(name, *factors)
        for factors in track(wrong(np.random.default_rng(3), worlds), f"{name}, NMPC")
    ]
    settled, off, failed = np.array(rows).T
    middle, high = np.quantile(settled, [0.5, 0.95], method="higher")
    count = int(np.isfinite(settled).sum())
    plans = round(DURATION / PERIOD) * worlds
    share = binomtest(count, worlds).proportion_ci(0.95, "exact")
    print(f"{name}: {count} of {worlds} worlds settle in {DURATION:g} s, {100 * share.low:.0f} to "
          f"{100 * share.high:.0f} % of all (95 % confidence); median {middle:.2f} s, "
          f"95 % {high:.2f} s; off the goal at the end by "
          f"{np.median(off):.3f} m (median), {off.max():.3f} m at most; "
          f"{failed.sum():.0f} of about {plans} plans failed")  # fmt: skip


if __name__ == "__main__":
    main()
