"""What planning a move costs, and whether a hundred thousand random ones keep to their limits.

python benchmarks/planning.py
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from multilift import planning
from multilift.planning import Limits, Mode, Pendulum

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from random_moves import greatest, random_moves

LIMITS = Limits(2.0, 3.0, 20.0, 200.0)
PENDULUM = Pendulum(1.8, 9.8)


def spent(plan: Callable[[], object], repetitions: int = 2000) -> str:
    """Median and 99 % quantile of the time of one plan, from Python to Python."""
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        plan()
        times.append(time.perf_counter() - begin)
    return f"{1e6 * np.median(times):6.1f} us, 99 %: {1e6 * np.quantile(times, 0.99):6.1f} us"


def main() -> None:
    """Prints both."""
    start, goal = planning.state([0.0, 0.0]), [1.2, 0.3]
    way = planning.move(start, goal, LIMITS)
    swinging = planning.state([0.0, 0.0], [0.3, 0.1], [0.5, 0.0], [1.0, 0.0])
    lean = [np.sin(0.2), np.cos(0.2)]
    ei = planning.shaper("ei", Mode(2.33))
    plans = {
        "flat, from rest": lambda: planning.move(start, goal, LIMITS),
        "flat, from a swing": lambda: planning.move(swinging, goal, LIMITS),
        "flat, again on its way": lambda: planning.move(
            way.at(0.7), [1.3, 0.3], LIMITS, remaining=way.end - 0.7
        ),
        "flat, goal moves": lambda: planning.move(swinging, goal, LIMITS, goal_velocity=[0.3, 0.0]),
        "least snap": lambda: planning.least_snap_move([0.0, 0.0], goal, LIMITS),
        "EI": lambda: planning.shaped_move([0.0, 0.0], goal, LIMITS, ei, PENDULUM),
        "two parts, from a swing": lambda: planning.antiswing_move(
            [0.0, 0.0], [0.0, 0.0], lean, [0.1, 0.0], goal, LIMITS, 0.7, PENDULUM
        ),
    }
    for name, plan in plans.items():
        print(f"{name:24s} {spent(plan)}")
    for part in (0.0, 0.1, 0.5):
        moves = list(random_moves(34_000, 1, part))
        ways = [planning.move(s, g, limits, goal_velocity=v) for s, g, limits, v in moves]
        planned = [k for k, found in enumerate(ways) if found.pieces]
        allowed = np.array([moves[k][2].numbers for k in planned])
        over = (greatest([ways[k] for k in planned]) / allowed).max()
        print(
            f"starts with {part:g} of the limits: {len(planned)} of {len(moves)} planned, at most "
            f"{over:.9f} of a limit used"
        )


if __name__ == "__main__":
    main()
