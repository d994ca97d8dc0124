"""How near planned moves come to the time-optimal ones, and how near with wrong numbers.

python benchmarks/planning_bound.py

Nominally all is ideal, and the limit along each axis is the greatest force that the paper's law
commands for the same move as a step, as for the bound. A flat move of each duration and gains drawn
at random are flown; of those within the limit, and with less than 0.5 degree of swing after the
move, the soonest settled counts: with drag and swing damping counted in the
way's forces, and without.

Then payload and cables are wrong by up to 25 % each and commands are late by 50 ms. Laws know the
nominal numbers, and plans the delay. Laws with and without a plan are tuned by the same draws of
gains for the least 95 % quantile of combined settling over some worlds, and judged over others.
Forces are not limited there.
"""

from __future__ import annotations

from typing import Any

import multilift as ml
import numpy as np
from multilift.models.planar.tables import ACTUATORS, SENSORS

#: Time-optimal from rest to rest, s: multilift limit, docs/limit.md.
BOUND = {"sim1": 1.93, "sim2": 2.03, "exp1_1": 1.88, "exp1_2": 1.87}
IDEAL = {f"{t.name}.{f.name}": f.default for t in (ACTUATORS, SENSORS) for f in t.fields}
DELAY = 0.05  # s
GAINS, WORLDS, JUDGED = 160, 48, 1000
#: Gains of the law: each row scales K_p and K_d and gives k_lambda, kg, and K_i, N/(m s).
Gains = np.ndarray


def forces(run: ml.Run) -> np.ndarray:
    """Greatest commanded force along y and z, N."""
    return np.array([max(np.abs(run[a]).max(), np.abs(run[b]).max())
                     for a, b in (("u1", "u3"), ("u2", "u4"))])  # fmt: skip


def drawn(rng: np.random.Generator, count: int, scenario: ml.Scenario) -> Gains:
    """The paper's gains and others at random around them."""
    first = [[1.0, 1.0, scenario["controller.k_lambda"], 0.0]]
    others = rng.uniform([-1.6, -1.2, -3.0, -1.0], [0.5, 0.7, 0.0, 1.2], (count - 1, 4))
    return np.vstack([first, np.exp(others)])


def columns(scenario: ml.Scenario, gains: Gains) -> dict[str, np.ndarray]:
    """Overrides with a world for each row."""
    result = {"controller.k_lambda": gains[:, 2], "controller.k_i": gains[:, 3]}
    for column, key in enumerate(("controller.k_p", "controller.k_d")):
        for (i, j), value in np.ndenumerate(np.array(scenario[key])):
            result[f"{key}[{i}][{j}]"] = gains[:, column] * value
    return result


def nominal(name: str, rng: np.random.Generator, *, damping: bool) -> tuple[float, str]:
    """The best move's duration, and a line about it."""
    scenario = ml.load(name).with_values({**IDEAL, "simulation.duration": 8.0})
    limit = forces(ml.simulate(scenario))
    best: tuple[float, float, str] = (np.inf, np.inf, "")
    for duration in np.arange(1.9, 3.0, 0.02):
        flat = scenario.with_values(
            {
                "reference.kind": "flat",
                "reference.duration": float(duration),
                "reference.lead": 0.005,
                "reference.damping": damping,
            }
        )
        # The forces that the way takes leave a law with any gains little room: a few draws do.
        for scale_p, scale_d, k_lambda, _ in drawn(rng, 8, scenario):
            law = {"controller.k_p": (scale_p * np.array(scenario["controller.k_p"])).tolist(),
                   "controller.k_d": (scale_d * np.array(scenario["controller.k_d"])).tolist(),
                   "controller.k_lambda": float(k_lambda)}  # fmt: skip
            run = ml.simulate(flat.with_values(law))
            late = run["t"] >= duration
            swing = np.degrees(max(np.abs(run[f"theta{k}"][late]).max() for k in (1, 2)))
            settled = run.metrics["combined_settling"]
            if (forces(run) <= limit).all() and swing < 0.5 and settled < best[0]:
                best = (settled, float(duration),
                        f"flat, {duration:.2f} s, settles at {settled:.2f} s = "
                        f"{settled / BOUND[name]:.2f} bounds, then swings {swing:.2f} deg; K_p x "
                        f"{scale_p:.2f}, K_d x {scale_d:.2f}, k_lambda {k_lambda:.2f}")  # fmt: skip
        if duration > best[1] + 0.2:
            break
    return best[1], best[2]


