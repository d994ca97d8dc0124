"""All processes of a twin begin, speak, and end with whoever started them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from multilift.flight import lab
from multilift.flight.log import read
from multilift.flight.program import Program
from multilift.flight.supervisor import Word

#: How long something that must happen is waited for, s: only a failure takes so long.
PATIENCE = 90.0

TWIN = "from multilift.cli import main; import sys; sys.argv[0] = 'multilift'; main()"


def children(log):
    """Process ids of all that serve the flight of a log, by what their command lines name."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().decode().split("\0")
            parent = (folder / "environ").read_bytes().decode()
        except OSError:
            continue
        if f"FLIGHT_UNDER_TEST={log}" in parent and any("multilift.flight" in w for w in words):
            found.append(int(folder.name))
    return found


def wait_for(what):
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end
        time.sleep(0.1)


def test_a_twin_comes_up_shows_itself_and_goes(tmp_path):
    log = tmp_path / "twin.mcap"
    with Program(lab.load(lab.DEFAULT), lab.DEFAULT, log) as program:
        program.say(Word.START)
        wait_for(lambda: (s := program.look(0.2)) is not None and s.state == "pre-flight")
        wait_for(lambda: all(v.link_age is not None for v in program.look(0.2).vehicles))
        shown = program.look()
        assert shown.twin
        assert [v.system for v in shown.vehicles] == [1, 2]
        assert dict(shown.checks)
        program.leave()
        wait_for(lambda: program.look(0.2) and program.is_over)
    topics = {entry.topic for entry in read(log)}
    wires = {f"{way}/vehicle_{k}" for way in ("in", "out") for k in (1, 2)}
    assert topics >= {"lab", "mocap", "estimate", "supervisor", "timing", *wires}


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_nothing_outlives_the_command(tmp_path, number):
    log = tmp_path / "twin.mcap"
    command = subprocess.Popen(
        [sys.executable, "-u", "-c", TWIN, "twin", "--yes", "--log", str(log)],
        env={**os.environ, "FLIGHT_UNDER_TEST": str(log)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    with command:
        assert b"pre-flight" in command.stdout.readline()
        # Plant, two autopilots, the one that flies, its log's writer, motion capture's reader.
        wait_for(lambda: len(children(log)) == 6)
        command.send_signal(number)
        command.wait(PATIENCE)
    assert command.returncode == (130 if number == signal.SIGTERM else -number)
    wait_for(lambda: not children(log))
    assert sum(1 for _ in read(log)) > 0


def test_hardware_is_not_flown_without_a_pilot(tmp_path):
    from multilift.cli import app
    from multilift.errors import ScenarioError
    from typer.testing import CliRunner

    (tmp_path / "lab.toml").write_text(
        'scenario = "exp1_1_quadrotors"\n'
        + "".join(
            f'[[vehicle]]\nsystem = {k}\naddress = "udpin:127.0.0.1:{14540 + k}"\n'
            "hover_thrust = 0.5\n"
            for k in (1, 2)
        )
        + '[motion_capture]\nsystem = "qualisys"\nhost = "127.0.0.1"\n'
        "[limits]\nfence_low = [-4, -3, -1]\nfence_high = [4, 3, 4]\n"
    )
    found = CliRunner().invoke(app, ["fly", str(tmp_path / "lab.toml"), "--yes"])
    assert isinstance(found.exception, ScenarioError)
    assert "pilot" in str(found.exception)
    assert lab.load(tmp_path / "lab.toml", twin=True).is_twin


@pytest.mark.skipif(sys.platform != "linux", reason="a terminal as Linux has it")
def test_the_pilots_keys_from_a_terminal(tmp_path):
    import fcntl
    import pty
    import select
    import struct
    import termios

    log = tmp_path / "keys.mcap"
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    command = subprocess.Popen(
        [sys.executable, "-c", TWIN, "twin", "--log", str(log), "--speed", "0.5"],
        env={**os.environ, "TERM": "xterm", "COLUMNS": "120", "LINES": "40"},
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    seen = bytearray()

    def shows(text):
        if select.select([ours], [], [], 0.1)[0]:
            try:
                seen.extend(os.read(ours, 65536))
            except OSError:  # the other end is gone
                return True
        return text.encode() in seen

    def press(keys, until):
        seen.clear()
        os.write(ours, keys.encode())
        wait_for(lambda: shows(until))

    def goes():
        # On a busy machine a check may fail just as the key comes down: she presses again.
        if shows(" go "):
            seen.clear()
            os.write(ours, b"\r")
        return shows("take-off")

    wait_for(goes)
    press("k", "They fall")
    press("n", "kill: motors off")  # asked again, and not done
    press("k", "They fall")
    press("y", "the pilot kills")
    press("q", "records")
    command.wait(PATIENCE)
    os.close(ours)
    words = [e.data["word"] for e in read(log) if e.topic == "supervisor" and e.data["word"]]
    assert list(dict.fromkeys(words))[:3] == ["start", "go", "kill"]
    assert command.returncode == 3  # it was cut short
