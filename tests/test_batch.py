"""Batches: a world among many is the world alone, whatever carries it."""

import os
import signal
import subprocess
import sys
import textwrap
import time

import multilift as ml
import numpy as np
import pytest
from multilift import isa
from multilift.models.planar import quantities

WORLDS = 37  # no multiple of any number of lanes
RNG = np.random.default_rng(7)
IDEAL = ml.load("sim1").with_values({"simulation.duration": 2.0})
TESTBED = ml.load("exp2").with_values(
    {
        "simulation.duration": 2.0,
        "push": [{"body": "bar", "start": 0.5, "duration": 0.4, "force": [2.0, 0.0],
                  "shape": "half_sine"}],
    }
)  # fmt: skip
IDEAL_DRAWS = {
    "plant.bar_mass": RNG.uniform(0.5, 1.2, WORLDS),
    "plant.vehicle_mass": RNG.uniform(1.5, 2.5, (WORLDS, 2)),
    "plant.bar_inertia": RNG.uniform(0.0, 0.3, WORLDS),
    "plant.swing_damping[1]": RNG.uniform(0.0, 0.05, WORLDS),
    "controller.k_lambda": RNG.uniform(0.0, 2.0, WORLDS),
    "controller.k_d[0][1]": RNG.uniform(3.0, 8.0, WORLDS),
    "controller.assumed.bar_mass": np.full(WORLDS, 0.8),
    "start.vehicle_position[0][0]": RNG.uniform(0.6, 1.0, WORLDS),
}
TESTBED_DRAWS = {
    "actuators.command_delay": np.round(RNG.uniform(0.0, 0.06, WORLDS), 3),
    "actuators.thrust_time_constant": RNG.uniform(0.0, 0.1, WORLDS) * (np.arange(WORLDS) % 3 > 0),
    "sensors.delay": np.round(RNG.uniform(0.0, 0.02, WORLDS), 3),
    "sensors.position_noise": RNG.uniform(0.0, 0.002, WORLDS) * (np.arange(WORLDS) % 2),
    "simulation.seed": np.arange(WORLDS) + 2**40,
    "push[0].force[0]": RNG.uniform(0.0, 3.0, WORLDS),
    "push[0].start": np.round(RNG.uniform(0.2, 1.0, WORLDS), 3),
}
CASES = {"ideal": (IDEAL, IDEAL_DRAWS), "testbed": (TESTBED, TESTBED_DRAWS)}


def same(a, b):
    assert np.array_equal(a._metrics, b._metrics, equal_nan=True)
    assert np.array_equal(a._audit, b._audit)
    assert np.array_equal(a.final_state, b.final_state)
    assert np.array_equal(a.end_time, b.end_time)
    assert np.array_equal(a.status, b.status)


def alone(scenario, draws, k):
    """World k by the road of a single run: a scenario of its own."""
    changes = {}
    for key, values in draws.items():
        if "[" not in key:
            changes[key] = values[k].tolist() if np.ndim(values[k]) else values[k].item()
    raw = scenario.with_values(changes)
    if scenario is IDEAL:
        return raw.with_values(
            {
                "plant.swing_damping": [0.02, draws["plant.swing_damping[1]"][k], 0.02],
                "controller.k_d": [[7.8, draws["controller.k_d[0][1]"][k]], [7.8, 5.8]],
                "start.vehicle_position": [[draws["start.vehicle_position[0][0]"][k], 2.0],
                                           [2.6, 2.0]],
            }
        )  # fmt: skip
    push = {"body": "bar", "shape": "half_sine", "duration": 0.4,
            "start": draws["push[0].start"][k],
            "force": [draws["push[0].force[0]"][k], 0.0]}  # fmt: skip
    return raw.with_values({"push": [push]})


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("law", ["energy_coupled", "pd"])
def test_a_world_in_a_batch_is_the_world_alone_to_the_last_bit(case, law):
    scenario, draws = CASES[case]
    if law == "pd":
        draws = {k: v for k, v in draws.items() if k != "controller.k_lambda"}
    batch = ml.simulate_batch(scenario, draws, controller=law)
    for k in (0, 1, 7, 20, WORLDS - 1):
        run = ml.simulate(alone(scenario, draws, k), law)
        for name, value in run.metrics.items():
            assert np.array_equal(value, batch.metrics[name][k], equal_nan=True), name
        for name, value in run.audit.items():
            assert value == batch.audit[name][k], name
        assert (run.status, run.end_time) == (batch.status[k], batch.end_time[k])