def wrong(rng: np.random.Generator, count: int) -> np.ndarray:
    """Factors of the payload's mass and of both cables' length."""
    return rng.uniform(0.75, 1.25, (count, 2))


def settled(scenario: ml.Scenario, gains: Gains, factors: np.ndarray) -> np.ndarray:
    """Combined settling of each row of gains in each world, s; infinite where it never does."""
    every = np.repeat(gains, len(factors), axis=0)
    each = np.tile(factors, (len(gains), 1))
    mass, lengths = scenario["plant.bar_mass"], scenario["plant.cable_length"]
    overrides = columns(scenario, every)
    overrides["plant.bar_mass"] = mass * each[:, 0]
    overrides["controller.assumed.bar_mass"] = np.full(len(each), mass)
    for i, length in enumerate(lengths):
        overrides[f"plant.cable_length[{i}]"] = length * each[:, 1]
        overrides[f"controller.assumed.cable_length[{i}]"] = np.full(len(each), length)
    batch = ml.simulate_batch(scenario, overrides)
    time = np.nan_to_num(batch.metrics["combined_settling"], nan=np.inf)
    return time.reshape(len(gains), len(factors))


def robust(name: str, duration: float, rng: np.random.Generator) -> None:
    """Prints a line a contestant."""
    base = ml.load(name).with_values(
        {**IDEAL, "actuators.command_delay": DELAY, "simulation.duration": 15.0}
    )
    slow, fast = 1.25 * duration, duration
    size = float(np.linalg.norm(np.subtract(base["goal.vehicle_position"][0],
                                            base["start.vehicle_position"][0])))  # fmt: skip
    ahead = {"reference.lead": DELAY + 0.005}

    def within(time: float) -> dict[str, float]:
        # Those of a flat move that takes this time.
        return {"reference.speed_max": 2.461 * size / time,
                "reference.acceleration_max": 9.372 * size / time**2,
                "reference.jerk_max": 78.75 * size / time**3}  # fmt: skip

    ways: dict[str, list[dict[str, Any]]] = {
        "step": [{}],
        "flat": [{"reference.kind": "flat", "reference.duration": t, **ahead}
                 for t in (fast, slow)],
        "ei": [{"reference.kind": "ei", **ahead, **within(t)} for t in (0.6 * fast, fast)],
        "antiswing": [{"reference.kind": "antiswing", **ahead, **within(t)}
                      for t in (fast, slow)],
    }  # fmt: skip
    gains = drawn(rng, GAINS, base)
    train, test = wrong(rng, WORLDS), wrong(rng, JUDGED)
    for law in ("pd", "energy_coupled"):
        # With k_lambda = 0 the law is PD.
        tried = gains * [1.0, 1.0, 0.0 if law == "pd" else 1.0, 1.0]
        for kind, choices in ways.items():
            found: tuple[float, Any, Any] = (np.inf, None, None)
            for choice in choices:
                scenario = base.with_values(choice)
                quantile = np.quantile(
                    settled(scenario, tried, train), 0.95, axis=1, method="higher"
                )
                k = int(np.argmin(quantile))
                if quantile[k] < found[0]:
                    found = (quantile[k], scenario, tried[k])
            if found[1] is None:
                print(f"  {law:14s} {kind:9s} never settles in 95 % of the worlds")
                continue
            times = settled(found[1], found[2][None], test)[0]
            middle, high = np.quantile(times, [0.5, 0.95], method="higher")
            print(f"  {law:14s} {kind:9s} median {middle:5.2f} s, 95 % {high:5.2f} s = "
                  f"{high / BOUND[name]:.2f} bounds; gains {np.round(found[2], 2)}",
                  flush=True)  # fmt: skip


def main() -> None:
    """Prints both."""
    for name in BOUND:
        _, line = nominal(name, np.random.default_rng(2), damping=True)
        print(f"{name}, damping counted: {line}", flush=True)
    rng = np.random.default_rng(1)
    for name in BOUND:
        duration, line = nominal(name, rng, damping=False)
        print(f"{name}, damping left to the law: {line}", flush=True)
        robust(name, duration, rng)


if __name__ == "__main__":
    main()
