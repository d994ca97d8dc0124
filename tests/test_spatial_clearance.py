"""Distances of vehicles from each other and from each other's cables, and what ends a run.

The reference lays points along every cable and takes the nearest.
"""

import multilift as ml
import numpy as np
import pytest
from spatial_scenarios import plate

STEP = 0.001  # s; every step is recorded
MEASURED = 20  # steps between two measurements, as metrics.hpp has it
POINTS = 2001  # on a cable


def shoved(n, seed, changes=None):
    """A plate whose vehicles are shoved about, each its own way."""
    rng = np.random.default_rng(seed)
    pushes = [
        {"body": f"vehicle_{k + 1}", "start": round(rng.uniform(0, 0.5), 3), "duration": 0.6,
         "force": rng.uniform(-12, 12, 3).tolist()}
        for k in range(n)
    ]  # fmt: skip
    return plate(
        n,
        {"simulation.record_period": STEP, "simulation.duration": 2.0, "push": pushes,
         **(changes or {})},
    )  # fmt: skip


def vectors(run, name, axes="xyz"):
    return np.stack([run[f"{name}_{axis}"] for axis in axes], axis=1)


def distances(run, whole=None):
    """Over the instants: of the nearest vehicles, of the nearest vehicle and cable, m."""
    n = run.scenario.count
    w, x, y, z = vectors(run, "payload", ["qw", "qx", "qy", "qz"]).T
    turn = np.array(
        [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    )  # fmt: skip
    vehicles = [vectors(run, f"vehicle{k + 1}") for k in range(n)]
    part = np.linspace(0.0, 1.0, POINTS)[:, None]
    apart = np.full(len(w), np.inf)
    off = apart.copy()
    for i in range(n):
        tie = vectors(run, "payload") + np.einsum(
            "ijt,j->ti", turn, run.scenario.plant.attachment[i]
        )
        for j in range(n):
            if i == j:
                continue
            apart = np.minimum(apart, np.linalg.norm(vehicles[i] - vehicles[j], axis=1))
            if whole is not None and not whole[i]:
                continue
            for t in range(0, len(w), MEASURED):
                cable = tie[t] + part * (vehicles[i][t] - tie[t])
                off[t] = min(off[t], np.linalg.norm(cable - vehicles[j][t], axis=1).min())
    return apart, off


def half_spacing(run):
    """Between two points on a cable, at the most that cables are long, m."""
    return 0.5 * max(run.scenario.plant.cable_length) / (POINTS - 1) * 1.001


@pytest.mark.parametrize("n", [2, 3, 5])
@pytest.mark.parametrize("seed", [1, 2])
def test_least_distances_are_those_of_points_laid_along_the_cables(n, seed):
    run = ml.simulate(shoved(n, seed))
    apart, off = distances(run)
    assert run.metrics["vehicle_distance_min"] == pytest.approx(apart[::MEASURED].min(), rel=1e-12)
    # The nearest of the points is at most half a spacing beside the nearest place.
    least, beside = off.min(), half_spacing(run)
    assert least - beside**2 / (2 * least) * 1.01 <= run.metrics["cable_distance_min"]
    assert run.metrics["cable_distance_min"] <= least * (1 + 1e-12)
    # Between two measurements they come nearer by no more than they move in half of that time.
    speeds = [np.linalg.norm(vectors(run, f"vehicle{k + 1}_v"), axis=1).max() for k in range(n)]
    missed = 0.5 * MEASURED * STEP * 2 * max(speeds)
    assert apart.min() <= run.metrics["vehicle_distance_min"] <= apart.min() + missed


@pytest.mark.parametrize("what", ["vehicle", "cable"])
@pytest.mark.parametrize("n", [2, 4])
def test_a_collision_ends_the_run_at_the_first_measurement_below_its_distance(what, n):
    free = ml.simulate(shoved(n, 3))
    found = distances(free)[0 if what == "vehicle" else 1][::MEASURED]
    # Between the start's distance and the least, halfway, so that points on cables are fine enough.
    limit = 0.5 * (found[0] + found.min())
    first = int(np.flatnonzero(found < limit)[0])
    run = ml.simulate(shoved(n, 3, {f"safety.{what}_distance": float(limit)}))
    assert run.status == "collision"
    assert run.end_time == pytest.approx(first * MEASURED * STEP, abs=1e-12)
    assert run["t"][-1] == run.end_time
    assert run.metrics[f"{what}_distance_min"] < limit
    # Until then it is the same run.
    count = len(run["t"])
    assert np.array_equal(run["payload_x"], free["payload_x"][:count])


def test_a_cut_cable_is_nobody_s_any_more():
    cut = {"event": [{"kind": "cable_cut", "time": 0.0, "vehicle": "vehicle_1"}]}
    # The vehicle at the cut cable flies across above its neighbours; its cable would sweep them.
    run = ml.simulate(shoved(3, 1, cut))
    whole = distances(run, [False, True, True])[1].min()
    beside = half_spacing(run)
    assert run.metrics["cable_distance_min"] == pytest.approx(whole, abs=beside**2 / whole)