@pytest.mark.parametrize("case", CASES)
def test_bits_do_not_depend_on_instruction_set_threads_or_company(case):
    scenario, draws = CASES[case]
    reference = ml.simulate_batch(scenario, draws, isa="baseline", threads=1)
    for name in isa.available():
        for threads in (1, 2, 5):
            same(reference, ml.simulate_batch(scenario, draws, isa=name, threads=threads))
    order = np.random.default_rng(3).permutation(WORLDS)
    shuffled = ml.simulate_batch(scenario, {k: v[order] for k, v in draws.items()})
    assert np.array_equal(shuffled._metrics, reference._metrics[order], equal_nan=True)
    half = ml.simulate_batch(scenario, {k: v[:11] for k, v in draws.items()})
    assert np.array_equal(half._metrics, reference._metrics[:11], equal_nan=True)


def test_chunks_do_not_show(monkeypatch):
    from multilift import batch

    whole = ml.simulate_batch(IDEAL, IDEAL_DRAWS)
    monkeypatch.setattr(batch, "CHUNK", 5)
    same(whole, ml.simulate_batch(IDEAL, IDEAL_DRAWS))


def test_timing_may_differ_from_world_to_world():
    rates = np.array([1000.0, 100.0, 1000.0, 50.0])
    batch = ml.simulate_batch(IDEAL, {"controller.rate": rates})
    for k, rate in enumerate(rates):
        run = ml.simulate(IDEAL.with_values({"controller.rate": rate}))
        assert run.metrics["control_effort"] == batch.metrics["control_effort"][k]


def test_a_world_that_breaks_an_assumption_ends_alone():
    delay = np.zeros(WORLDS)
    delay[5] = 0.2  # goes slack
    scenario = ml.load("sim1").with_values({"simulation.duration": 8.0})
    lonely = ml.simulate_batch(scenario, {"actuators.command_delay": delay})
    assert lonely.status[5] == "slack"
    assert 0.0 < lonely.end_time[5] < 8.0
    others = np.arange(WORLDS) != 5
    assert (lonely.status[others] == "finished").all()
    calm = ml.simulate_batch(scenario, {"actuators.command_delay": np.zeros(WORLDS)})
    assert np.array_equal(calm._metrics[others], lonely._metrics[others], equal_nan=True)
    run = ml.simulate(scenario.with_values({"actuators.command_delay": 0.2}))
    assert run.end_time == lonely.end_time[5]
    assert run.metrics["peak_thrust"] == lonely.metrics["peak_thrust"][5]


def test_trajectories_on_request():
    batch = ml.simulate_batch(IDEAL, IDEAL_DRAWS, trajectories=True)
    names = list(quantities.COLUMNS)
    run = ml.simulate(alone(IDEAL, IDEAL_DRAWS, 3))
    for column in ("t", "theta1", "u2", "storage"):
        kept = batch.samples[3, :, names.index(column)]
        kept = kept[~np.isnan(kept)]
        assert np.array_equal(kept, run[column])


def test_dataframes_in_and_out():
    import pandas as pd

    frame = pd.DataFrame(
        {"plant.bar_mass": [0.7, 0.8, 0.9], "controller.k_lambda": [0.0, 1.0, 2.0]}
    )
    out = ml.simulate_batch(IDEAL, frame).to_dataframe()
    assert list(out["world"]) == [0, 1, 2]
    assert {"status", "end_time", "peak_swing_1", "audit.internal_force"} <= set(out.columns)
    assert out["peak_swing_1"].nunique() == 3


