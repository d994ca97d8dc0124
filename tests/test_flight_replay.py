"""A flight's log gives the flight again, with the numbers of a run, wherever it ends."""

import os
import signal

import flight_logs as logs
import multilift as ml
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift import cli, saved
from multilift.flight import log as flight_log
from multilift.flight.log import Log
from multilift.flight.replay import flown as reading
from multilift.flight.replay.beside import Replay
from multilift.flight.supervisor import State
from typer.testing import CliRunner

#: The forces act when they are asked for, and the law sees the truth: what is then left between a
#: run and its log is that the log has every tenth step.
CHANGES = {
    "simulation.duration": 4.0, "link.delay": 0.0, "link.jitter": 0.0,
    "motion_capture.position_noise": 0.0, "motion_capture.velocity_noise": 0.0,
    "motion_capture.attitude_noise": 0.0, "motion_capture.rate_noise": 0.0,
}  # fmt: skip
ROW = 0.01


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """A run, its log between two hovers, and the lab."""
    folder = tmp_path_factory.mktemp("flight")
    scenario = ml.load("exp1_1_quadrotors").with_values(CHANGES)
    (folder / "scenario.toml").write_text(scenario.to_toml())
    run = ml.simulate(scenario)
    lab = logs.twin("scenario.toml", folder)
    path = logs.write(folder / "flight.mcap", lab, run, logs.states_of(run, 30, 20))
    return run, path, lab


def test_the_flight_has_the_numbers_of_its_run(flight):
    run, path, _lab = flight
    told = reading.read(path).course_run()
    assert told.finished
    np.testing.assert_allclose(told.t, run.t, atol=2e-9)  # nanoseconds of the log's clock
    for name in ("payload_x", "vehicle1_z", "vehicle2_v_x", "goal1_x", "target_z", "force1_z",
                 "length1", "energy"):  # fmt: skip
        np.testing.assert_allclose(told[name], run[name], rtol=1e-9, atol=1e-9, err_msg=name)
    # Nobody measures how fast rotors turn at first; four of their lags later that is forgotten.
    known = run.t > 4.0 * max(run.scenario["vehicle.rotor_time_constant"])
    for name in ("tension1", "tension2", "thrust1_z"):
        # 16 % at first, less by a factor of 50 then, and what a thrust changes by in one row.
        np.testing.assert_allclose(told[name][known], run[name][known], rtol=0.02, err_msg=name)
    sampled = {"atol": 1e-9, "rtol": 1e-3}  # a peak lies between rows
    for name in ("peak_swing", "payload_error_max", "payload_error_rms", "payload_tilt_max",
                 "payload_yaw_error_max", "control_effort", "vehicle_distance_min",
                 "cable_distance_min"):  # fmt: skip
        np.testing.assert_allclose(told.metrics[name], run.metrics[name], **sampled, err_msg=name)
    for name in ("swing_settling_time", "position_settling_time", "payload_settling_time"):
        np.testing.assert_allclose(told.metrics[name], run.metrics[name], atol=ROW, err_msg=name)


def test_the_audit_adds_up_and_says_what_a_run_s_says(flight):
    run, path, _lab = flight
    audit = reading.read(path).course_run().audit
    ends = ("storage_start", "storage_end", "largest_integration_error")
    works = sum(value for name, value in audit.items() if name not in ends)
    assert works == pytest.approx(audit["storage_end"] - audit["storage_start"], rel=1e-12)
    for name in ("storage_start", "storage_end"):
        assert audit[name] == pytest.approx(run.audit[name], rel=1e-9)
    for name in ("dissipation", "payload_drag", "adaptation", "internal_force"):
        # Trapezoids of ten steps: second order in the row.
        assert audit[name] == pytest.approx(run.audit[name], rel=1e-3, abs=1e-4), name
    assert abs(audit["integration_error"]) < 0.01 * audit["storage_start"]


@pytest.mark.parametrize(("name", "law", "changes"), [
    ("exp1_1_quadrotors", "energy_coupled", {"plant.cables": "elastic", "simulation.step": 5e-4}),
    ("uneven_four", "energy_coupled", {"vehicle.type": "paper_craft"}),
    ("exp1_1_quadrotors", "pd", {}),
])  # fmt: skip
def test_so_it_is_with_other_cables_vehicles_and_laws(tmp_path, name, law, changes):
    changes = {**CHANGES, "simulation.duration": 2.0, **changes}
    scenario = ml.load(name).with_law(law).with_values(changes)
    (tmp_path / "scenario.toml").write_text(scenario.to_toml())
    run, lab = ml.simulate(scenario), logs.twin("scenario.toml", tmp_path)
    replay = Replay(reading.read(logs.write(tmp_path / "a.mcap", lab, run,
                                            logs.states_of(run, 0, 0))), {})  # fmt: skip
    told = replay.flight
    assert told.metrics["peak_swing"] == pytest.approx(run.metrics["peak_swing"], rel=1e-3)
    known = run.t > 4.0 * max(scenario["vehicle.rotor_time_constant"])
    for k in range(scenario.count):
        tension = f"tension{k + 1}"
        np.testing.assert_allclose(told[tension][known], run[tension][known], rtol=0.02)
    assert replay.unexplained < 0.01


