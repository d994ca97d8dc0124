"""Firmware processes: found, started with what they need, and gone for certain."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import multilift as ml
import numpy as np
import pytest
import sitl_flights
from multilift.flight.sitl import firmware as firmwares
from multilift.flight.sitl.autopilot import SitlError
from test_cli import multilift

SCENARIO = ml.load("bar_from_floor")


def script(folder, kind, text):
    """A program of a kind that does something else."""
    file = sitl_flights.program(folder, kind)
    file.write_text("#!/bin/sh\n" + text)
    return file


def gone(pid):
    """Waits for a process to be no more, or a zombie that somebody else has to reap."""
    until = time.monotonic() + 20.0
    while time.monotonic() < until:
        try:
            state = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
        except (FileNotFoundError, ProcessLookupError):
            return True
        if state[0] in "ZX":
            return True
        time.sleep(0.01)
    return False


def pids(folder, name="pid"):
    """What processes wrote about themselves, as soon as they have."""
    until = time.monotonic() + 20.0
    while time.monotonic() < until:
        written = [p.read_text(encoding="ascii") for p in sorted(folder.glob(f"*/{name}"))]
        if len(written) == 2 and all(text.endswith("\n") for text in written):
            return [int(text) for text in written]
        time.sleep(0.01)
    raise AssertionError("nobody wrote")


@pytest.fixture
def first(monkeypatch):
    with sitl_flights.instances_of_fakes(monkeypatch) as instance:
        yield instance


@pytest.mark.parametrize("kind", ["px4", "ardupilot"])
def test_a_program_is_found_by_itself_by_its_build_and_by_its_sources(kind, tmp_path):
    build = {"px4": "build/px4_sitl_default", "ardupilot": "build/sitl/bin"}[kind]
    file = sitl_flights.program(tmp_path / build, kind)
    for path in (file, tmp_path / build, tmp_path):
        assert sitl_flights.make(kind, path, 0).program == file
    with pytest.raises(SitlError, match=r"no program at .*\n  permitted: "):
        sitl_flights.make(kind, tmp_path / "elsewhere", 0)


def test_px4_is_told_all_by_arguments_and_environment(tmp_path):
    file = sitl_flights.program(tmp_path, "px4")
    command = firmwares.Px4(file, first=4).command(SCENARIO, 1)
    assert command.arguments == (str(file), "-i", "5", "-d", str(tmp_path / "etc"))
    told = command.environment
    assert told["PX4_SYS_AUTOSTART"] == "10016"
    assert told["PX4_PARAM_MAV_SYS_ID"] == "6"
    assert told["PX4_PARAM_COM_OBL_RC_ACT"] == "4"
    assert float(told["PX4_PARAM_CA_ROTOR0_PY"]) == pytest.approx(0.225 / 2**0.5, abs=1e-5)
    (tmp_path / "etc").rmdir()
    with pytest.raises(SitlError, match="no folder etc"):
        firmwares.Px4(file)


def test_ardupilot_is_told_all_by_arguments_and_a_file(tmp_path):
    file = sitl_flights.program(tmp_path, "ardupilot")
    command = firmwares.ArduPilot(file, first=4).command(SCENARIO, 1)
    words = " ".join(command.arguments)
    for part in ("--model JSON:127.0.0.1", "--instance 5", "--sysid 6", "udpclient:127.0.0.1:14545",
                 "udpclient:127.0.0.1:14645", "--defaults defaults.parm"):  # fmt: skip
        assert part in words
    lines = command.files["defaults.parm"].splitlines()
    assert "GUID_OPTIONS 8" in lines


@pytest.mark.parametrize("how", ["leaves", "raises"])
def test_processes_and_their_children_end_with_the_block(how, tmp_path):
    """They, and what they started, even if they ignore that they are asked to end."""
    file = script(
        tmp_path / "fw", "px4",
        "trap '' TERM\necho $$ > pid\nsleep 1000 & echo $! > child\nwhile true; do wait; done\n",
    )  # fmt: skip
    try:
        with firmwares.Processes(firmwares.Px4(file), SCENARIO, tmp_path / "run") as processes:
            all_of_them = pids(tmp_path / "run") + pids(tmp_path / "run", "child")
            processes.check()
            if how == "raises":
                raise RuntimeError
    except RuntimeError:
        pass
    assert all(map(gone, all_of_them))


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel's help is Linux's")
def test_processes_end_even_if_we_are_killed(tmp_path):
    script(tmp_path / "fw", "px4", "echo $$ > pid\nexec sleep 1000\n")
    ours = subprocess.Popen(
        [sys.executable, "-c",
         "import sys, time, pathlib, multilift as ml\n"
         "from multilift.flight.sitl import firmware as f\n"
         "run = f.Processes(f.Px4(pathlib.Path('fw')), ml.load('bar_from_floor'),"
         " pathlib.Path('run'))\n"
         "with run:\n    time.sleep(1000)\n"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    theirs = pids(tmp_path / "run")
    ours.send_signal(signal.SIGKILL)
    ours.wait()
    assert all(map(gone, theirs))


def test_a_firmware_that_ends_is_named_with_its_last_words(tmp_path):
    file = script(tmp_path / "fw", "ardupilot", "echo bad parameter >&2\nexit 3\n")
    run = firmwares.Processes(firmwares.ArduPilot(file), SCENARIO, tmp_path / "run")
    with run as processes:
        processes._running[0].wait()
        with pytest.raises(SitlError, match=r"vehicle_1: .* code 3\n    bad parameter\n"):
            processes.check()


def test_a_program_that_is_none_is_told(tmp_path):
    file = sitl_flights.program(tmp_path / "fw", "px4")
    file.write_bytes(b"\x7fELF rubbish")
    with (
        pytest.raises(SitlError, match="cannot be started"),
        firmwares.Processes(firmwares.Px4(file), SCENARIO, tmp_path / "run"),
    ):
        pass


@pytest.mark.parametrize("kind", ["px4", "ardupilot"])
def test_the_command_flies_and_leaves_the_output(kind, tmp_path, monkeypatch, first):
    file = sitl_flights.program(tmp_path / "fw", kind)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    result = multilift(
        "sitl", f"--{kind}", str(file), "--first", str(first), "--duration", "2", "--speed", "0",
        "--logs", "kept", cwd=tmp_path,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert "2.0 s flown" in result.stdout
    assert f"UDP port {14540 + first}" in result.stdout
    assert {p.name for p in (tmp_path / "kept").iterdir()} == {"vehicle_1", "vehicle_2"}
    assert (tmp_path / "kept/vehicle_1/output.txt").is_file()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_the_command_is_interrupted_and_leaves_nobody_behind(how, tmp_path, monkeypatch, first):
    file = sitl_flights.program(tmp_path / "fw", "px4")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    arguments = ["sitl", "--px4", str(file), "--first", str(first), "--logs", "kept"]
    with subprocess.Popen(
        [sys.executable, "-c", "from multilift.cli import main; main()", *arguments],
        cwd=tmp_path, stdout=subprocess.PIPE, text=True,
    ) as ours:  # fmt: skip
        theirs = pids(tmp_path / "kept", "output.txt")
        assert ours.stdout is not None
        for line in ours.stdout:
            if "end with Ctrl-C" in line:
                break
        ours.send_signal(how)
        assert "times real time" in ours.stdout.read().replace("\n", " ")
        assert ours.wait() == 130
    assert all(map(gone, theirs))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "give --px4 PATH or --ardupilot PATH"),
        (("--px4", "x", "--ardupilot", "y"), "give --px4 PATH or --ardupilot PATH"),
        (("--px4", "nowhere"), "no program at nowhere"),
        (("sim1", "--px4", "nowhere"), "is not flown by firmware"),
    ],
)
def test_the_command_says_what_it_needs(arguments, said, tmp_path):
    result = multilift("sitl", *arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert said in result.stderr


@pytest.mark.parametrize(
    ("kind", "variable"), [("px4", "PX4_ROOT"), ("ardupilot", "ARDUCOPTER_BIN")]
)
def test_real_firmware_boots_beside_the_model_and_stands_still(kind, variable, tmp_path):
    """Two of them run 20 s in lockstep on the floor, disarmed; with their own paths in the
    environment only."""
    path = os.environ.get(variable)
    if not path:
        pytest.skip(f"{variable} is not set")
    with sitl_flights.instances() as first:
        physics, done = sitl_flights.run(kind, Path(path), tmp_path, first, duration=20.0)
    assert done.simulated == pytest.approx(20.0, abs=0.004)
    start = np.array(SCENARIO["start.vehicle_position"])
    assert np.abs(physics.world.vehicle - start).max() < 0.02
