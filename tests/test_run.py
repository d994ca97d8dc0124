"""Runs: what they hold, what they save."""

import json

import multilift as ml
import numpy as np
import pyarrow.parquet as pq
import pytest
from multilift.models.planar import quantities

RUN = ml.simulate(ml.load("sim1").with_values({"simulation.duration": 2.0}))


def test_columns_are_the_documented_ones():
    assert RUN.columns == list(quantities.COLUMNS)
    issue = "t y1 z1 y2 z2 theta1 theta2 theta3 u1 u2 u3 u4 d_hat_y1 d_hat_z2 tension1 storage"
    assert set(issue.split()) <= set(RUN.columns)
    assert {f"{c}_dot" for c in ("y1", "z1", "y2", "z2", "theta1", "theta2", "theta3")} <= set(
        RUN.columns
    )
    assert all(q.doc and q.unit for q in quantities.COLUMNS.values())


def test_rows_are_a_record_period_apart():
    assert RUN.t == pytest.approx(np.arange(201) * 0.01, abs=1e-12)


def test_an_unknown_column_names_those_there_are():
    with pytest.raises(KeyError, match="theta1"):
        RUN["theta"]


def test_rates_are_derivatives_of_their_columns():
    fine = ml.simulate(
        ml.load("sim1").with_values({"simulation.duration": 1.0, "simulation.record_period": 0.001})
    )
    for name in ("y1", "z1", "y2", "z2", "theta1", "theta2", "theta3"):
        slope = (fine[name][2:] - fine[name][:-2]) / 0.002
        # Central differences over 1 ms: h^2/6 times third derivatives below 100.
        assert slope == pytest.approx(fine[f"{name}_dot"][1:-1], abs=2e-5)


def test_thrust_and_attitude_are_the_papers():
    plant = RUN.scenario.plant
    flown = RUN.thrust_attitude()
    for i in (1, 2):
        share = (plant.vehicle_mass[i - 1] + plant.bar_mass / 2) * plant.gravity
        f, phi = flown[f"thrust{i}"], flown[f"attitude{i}"]
        assert f * np.sin(phi) == pytest.approx(RUN[f"u{2 * i - 1}"], abs=1e-12)
        assert f * np.cos(phi) - share == pytest.approx(RUN[f"u{2 * i}"], abs=1e-12)


def test_saved_files_hold_the_run(tmp_path):
    target = RUN.save(tmp_path / "deep" / "run")
    assert sorted(f.name for f in target.iterdir()) == [
        "metrics.json",
        "overview.png",
        "report.html",
        "run.json",
        "scenario.toml",
        "trajectory.parquet",
    ]
    table = pq.read_table(target / "trajectory.parquet")
    assert table.column_names == [*RUN.columns, "controller"]
    for name in RUN.columns:
        assert np.array_equal(table[name].to_numpy(), RUN[name])
        meta = table.schema.field(name).metadata
        assert meta[b"unit"].decode() == quantities.COLUMNS[name].unit
    assert set(table["controller"].to_pylist()) == {"energy_coupled"}
    saved = json.loads((target / "metrics.json").read_text())["sim1"]["energy_coupled"]
    assert saved["metrics"]["peak_swing_1"] == RUN.metrics["peak_swing_1"]
    # Two seconds are too short to settle: no number, not a wrong one.
    assert saved["metrics"]["position_settling_time"] is None
    assert ml.load(target / "scenario.toml").values == RUN.scenario.values
    provenance = json.loads((target / "run.json").read_text())
    assert {"multilift", "platform", "seed", "compiler", "numpy"} <= set(provenance)


def test_the_saved_scenario_gives_the_same_run_to_the_last_bit(tmp_path):
    run = ml.simulate(ml.load("exp1_1").with_values({"simulation.duration": 3.0}))
    target = run.save(tmp_path / "run")
    again = ml.simulate(ml.load(target / "scenario.toml"))
    for name in run.columns:
        assert np.array_equal(run[name], again[name])


def test_dataframe_has_the_columns_and_the_law():
    frame = RUN.to_dataframe()
    assert list(frame.columns) == [*RUN.columns, "controller"]
    assert len(frame) == len(RUN.t)


def test_a_law_of_ones_own_has_no_estimate_columns(tmp_path):
    run = ml.simulate(RUN.scenario, lambda m: -6.0 * (m.xi - m.goal) - 7.0 * m.xi_dot)
    assert "d_hat_y1" not in run.columns
    run.save(tmp_path / "run")


def test_pushes_that_start_together_are_one_recovery():
    push = {"duration": 0.4, "force": [1.0, 0.0], "shape": "half_sine"}
    scenario = ml.load("sim1").with_values(
        {
            "push": [
                {"body": "bar", "start": 1.0, **push},
                {"body": "vehicle_1", "start": 1.0, **push},
                {"body": "bar", "start": 5.0, **push},
            ]
        }
    )
    assert [r.push_start for r in ml.simulate(scenario).recoveries()] == [1.0, 5.0]


def test_thrust_as_commanded_is_what_the_law_reckons_with():
    wrong = RUN.scenario.with_values({"controller.assumed.bar_mass": 1.6})
    flown = ml.simulate(wrong).thrust_attitude()
    # Ideal actuators answer at once: the same thrust, whatever the law believes it carries.
    assert flown["thrust1"] == pytest.approx(flown["thrust1_applied"], rel=1e-12)


def test_nothing_has_settled_in_a_run_that_ended_early():
    run = ml.simulate(ml.load("sim1").with_values({"actuators.command_delay": 0.2}))
    assert run.status == "slack"
    assert np.isnan(run.metrics["swing_settling_time"])
    assert np.isnan(run.metrics["position_settling_time"])


def test_overshoot_does_not_depend_on_where_the_world_is():
    """An axis without travel does not count, whatever rounding makes of its start."""
    found = set()
    for shift in np.linspace(-3.0, 3.0, 23):
        scenario = ml.load("sim1").with_values(
            {
                "simulation.duration": 4.0,
                "start.vehicle_position": [[shift, 2.0], [shift + 1.8, 2.0]],
                "goal.vehicle_position": [[shift, 3.0], [shift + 1.8, 3.0]],
                "push": [{"body": "bar", "start": 0.5, "duration": 0.5, "force": [4.0, 0.0]}],
            }
        )
        found.add(round(ml.simulate(scenario).metrics["overshoot"], 9))
    assert len(found) == 1


def test_recoveries_follow_the_pushes():
    run = ml.simulate(ml.load("exp2"))
    found = run.recoveries()
    assert [r.push_start for r in found] == [10.8, 30.8, 50.8]
    swing = np.degrees(np.maximum(abs(run["theta1"]), abs(run["theta2"])))
    for recovery in found:
        after = run.t > recovery.push_start + recovery.time + 0.005
        window = after & (run.t < recovery.push_start + 19.0)
        assert swing[window].max() <= 1.0
    assert max(r.peak_swing for r in found) == pytest.approx(swing.max())
