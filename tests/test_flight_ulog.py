"""What an autopilot recorded is found beside our log, whenever its clock began."""

import json

import flight_logs as logs
import flight_ulog
import multilift as ml
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift import cli
from multilift.flight.replay import flown as reading
from typer.testing import CliRunner

pytest.importorskip("pyulog", reason="pyulog is not installed (multilift[fly])")
from multilift.flight.replay import ulog

#: Set-points take so long to arrive, and vision's origin is elsewhere, s, m.
DELAY, ORIGIN = 0.03, np.array([0.3, -0.2, 0.1])
#: What the search ends at, s.
FINEST = 1e-3


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ulog")
    scenario = ml.load("exp1_1_quadrotors").with_values({"simulation.duration": 8.0})
    (folder / "scenario.toml").write_text(scenario.to_toml())
    run = ml.simulate(scenario)
    lab = logs.twin("scenario.toml", folder)
    path = logs.write(folder / "flight.mcap", lab, run, logs.states_of(run, 10, 10))
    return reading.read(path)


def recording(flight, k, boot, rate=50.0, start=0.0, end=np.inf, noise=0.0, seed=0):
    """The ULog that vehicle k writes if it was booted so long before our log began."""
    draw = np.random.default_rng(seed)
    last = min(end, flight.t[-1])
    t = np.arange(max(start, 0.0), last, 1.0 / rate)
    at = ulog.Track(flight.t, flight.bodies[:, 1 + k]).at(t)
    q = at[:, 3:7] + draw.normal(0.0, noise, (len(t), 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    east, north, up = (at[:, :3] + ORIGIN).T
    sent = np.isfinite(flight.wanted[:, k, 0])
    q_d, thrust = (
        flight_ulog.turned(flight.wanted[sent, k]),
        np.linalg.norm(flight.force[sent, k], axis=1) / 40.0,
    )
    wanted = np.column_stack([q_d, np.zeros((len(q_d), 2)), -thrust])
    return flight_ulog.write({
        "vehicle_attitude": (t + boot, flight_ulog.turned(q)),
        "vehicle_attitude_setpoint": (flight.t[sent] + DELAY + boot, wanted),
        "vehicle_local_position": (t + boot, np.column_stack([north, east, -up])),
    })  # fmt: skip


def compared(flight, k, content, folder):
    file = folder / "log.ulg"
    file.write_bytes(content)
    return ulog.compare(flight, k, ulog.read(file), str(file))


@settings(max_examples=8, deadline=None)
@given(boot=st.floats(3.0, 5000.0), k=st.integers(0, 1), rate=st.sampled_from([50.0, 77.0, 250.0]))
def test_whenever_it_booted_it_is_laid_where_it_was(flight, tmp_path_factory, boot, k, rate):
    content = recording(flight, k, boot, rate)
    told = compared(flight, k, content, tmp_path_factory.getbasetemp())
    assert told.offset == pytest.approx(-boot, abs=2 * FINEST)
    numbers = told.numbers
    # Lean turns by 1 rad/s at most, so that a millisecond is 0.06 deg.
    assert numbers["attitude_rms"] < 0.1
    assert numbers["set_point_delay"] == pytest.approx(DELAY, abs=5 * FINEST)
    assert numbers["position_offset"] == pytest.approx(np.linalg.norm(ORIGIN), abs=0.005)
    assert numbers["position_rms"] < 0.005  # 1 m/s for some ms
    assert numbers["set_points_arrived"] == pytest.approx(1.0, abs=0.02)


def test_a_part_of_the_flight_is_enough(flight, tmp_path):
    content = recording(flight, 0, 100.0, start=0.0, end=4.0, noise=2e-3)
    told = compared(flight, 0, content, tmp_path)
    assert told.offset == pytest.approx(-100.0, abs=0.02)
    assert told.numbers["attitude_rms"] < 1.0
    told.to_csv(tmp_path / "curves.csv")
    table = np.genfromtxt(tmp_path / "curves.csv", delimiter=",", names=True)
    assert len(table) == len(flight.t)
    assert np.isnan(table["lean_x_recorded"][-1]) and np.isfinite(table["lean_x"][-1])


def test_another_flight_is_refused(flight, tmp_path):
    draw = np.random.default_rng(3)
    t = np.arange(0.0, 8.0, 0.02)
    lean = np.cumsum(draw.normal(0.0, 0.01, (len(t), 2)), axis=0)
    q = np.column_stack([np.ones(len(t)), lean, np.zeros(len(t))])
    q /= np.linalg.norm(q, axis=1)[:, None]
    with pytest.raises(ml.OutputError, match="does not fit vehicle 1"):
        compared(flight, 0, flight_ulog.write({"vehicle_attitude": (t, q)}), tmp_path)
    with pytest.raises(ml.OutputError, match="too short"):
        compared(flight, 0, recording(flight, 0, 5.0, end=1.0), tmp_path)


def test_what_is_not_there_is_not_compared(flight, tmp_path):
    t = flight.t
    content = flight_ulog.write(
        {"vehicle_attitude": (t + 9.0, flight_ulog.turned(flight.bodies[:, 1, 3:7]))}
    )
    told = compared(flight, 0, content, tmp_path)
    assert np.isnan(told.numbers["set_point_delay"]) and np.isnan(told.numbers["position_rms"])
    assert told.numbers["attitude_rms"] < 0.1
    with pytest.raises(ml.OutputError, match="no attitudes"):
        place = np.zeros((len(t), 3))
        compared(flight, 0, flight_ulog.write({"vehicle_local_position": (t, place)}), tmp_path)


def test_the_command_lays_each_vehicle_s_recording_beside_its_log(flight, tmp_path):
    files = []
    for k in range(2):
        files += ["--ulog", str(tmp_path / f"{k}.ulg")]
        (tmp_path / f"{k}.ulg").write_bytes(recording(flight, k, 50.0 + k))
    out = tmp_path / "out"
    call = ["replay", str(flight.path), *files]
    result = CliRunner().invoke(cli.app, [*call, "-o", str(out)])
    assert result.exit_code == 0, result.exception
    told = json.loads((out / "replay.json").read_text())["ulog"]
    assert [round(told[f"vehicle_{k + 1}"]["offset"]) for k in range(2)] == [-50, -51]
    assert set(told["vehicle_1"]) == set(ulog.MEANINGS)
    assert "Recording of vehicle 2" in (out / "report.html").read_text()
    assert (out / "ulog_vehicle_2.csv").is_file()
    again = CliRunner().invoke(cli.app, [*call, "--ulog", files[1]])
    assert "permitted: 2 times" in str(again.exception)


@pytest.fixture(scope="module")
def whole(flight):
    return recording(flight, 0, 5.0, end=3.0)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 1.0), st.binary(max_size=60), st.integers(0, 4000))
def test_a_damaged_recording_is_read_as_far_as_it_goes_or_refused(
    whole, tmp_path_factory, part, noise, at
):
    content = bytearray(whole)
    content = content[: round(part * len(content))]
    content[at : at + len(noise)] = noise
    file = tmp_path_factory.getbasetemp() / "damaged.ulg"
    file.write_bytes(content)
    try:
        told = ulog.read(file)
    except ml.OutputError as error:
        assert "damaged.ulg" in str(error)
        return
    assert np.isfinite(told.attitude.value).all()
