"""What a scenario says that happens changes its run exactly so: breaks, motion capture, link."""

import multilift as ml
import numpy as np
import pytest
from spatial_scenarios import plate

STEP = 0.001  # s, of integration; every step is recorded
PERIOD = 0.01  # s, of control

EVERY_STEP = {"simulation.record_period": STEP, "simulation.duration": 1.0}
QUADROTORS = {"vehicle.type": "paper_craft"}


def vectors(run, name):
    """Three columns, shape (instants, 3)."""
    return np.stack([run[f"{name}_{axis}"] for axis in "xyz"], axis=1)


def event(kind, time=0.4, vehicle=2, **rest):
    return {"event": [{"kind": kind, "time": time, "vehicle": f"vehicle_{vehicle}", **rest}]}


def before_and_after(changes, happening, time=0.4):
    """A run with a happening, its rows from that on, and a check that it was the same before."""
    quiet = ml.simulate(plate(changes={**EVERY_STEP, **changes}))
    run = ml.simulate(plate(changes={**EVERY_STEP, **changes, **happening}))
    count = round(time / STEP)
    for name in quiet.columns:
        assert np.array_equal(quiet[name][:count], run[name][:count]), name
    assert not np.array_equal(quiet["vehicle2_z"], run["vehicle2_z"])
    return run, slice(count, None)


@pytest.mark.parametrize("cables", ["rigid", "elastic"])
def test_a_cut_cable_pulls_no_more_and_its_vehicle_flies_on_its_force_alone(cables):
    changes = {"plant.cables": cables, "plant.vehicle_drag": 0.0}
    run, rows = before_and_after(changes, event("cable_cut"))
    assert (run["tension2"][: rows.start] > 0).all()
    assert (run["tension2"][rows] == 0).all()
    assert (run["tension1"][rows][5:] > 0).any()
    mass = run.scenario.plant.vehicle_mass[1]
    velocity, force = vectors(run, "vehicle2_v")[rows], vectors(run, "force2")[rows]
    gained = (force / mass - [0.0, 0.0, run.scenario.plant.gravity]) * STEP
    np.testing.assert_allclose(np.diff(velocity, axis=0), gained[:-1], atol=1e-14)


def test_a_stopped_rotor_runs_out_with_its_lag_and_the_others_go_on():
    run, rows = before_and_after(QUADROTORS, event("rotor_stopped", rotor=3))
    speed, t = run["vehicle2_rotor3"][rows], run["t"][rows]
    lag = run.scenario.vehicle.rotor_time_constant[1]
    # Of order 4 with 1 ms in 25 ms: (1/25)^5 / 120 a step.
    np.testing.assert_allclose(speed, speed[0] * np.exp(-(t - t[0]) / lag), rtol=1e-6)
    # Its opposite is taken back to keep the tilt; the other pair goes on.
    for k in (2, 4):
        assert run[f"vehicle2_rotor{k}"][rows].min() > 0.5 * speed[0]
    assert run["vehicle1_rotor3"][rows].min() > 0.5 * speed[0]


def test_a_lost_vehicle_has_no_thrust_left():
    run, rows = before_and_after({}, event("vehicle_lost"))
    assert (vectors(run, "thrust2")[rows] == 0).all()
    assert (run["thrust1_z"][rows] > 0).all()

    run, rows = before_and_after(QUADROTORS, event("vehicle_lost"))
    t, lag = run["t"][rows], run.scenario.vehicle.rotor_time_constant[1]
    for k in (1, 2, 3, 4):
        speed = run[f"vehicle2_rotor{k}"][rows]
        np.testing.assert_allclose(speed, speed[0] * np.exp(-(t - t[0]) / lag), rtol=1e-6)


class Witness:
    """Holds the formation with forces that tell the instant they belong to, and keeps all it saw.

    The upright force is the one that holds, and STAMP for each instant that went by.
    """

    STAMP = 1e-6  # N

    def __init__(self):
        self.seen = []

    def step(self, m):
        error = m.vehicle - m.vehicle_target
        force = m.holding - 4.0 * error * [1.0, 1.0, 0.0]
        force[:, 2] += self.STAMP * len(self.seen)
        self.seen.append(m)
        return force


def witnessed(changes, rate=1.0 / PERIOD, duration=1.0):
    """A run under a witness, and what that was told of the vehicles and their true places."""
    witness = Witness()
    changes = {**changes, "controller.rate": rate, "simulation.duration": duration,
               "simulation.record_period": STEP}  # fmt: skip
    run = ml.simulate(plate(changes=changes), witness.step)
    told = np.array([np.hstack([m.vehicle, m.vehicle_velocity]) for m in witness.seen])
    true = np.stack(
        [
            np.hstack([vectors(run, f"vehicle{k}"), vectors(run, f"vehicle{k}_v")])
            for k in (1, 2, 3)
        ],
        axis=1,
    )
    return run, told, true