def test_what_the_model_does_not_know_of_is_left_over(flight, tmp_path):
    """The same motion is told to be of twice the load: its tensions are not explained."""
    run, path, lab = flight
    other = lab.scenario.with_values({"plant.payload_mass": 0.6})
    (tmp_path / "scenario.toml").write_text(other.to_toml())
    wrong = logs.write(tmp_path / "wrong.mcap", logs.twin("scenario.toml", tmp_path), run,
                       logs.states_of(run, 0, 0))  # fmt: skip
    right = Replay(reading.read(path), {}).unexplained
    assert Replay(reading.read(wrong), {}).unexplained > 5.0 * right


def test_millimetres_of_noise_are_no_newtons(flight):
    _run, path, _lab = flight
    flown = reading.read(path)
    quiet = flown.course_run()
    flown.bodies[:, :, :3] += np.random.default_rng(1).normal(
        0.0, 1e-3, flown.bodies[..., :3].shape
    )
    loud = flown.course_run()
    # The directions of cables of 1.2 m turn by 1.5 mrad: of a vehicle's 15 N that is 20 mN across
    # its cable, and a payload of 0.4 kg that hangs from two takes part of it up.
    apart = loud["tension1"] - quiet["tension1"]
    assert np.sqrt(np.mean(apart**2)) < 0.1
    assert np.abs(loud["length1"] - quiet["length1"]).max() > 2e-3


def test_the_simulation_is_the_scenario_s_own(flight):
    run, path, _lab = flight
    replay = Replay(reading.read(path), {})
    np.testing.assert_array_equal(replay.simulation["payload_x"], run["payload_x"])
    assert [d.name for d in replay.differences] == ["payload", "vehicle1", "vehicle2"]
    assert max(d.most for d in replay.differences) < 1e-6


def test_states_are_told_and_a_pause_is_no_part_of_the_course(flight, tmp_path):
    run, _path, lab = flight
    rows = range(len(run.t))
    course = [
        *((State.FLY, k) for k in rows[:300]),
        *((State.PAUSE, 299) for _ in range(50)),
        *((State.FLY, k) for k in rows[300:]),
    ]
    flown = reading.read(logs.write(tmp_path / "paused.mcap", lab, run, course))
    assert [c.state for c in flown.changes] == ["fly", "pause", "fly"]
    assert flown.changes[1].time == pytest.approx(3.0)
    told = flown.course_run()
    assert (np.diff(told.t) > 0.0).all()
    assert flown.complete
    assert np.count_nonzero(np.isfinite(flown.course)) == len(rows)


@pytest.mark.parametrize("count", [150, 399])
def test_a_course_that_was_left_is_not_settled(flight, tmp_path, count):
    run, _path, lab = flight
    course = [(State.FLY, k) for k in range(count)] + [(State.HOLD, count)] * 10
    flown = reading.read(logs.write(tmp_path / "left.mcap", lab, run, course))
    told = flown.course_run()
    if count == 150:
        assert "left its course" in told.ending
        assert np.isnan(told.metrics["position_settling_time"])
    else:
        assert told.finished


@pytest.fixture(scope="module")
def plain(flight, tmp_path_factory):
    """A log whose writer was killed, so that it has no index; its ticks."""
    run, _path, lab = flight
    path = tmp_path_factory.mktemp("plain") / "flight.mcap"
    log, rows = Log(path, 0.0), logs.Rows(run)
    logs.begin(log, lab)
    for k in range(40):
        rows.tick(log, logs.START + 0.01 * k, State.FLY, k)
    while sum(1 for _ in flight_log.read(path)) < 161:
        assert log.is_written
    os.kill(log.writer, signal.SIGKILL)
    with pytest.raises(ml.OutputError):
        log.close()
    return path


@settings(max_examples=60, deadline=None)
@given(part=st.floats(0.0, 1.0), whole=st.booleans())
def test_a_log_that_ends_anywhere_is_read_up_to_there(flight, plain, tmp_path_factory, part, whole):
    source = flight[1] if whole else plain
    content = source.read_bytes()
    cut = tmp_path_factory.getbasetemp() / "cut.mcap"
    cut.write_bytes(content[: round(part * len(content))])
    try:
        flown = reading.read(cut)
    except ml.OutputError as error:
        assert "cut.mcap" in str(error)
        return
    full = reading.read(source)
    assert len(flown.t) <= len(full.t)
    np.testing.assert_array_equal(flown.bodies, full.bodies[: len(flown.t)])


