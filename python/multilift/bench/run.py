"""The benchmark: everything in turns in one process, so that other load falls on all alike."""

from __future__ import annotations

import os
import statistics
from collections import defaultdict
from collections.abc import Callable
from functools import partial

from multilift import _core, isa
from multilift.bench import engine, flops, space, tree
from multilift.bench.ours import many_worlds, one_world
from multilift.bench.rows import Row, ratio, timed
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.scenario import Scenario, load

GOAL_RATIO = 20  # times MuJoCo's speed, one world
GOAL_LAW = 100.0  # ns a step of the control law
GOAL_BATCH = {"avx512": 100, "avx2": 50, "baseline": 25}  # times MuJoCo's speed, many worlds
GOAL_THREADS = 1.85  # times one thread's speed, with two
GOAL_LIMIT = 30.0  # per cent of the multiply-add loop's rate

#: What one repetition does of the law.
_LAW_STEPS = 1_000_000

_NOT_INSTALLED = "is not installed"


def run_benchmarks(repetitions: int = 7, worlds: int = 256) -> list[Row]:
    """Measures one world, many, MuJoCo beside both, the law alone and the core's own limit.

    Args:
        repetitions: how many turns everything takes.
        worlds: in each batch.
    """
    sim1 = load("sim1")
    scenario = planar_only(
        sim1.with_values({"simulation.record_period": sim1["simulation.duration"]}),
        "the benchmark",
    )
    xml, start = tree.mujoco_tree(scenario, scenario["simulation.step"]), tree.tree_start(scenario)
    measures: dict[str, Callable[[], float] | None] = {
        "one": one_world(scenario),
        "mujoco": engine.one_world(xml, start),
        "law": _law(scenario),
        "mujoco_rollout": engine.many_worlds(xml, start),
    }
    for name in isa.available():
        measures[name] = many_worlds(scenario, worlds, name, 1)
        measures[f"{name}_loop"] = partial(flops.multiply_add_rate, name)
    two = (os.cpu_count() or 1) > 1
    if two:
        measures["two_threads"] = many_worlds(
            scenario, 2 * worlds, isa.available()[0], 2, wall=True
        )
        measures["one_thread"] = many_worlds(scenario, 2 * worlds, isa.available()[0], 1, wall=True)
    measures |= space.measures(worlds)
    found: dict[str, list[float]] = defaultdict(list)
    for _ in range(repetitions):
        for key, measure in measures.items():
            if measure is not None:
                found[key].append(measure())
    rows = _one_world(found) + _many_worlds(found)
    if two:
        rows.append(
            ratio("threads", f"two threads against one, {isa.available()[0]}",
                  found["one_thread"], found["two_threads"], f"goal: {GOAL_THREADS}")
        )  # fmt: skip
    return rows + _limit(scenario, found) + space.rows(found)


def _one_world(found: dict[str, list[float]]) -> list[Row]:
    rows = [
        timed("one", "multilift: Sim 1, RK4, with control, metrics and energy audit", found["one"],
              "simulate(), called from Python, recording start and end"),
    ]  # fmt: skip
    if found["mujoco"]:
        rows += [
            timed("mujoco", "MuJoCo: the same plant as a tree of hinges, RK4", found["mujoco"],
                  "under a constant force: no control, metrics or audit"),
            ratio("one_ratio", "ratio", found["mujoco"], found["one"], f"goal: {GOAL_RATIO}"),
        ]  # fmt: skip
    else:
        rows.append(Row("mujoco", "MuJoCo on the same plant", None, None, "", _NOT_INSTALLED))
    return [*rows, timed("law", "energy-coupled law alone", found["law"],
                         f"goal: at most {GOAL_LAW:.0f}")]  # fmt: skip


def _many_worlds(found: dict[str, list[float]]) -> list[Row]:
    theirs = found["mujoco_rollout"]
    rows = []
    if theirs:
        rows.append(timed("mujoco_rollout", "mujoco.rollout: worlds in turn on one thread", theirs,
                          "as above, a step of one world"))  # fmt: skip
    for name in isa.available():
        rows.append(timed(name, f"batch on one thread, {name}", found[name],
                          "simulate_batch(), a step of one world"))  # fmt: skip
        if theirs:
            rows.append(ratio(f"{name}_ratio", f"ratio to mujoco.rollout, {name}", theirs,
                              found[name], f"goal: {GOAL_BATCH[name]}"))  # fmt: skip
    return rows


def _limit(scenario: Scenario, found: dict[str, list[float]]) -> list[Row]:
    each = flops.operations(scenario)
    kinds = f"{each.add:.0f} sums, {each.multiply:.0f} products, {each.divide:.0f} quotients"
    note = f"{kinds}; {each.other:.0f} comparisons and the like not counted"
    label = "floating-point operations in a step of one world"
    rows = [Row("flops", label, each.flops, each.flops, "flop", note)]
    for name in isa.available():
        times, loops = found[name], found[f"{name}_loop"]
        median, best = each.flops / statistics.median(times), each.flops / min(times)
        fused = flops.fused_rate(name)
        limit = f"; fused, which kernels do without: {fused:.0f}" if fused else ""
        rows += [
            Row(f"{name}_rate", f"rate achieved, {name}", median, best, "GFLOP/s", "one thread"),
            Row(f"{name}_loop", f"pure multiply-add loop, {name}", statistics.median(loops),
                max(loops), "GFLOP/s", f"products and sums rounded apart{limit}"),
            Row(f"{name}_share", f"share of the loop's rate, {name}",
                100.0 * median / statistics.median(loops), 100.0 * best / max(loops), "%",
                f"goal: {GOAL_LIMIT:.0f}"),
        ]  # fmt: skip
    return rows


def _law(scenario: PlanarScenario) -> Callable[[], float]:
    """Measures the scenario's compiled law alone, ns a step."""
    return lambda: float(
        _core.planar_law_nanoseconds(
            scenario.law,
            scenario.gain_values(),
            scenario.assumed_values(),
            scenario.goal_vector().tolist(),
            scenario.control_period(),
            _LAW_STEPS,
        )
    )
