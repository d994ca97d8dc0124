"""Runs that a broken assumption ends early: which, when, by whom, and what is kept."""

import multilift as ml
import numpy as np
import pytest
from planar_runs import at_every_step, commands, coordinates, no_force, released, trajectory
from scipy.special import ellipkinc

STEP = 0.001  # s
HOVER = {"goal.vehicle_position": [[0.8, 2.0], [2.6, 2.0]]}


def descending(rate):
    """A law that lets both equal vehicles sink faster and faster: by rate * t, in N."""
    return lambda m: (0.0, -rate * m.t, 0.0, -rate * m.t)


def pendulum(rate):
    """A bar that swings below heavy vehicles, let go at the lowest point at an angular rate."""
    plant = {
        "vehicle_mass": 1e6, "cable_length": [1.8, 1.8], "bar_mass": 0.8, "bar_length": 1.8,
        "bar_half_thickness": 0.0, "gravity": 9.8,
    }  # fmt: skip
    return released(plant, [0.0, 1.8, 1.8, 1.8, 0, 0, 0], [0, 0, 0, 0, rate, -rate, 0], 3.0)


def exploding(m):
    """A law whose force grows tenfold every 10 ms."""
    return (0.0, 10.0 ** (100.0 * m.t), 0.0, 10.0 ** (100.0 * m.t))


def test_a_descent_faster_than_free_fall_ends_slack():
    scenario = at_every_step(ml.load("sim1").with_values(HOVER | {"plant.vehicle_drag": 0.0}))
    run = ml.simulate(scenario, descending(19.0))
    # T = m3 (g + a)/2 with a = u2/(m + m3/2) crosses zero where u2 gives back the whole share.
    share = (2.0 + 0.4) * 9.8
    assert run.status == "slack"
    assert share / 19.0 < run.end_time <= share / 19.0 + STEP
    assert "would go slack" in run.ending


@pytest.mark.parametrize("cable", [1, 2])
def test_the_slack_cable_is_the_one_without_tension(cable):
    # A couple about x lifts end 2 and unloads cable 2.
    couple = {"body": "bar", "start": 0.5, "duration": 4.0, "shape": "half_sine",
              "torque": -20.0 if cable == 1 else 20.0}  # fmt: skip
    run = ml.simulate(at_every_step(ml.load("sim1").with_values(HOVER | {"push": [couple]})))
    tensions = np.stack([run["tension1"], run["tension2"]], axis=1)
    assert run.status == "slack"
    assert f"cable {cable} would go slack" in run.ending
    assert tensions[-1, cable - 1] < 0 < tensions[:-1].min()


def test_a_swing_to_the_horizontal_ends_at_assumption_3():
    # A simple pendulum's theta_dot^2 = rate^2 - 2 (g/l)(1 - cos theta), integrated to 90 degrees.
    rate, pace = 5.0, np.sqrt(9.8 / 1.8)
    exact = 2 / rate * ellipkinc(np.pi / 4, (2 * pace / rate) ** 2)
    run = ml.simulate(pendulum(rate), no_force)
    assert run.status == "swing_limit"
    # The heavy suspensions give way by less than a millionth.
    assert exact - 1e-6 < run.end_time < exact + STEP + 1e-6
    angles = np.abs(coordinates(run)[:, 4:])
    assert angles[:-1].max() < np.pi / 2 <= angles[-1].max()
    assert "|theta1| reached 90 degrees" in run.ending


def test_a_slower_swing_turns_round_before_it():
    run = ml.simulate(pendulum(3.0), no_force)
    # It rises until 2 (g/l)(1 - cos theta) = rate^2.
    assert run.finished
    assert run["theta1"].max() == pytest.approx(np.arccos(1 - 9 * 1.8 / 9.8 / 2), abs=1e-5)


def test_numbers_out_of_all_bounds_end_diverged():
    run = ml.simulate(at_every_step(ml.load("sim1")), exploding)
    assert run.status == "diverged"
    # The first instant at which a velocity or a tension is beyond 1e6, the bound.
    sizes = np.abs(np.column_stack([trajectory(run), run["tension1"], run["tension2"]]))
    assert sizes[:-1].max() <= 1e6 < sizes[-1].max()
    assert f"diverged at t = {run.end_time:.3f} s" in run.ending
    # What the metrics hold excludes the last row.
    assert run.metrics["min_tension"] == min(run[f"tension{i}"][:-1].min() for i in (1, 2))
    assert np.isfinite(list(run.audit.values())).all()


def test_a_force_that_overflows_ends_diverged_too():
    run = ml.simulate(at_every_step(ml.load("sim1")), lambda m: (0.0, 1e300, 0.0, 1e300))
    assert run.status == "diverged"
    assert not run.finished


@pytest.mark.parametrize("law", [descending(20.0), exploding], ids=["slack", "diverged"])
def test_rows_up_to_the_end_are_those_of_a_shorter_run(law):
    scenario = ml.load("sim1").with_values(HOVER | {"simulation.record_period": 0.01})
    whole = ml.simulate(scenario, law)
    assert not whole.finished
    assert whole.t[-1] == whole.end_time
    before = np.floor(whole.end_time / 0.01 - 1e-9) * 0.01
    shorter = ml.simulate(scenario.with_values({"simulation.duration": before}), law)
    assert shorter.finished
    count = len(shorter.t)
    assert len(whole.t) == count + 1  # and the instant at which it ended
    for name in whole.columns:
        np.testing.assert_array_equal(whole[name][:count], shorter[name])


def test_forces_of_an_instant_are_those_of_its_own_command():
    # The end is judged with the command given at that instant, not the one before.
    scenario = at_every_step(ml.load("sim1").with_values(HOVER))
    run = ml.simulate(scenario, lambda m: (0.0, -100.0 * (m.t > 0.1995), 0.0, 0.0))
    assert run.end_time == pytest.approx(0.2, abs=1e-12)
    assert commands(run)[-1, 1] == -100.0
    assert run.status == "slack"