@settings(max_examples=60, deadline=None)
@given(st.binary(min_size=1, max_size=60), st.floats(0.0, 1.0))
def test_a_damaged_log_is_a_flight_or_one_error(plain, tmp_path_factory, noise, where):
    content = bytearray(plain.read_bytes())
    at = round(where * len(content))
    content[at : at + len(noise)] = noise
    broken = tmp_path_factory.getbasetemp() / "broken.mcap"
    broken.write_bytes(content)
    try:
        flown = reading.read(broken)
    except ml.MultiliftError as error:
        assert "broken.mcap" in str(error)
        return
    assert np.isfinite(flown.bodies).all() and (np.diff(flown.t) > 0.0).all()


def test_what_only_looks_like_a_scenario_is_refused(tmp_path):
    for k, text in enumerate((3, "a = ", "[" * 5000, "[plant]\nmodel = 'planar'", "x = 1e999")):
        log = Log(tmp_path / f"{k}.mcap", 0.0)
        log.write("lab", 0.0, {"scenario": text})
        log.close()
        with pytest.raises(ml.MultiliftError, match=rf"{k}\.mcap"):
            reading.read(tmp_path / f"{k}.mcap")


def test_ticks_that_are_none_are_counted_and_left_out(flight, tmp_path):
    run, _path, lab = flight
    path = tmp_path / "odd.mcap"
    log, rows = Log(path, 0.0), logs.Rows(run)
    rows.tick(log, 0.9 * logs.START, State.FLY, 0)  # before anyone says what is flown
    logs.begin(log, lab)
    rows.tick(log, logs.START, State.FLY, 0)
    for odd in (
        {},
        {"bodies": 3},
        {"bodies": {}},
        {"bodies": {"payload": [None] * 13}},
        {"bodies": dict.fromkeys(rows.bodies, [10**400] * 13)},
    ):
        log.write("estimate", logs.START + 0.01, odd)
    log.write("supervisor", logs.START + 0.01, {"state": "fly", "problems": []})  # of none
    rows.tick(log, logs.START + 0.02, State.FLY, 1, steered=False)
    log.write("wanted", logs.START + 0.02, {"force": [[1.0]], "yaw": 0.0})
    log.write("estimate", logs.START + 0.03, {"bodies": flown_bodies(rows, 2)})  # no state
    log.close()
    flown = reading.read(path)
    assert (len(flown.t), flown.unread) == (2, 7)
    assert np.isnan(flown.wanted[1]).all()
    assert (flown.force[1] == 0.0).all()


def flown_bodies(rows, k):
    return {name: columns[k].tolist() for name, columns in rows.bodies.items()}


def said(*words):
    """Exit code and output of the command."""
    result = CliRunner().invoke(cli.app, list(map(str, words)))
    problem = result.exception if isinstance(result.exception, ml.MultiliftError) else ""
    return result.exit_code, f"{result.output}{problem}"


def test_what_is_no_flight_is_said_to_be_none(flight, tmp_path):
    run, _path, lab = flight
    strange = tmp_path / "strange.mcap"
    log = Log(strange, 0.0)
    log.write("state", 0.0, {"a": 1})
    log.close()
    grounded = logs.write(tmp_path / "grounded.mcap", lab, run, [(State.PREFLIGHT, 0)] * 5)
    (tmp_path / "noise.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(100))
    for name, told in (("absent", "cannot be read"), ("strange", "no lab"),
                       ("noise", "no lab"), ("grounded", "was not flown")):  # fmt: skip
        code, text = said("replay", tmp_path / f"{name}.mcap")
        assert code == 1
        assert told in text and name in text
    assert reading.read(grounded).changes[0].state == "pre-flight"


def test_the_command_and_its_folder(flight, tmp_path):
    run, path, _lab = flight
    out = tmp_path / "out"
    code, text = said("replay", path, "-o", out)
    assert code == 0, text
    assert "form up" in text and "peak_swing" in text
    assert sorted(p.name for p in out.iterdir()) == [
        "flight", "replay.json", "report.html", "run.json", "simulation", "whole.parquet",
    ]  # fmt: skip
    page = (out / "report.html").read_text()
    assert "set down" in page and 'src="http' not in page and 'href="http' not in page
    again = saved.read(out / "flight")
    np.testing.assert_array_equal(again["tension1"], reading.read(path).course_run()["tension1"])
    np.testing.assert_array_equal(saved.read(out / "simulation")["payload_x"], run["payload_x"])
    code, text = said("replay", path, "-o", out)
    assert code == 1 and "--force" in text