def stamps(run, rate=1.0 / PERIOD):
    """The control instants whose forces act at each step, counted from 0."""
    up = run["thrust1_z"]
    stamped = (up - up[0]) / Witness.STAMP
    assert np.abs(stamped - np.round(stamped)).max() < 1e-3
    return np.round(stamped).astype(int), np.arange(len(up)) * STEP * rate


def test_without_happenings_a_law_is_told_the_truth():
    _, told, true = witnessed({})
    assert np.array_equal(told, true[::10][: len(told)])


def test_samples_of_motion_capture_come_late_at_their_own_rate():
    _, told, true = witnessed({"motion_capture.period": 0.03, "motion_capture.delay": 0.025})
    for k, seen in enumerate(told):
        taken = (10 * k - 25) // 30 * 30
        assert np.array_equal(seen, true[max(taken, 0)])


def test_a_frozen_stream_repeats_its_last_sample():
    frozen = {"motion_capture.freeze_start": 0.3, "motion_capture.freeze_duration": 0.2}
    _, told, true = witnessed(frozen)
    for k, seen in enumerate(told):
        assert np.array_equal(seen, true[290 if 30 <= k < 50 else 10 * k]), k


def test_swapped_markers_are_swapped_for_their_time():
    swapped = {"motion_capture.swap_start": 0.3, "motion_capture.swap_duration": 0.2}
    _, told, true = witnessed(swapped)
    for k, seen in enumerate(told):
        order = [1, 0, 2] if 30 <= k < 50 else [0, 1, 2]
        assert np.array_equal(seen, true[10 * k][order]), k


def chance(count, part):
    """Five standard deviations of a fraction of independent events."""
    return 5.0 * np.sqrt(part * (1.0 - part) / count)


def test_lost_samples_leave_the_one_before_as_often_as_said():
    part = 0.3
    _, told, true = witnessed({"motion_capture.dropout": part}, rate=1000.0, duration=4.0)
    last, lost = true[0], 0
    for k, seen in enumerate(told):
        if np.array_equal(seen, true[k]):
            last = seen
        else:
            assert np.array_equal(seen, last)
            lost += 1
    assert lost / len(told) == pytest.approx(part, abs=chance(len(told), part))


def test_commands_arrive_by_the_link_s_delay_late():
    run, _, _ = witnessed({"link.delay": 0.025})
    stamp, _ = stamps(run)
    k = np.arange(len(stamp))
    assert np.array_equal(stamp, np.maximum((k - 25) // 10, 0))


def test_jitter_makes_commands_late_by_up_to_that_and_never_goes_back():
    run, _, _ = witnessed({"link.delay": 0.02, "link.jitter": 0.005}, duration=4.0)
    stamp, _ = stamps(run)
    assert (np.diff(stamp) >= 0).all()
    arrived = np.flatnonzero(np.diff(stamp)) + 1
    late = arrived - 10 * stamp[arrived] - 20
    assert ((late >= 0) & (late <= 5)).all()
    parts = np.bincount(late, minlength=6) / len(late)
    assert np.abs(parts - 1 / 6).max() < chance(len(late), 1 / 6)


def test_lost_commands_leave_the_one_before_as_often_as_said():
    part = 0.3
    run, told, _ = witnessed({"link.loss": part}, rate=1000.0, duration=4.0)
    stamp, sent = stamps(run, 1000.0)
    arrived = stamp == np.round(sent)
    # Until the first one arrives the start's command holds, which stands for instant 0.
    lost = 1.0 - arrived[1 : len(told)].mean()
    assert lost == pytest.approx(part, abs=chance(len(told), part))
    assert np.array_equal(stamp[1:][~arrived[1:]], stamp[:-1][~arrived[1:]])


def test_another_seed_is_another_run_of_the_same_statistics():
    noisy = {"motion_capture.position_noise": 0.01}
    ends = [witnessed({**noisy, "simulation.seed": seed})[1][-1] for seed in (1, 1, 2)]
    assert np.array_equal(ends[0], ends[1])
    assert not np.array_equal(ends[0], ends[2])
    _, told, true = witnessed(noisy, rate=1000.0, duration=2.0)
    error = (told - true[: len(told)])[:, :, :3]
    # Of 18000 numbers: five times sqrt(2 / 18000).
    assert np.mean(error**2) / 1e-4 == pytest.approx(1.0, abs=5 * np.sqrt(2 / error.size))
    assert np.array_equal(told[:, :, 3:], true[: len(told), :, 3:])
