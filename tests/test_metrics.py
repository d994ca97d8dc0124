"""The metrics of a run against their definitions, applied in NumPy to every step of it."""

import multilift as ml
import numpy as np
import pytest
from multilift import _core
from multilift.models.planar import quantities
from planar_runs import COMPILED, SHIPPED, UNLIKE, at_every_step, commands, coordinates, rates

SWING_BAND, POSITION_BAND, REST_BAND = 1.0, 0.02, 1.0  # deg, m, deg/s
STEP = 0.001  # s

# Runs that end in other ways than by reaching their goal at rest.
SPECIAL = {
    "stops before it settles": ("sim1", {"simulation.duration": 1.0}),
    "starts at the goal": ("sim1", {"start.vehicle_position": [[1.2, 3.5], [3.0, 3.5]]}),
    "moves along one axis": ("sim2", {"goal.vehicle_position": [[-0.8, 3.0], [1.0, 3.0]]}),
    "ends at a slack cable": (
        "sim1",
        {"push": [{"body": "bar", "start": 1.0, "duration": 2.0, "force": [0.0, 12.0],
                   "shape": "half_sine"}]},
    ),
    "unlike vehicles": ("sim1", UNLIKE),
}  # fmt: skip


def last_time(run, outside):
    """When `outside` last held; 0 if never, NaN if it does at the end or the end came early."""
    if not run.finished:
        return np.nan
    if not outside.any():
        return 0.0
    return np.nan if outside[-1] else run.t[np.flatnonzero(outside)[-1]]


def by_definition(run):
    """Every metric, from the columns of a run with a row for each step."""
    theta = np.degrees(coordinates(run)[:, 4:])
    vehicles = coordinates(run)[:, :4].reshape(-1, 2, 2)
    goal, start = run.scenario.goal.vehicle_position, run.scenario.start.vehicle_position
    towards = np.sign(goal - start)
    swing = np.abs(theta[:, :2])
    away = (np.linalg.norm(vehicles - goal, axis=2) > POSITION_BAND).any(axis=1)
    thrust = run.thrust_attitude()
    storage = run["storage"]
    return {
        "peak_swing_1": np.abs(theta[:, 0]).max(),
        "peak_swing_2": np.abs(theta[:, 1]).max(),
        "peak_swing_3": np.abs(theta[:, 2]).max(),
        "swing_settling_time": last_time(run, (swing > SWING_BAND).any(axis=1)),
        "position_settling_time": last_time(run, away),
        "combined_settling": last_time(run, away | (np.abs(theta) > SWING_BAND).any(axis=1)),
        "rest_settling_time": last_time(
            run, (np.abs(np.degrees(rates(run)[:, 4:])) > REST_BAND).any(axis=1)
        ),
        "overshoot": max(0.0, ((vehicles - goal) * towards).max()),
        "swing_integral": np.trapezoid(swing.sum(axis=1), run.t),
        "control_effort": (commands(run)[:-1] ** 2).sum() * STEP,
        "peak_thrust": max(thrust[f"thrust{i}_applied"].max() for i in (1, 2)),
        "peak_tilt": np.degrees(max(np.abs(thrust[f"attitude{i}_applied"]).max() for i in (1, 2))),
        "min_tension": min(run[f"tension{i}"].min() for i in (1, 2)),
        "storage_rise": (storage - np.minimum.accumulate(storage)).max(),
    }


def check(scenario, law):
    run = ml.simulate(at_every_step(scenario), law)
    expected = by_definition(run)
    assert list(run.metrics) == list(expected) == list(quantities.METRICS)
    for name, value in expected.items():
        assert run.metrics[name] == pytest.approx(value, rel=1e-11, abs=1e-13, nan_ok=True), name
    return run


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_runs(name, law):
    check(ml.load(name), law)


@pytest.mark.parametrize("name", SPECIAL)
def test_special_runs(name):
    base, values = SPECIAL[name]
    run = check(ml.load(base).with_values(values), None)
    assert run.status == ("slack" if name == "ends at a slack cable" else "finished")


def test_what_never_settles_has_no_settling_time_and_what_never_moves_has_zero():
    base, values = SPECIAL["stops before it settles"]
    unsettled = ml.simulate(ml.load(base).with_values(values)).metrics
    assert np.isnan([unsettled["swing_settling_time"], unsettled["position_settling_time"]]).all()
    base, values = SPECIAL["starts at the goal"]
    settled = ml.simulate(ml.load(base).with_values(values)).metrics
    assert settled["swing_settling_time"] == settled["position_settling_time"] == 0.0


def test_a_load_that_hangs_askew_is_at_rest_where_no_swing_or_position_settles():
    # A goal against (17): the cables hang at 7 degrees and pull the vehicles 0.16 m together.
    apart = {"goal.vehicle_position": [[1.2, 3.5], [3.6, 3.5]], "goal.allow_mismatch": True}
    run = ml.simulate(ml.load("sim1").with_values({"simulation.duration": 40.0} | apart))
    metrics = run.metrics
    assert np.isnan([metrics["swing_settling_time"], metrics["position_settling_time"]]).all()
    assert 0.0 < metrics["rest_settling_time"] < 40.0
    after = run.t > metrics["rest_settling_time"]
    assert np.degrees(np.abs(rates(run)[after, 4:])).max() <= REST_BAND
    # Its angles are those of rest below the vehicles where they are, not where they should be.
    hanging = _core.planar_rest_angles(
        run.scenario.plant_values(), coordinates(run)[-1, :4].tolist()
    )
    assert np.degrees(np.abs(coordinates(run)[-1, 4:] - hanging)).max() < 0.1
    assert np.degrees(np.abs(coordinates(run)[-1, 4:])).max() > 5.0


def test_metrics_see_every_step_whatever_is_recorded():
    coarse, fine = (
        ml.simulate(ml.load("sim2").with_values({"simulation.record_period": period}))
        for period in (20.0, 0.001)
    )
    assert len(coarse.t) == 2
    assert coarse.metrics == fine.metrics
    assert coarse.audit == fine.audit