def test_what_the_law_assumes_follows_the_plant_unless_told():
    mass = np.array([0.6, 0.8, 1.0])
    knowing = ml.simulate_batch(IDEAL, {"plant.bar_mass": mass})
    wrong = ml.simulate_batch(
        IDEAL, {"plant.bar_mass": mass, "controller.assumed.bar_mass": np.full(3, 0.8)}
    )
    assert knowing.metrics["control_effort"][1] == wrong.metrics["control_effort"][1]
    # A heavier load than assumed makes the vehicles sag: dz = (m - m_assumed) g / 2 / k_p.
    long = IDEAL.with_values({"simulation.duration": 25.0})
    run = ml.simulate(long.with_values({"plant.bar_mass": 1.0, "controller.assumed.bar_mass": 0.8}))
    sag = long.goal_vector()[1] - run["z1"][-1]
    assert sag == pytest.approx(0.2 * 9.8 / 2 / 6.5, rel=1e-3)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"plant.bar_mas": [1.0]}, "bar_mass"),
        ({"plnt.bar_mass": [1.0]}, "plant"),
        ({"plant.bar_mass": [0.8, -1.0]}, "world 1"),
        ({"plant.bar_mass": [0.8, np.nan]}, "world 1"),
        ({"plant.bar_mass": ["a", "b"]}, "not a number"),
        ({"plant.bar_mass": 0.8}, "one entry"),
        ({"plant.bar_mass": []}, "no worlds"),
        ({"plant.bar_mass": [1.0, 1.0], "plant.gravity": [9.8]}, "differently"),
        ({"plant.vehicle_mass": np.ones((4, 3))}, "shape"),
        ({"plant.vehicle_mass[2]": [1.0]}, "element"),
        ({"plant.bar_length": [1.8, 9.0]}, "world 1"),
        ({"goal.vehicle_position[1][0]": [3.0, 3.1]}, "world 1"),
        ({"push[0].force[0]": [1.0]}, "push"),
        ({"controller.rate": [1000.0, 333.0]}, "whole number"),
        ({"plant.model": ["planar"]}, "known key"),
    ],
)
def test_wrong_overrides_name_key_and_world(overrides, words):
    with pytest.raises(ml.ScenarioError, match=words):
        ml.simulate_batch(IDEAL, overrides)


def test_an_imperfection_of_size_zero_is_none_even_beside_others():
    delay = np.array([0.0, 0.02, 0.0])
    batch = ml.simulate_batch(IDEAL, {"actuators.command_delay": delay})
    for k in range(3):
        run = ml.simulate(IDEAL.with_values({"actuators.command_delay": delay[k]}))
        assert run.metrics["peak_swing_3"] == batch.metrics["peak_swing_3"][k]


@pytest.mark.parametrize(
    "overrides",
    [
        {"actuators.command_delay": [0.0, 0.9]},
        {"actuators.command_delay": [0.0, 0.0005]},
        {"sensors.delay": [0.0, 0.9]},
        {"actuators.tilt_max": [1.0, 3.0]},
        {"actuators.thrust_max": [100.0, 1.0]},
        {"simulation.seed": [1.0, 1.5]},
        {"simulation.seed": [1.0, 1e17]},
    ],
)
def test_a_world_that_would_be_refused_alone_is_refused_in_company(overrides):
    with pytest.raises(ml.ScenarioError, match="world 1"):
        ml.simulate_batch(IDEAL, overrides)
    key, (_, bad) = next(iter(overrides.items()))
    with pytest.raises(ml.ScenarioError):
        IDEAL.with_values({key: bad})


@pytest.mark.parametrize("arguments", [{"threads": -1}, {"threads": 1.5}, {"count": 2.5}])
def test_wrong_arguments(arguments):
    with pytest.raises(ml.MultiliftError):
        ml.simulate_batch(IDEAL, **{"count": 2, **arguments})


def test_laws_of_ones_own_are_pointed_elsewhere():
    with pytest.raises(ml.ControllerError, match="compiled"):
        ml.simulate_batch(IDEAL, count=2, controller="mine.py:Law")


def test_an_instruction_set_that_is_not_there(monkeypatch):
    with pytest.raises(ml.MultiliftError, match="avx9"):
        ml.simulate_batch(IDEAL, count=1, isa="avx9")
    monkeypatch.setenv("MULTILIFT_ISA", "sse9")
    with pytest.raises(ml.MultiliftError, match="MULTILIFT_ISA"):
        ml.simulate_batch(IDEAL, count=1)
    monkeypatch.setenv("MULTILIFT_ISA", "baseline")
    assert isa.kernel().__name__.endswith("baseline")


def test_progress_counts_up_to_all():
    seen = []
    ml.simulate_batch(IDEAL, IDEAL_DRAWS, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == WORLDS


def test_ctrl_c_is_answered_and_leaves_no_thread(tmp_path):
    script = textwrap.dedent("""
        import threading
        import multilift as ml
        scenario = ml.load("sim1")
        print("ready", flush=True)
        try:
            ml.simulate_batch(scenario, count=10**6)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        ml.simulate_batch(scenario, count=4)
        print("works again", flush=True)
    """)
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline().strip() == "ready"
    # The run is under way once it has used the processor for a while; a million worlds take hours.
    until = time.monotonic() + 60
    while time.monotonic() < until and process.poll() is None:
        with open(f"/proc/{process.pid}/stat", encoding="ascii") as file:  # noqa: PTH123
            ticks = int(file.read().split()[13])
        if ticks > 2 * os.sysconf("SC_CLK_TCK"):
            break
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out.split("\n")[:2] == ["interrupted", "works again"]
    assert process.returncode == 0
