"""What derivatives and stepping cost, against the plain simulation of the same scenario.

python benchmarks/gradient.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import multilift as ml
import numpy as np

KEYS = [
    "plant.bar_mass", "plant.vehicle_mass[0]", "plant.vehicle_mass[1]", "plant.cable_length[0]",
    "plant.cable_length[1]", "plant.bar_half_thickness", "controller.k_lambda",
    "controller.k_p[0][0]", "controller.k_p[0][1]", "controller.k_d[0][0]", "controller.k_d[0][1]",
    "controller.gamma[0][0]", "plant.gravity", "plant.swing_damping[0]", "goal.vehicle_position",
    "start.vehicle_position[0][0]",
]  # fmt: skip


def fastest(action: Callable[[], object], repetitions: int = 5) -> float:
    """The least time of some, s."""
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        action()
        times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    """Prints both costs as ratios."""
    scenario = ml.load("sim1").with_values({"simulation.record_period": 15.0})
    plain = fastest(lambda: ml.simulate(scenario))
    print(f"plain run of {scenario['simulation.duration']:g} s: {1e3 * plain:.2f} ms")
    for count in (1, 8, 16):
        spent = fastest(lambda count=count: ml.gradient(scenario, KEYS[:count]))
        print(
            f"{count:2d} keys: {spent / plain:5.1f} plain runs, {spent / plain / count:.2f} per key"
        )
    for count in (1, 64, 4096):
        worlds = ml.Worlds(scenario, count=count, threads=1)
        u = np.zeros((count, 4))
        spent = fastest(lambda worlds=worlds, u=u: worlds.step(u), 200)
        print(f"one step of {count} worlds, one thread: {1e9 * spent / count:.0f} ns per world")


if __name__ == "__main__":
    main()
