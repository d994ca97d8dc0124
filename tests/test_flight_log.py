"""The log: complete when it is closed, nearly complete whoever is killed, and never in the way."""

import itertools
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import multilift as ml
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.exceptions import McapError
from mcap.reader import make_reader
from multilift.flight import log_writer
from multilift.flight.log import FRAME, Log, read

KILLED = Path(__file__).with_name("flight_log_killed.py")

#: The promise: what a crash may cost, s.
LOST = 0.1


def filled(path, count=200):
    log = Log(path, 5.0)
    for k in range(count):
        log.write("state", 5.0 + 0.01 * k, {"k": k, "height": 0.1 * k})
        log.raw("out/vehicle_1", 5.0 + 0.01 * k, bytes([k % 256] * 40))
    log.close()
    return log


def test_what_is_put_in_comes_out_in_order(tmp_path):
    path = tmp_path / "flight.mcap"
    log = filled(path)
    entries = list(read(path))
    assert (log.count, log.dropped, len(entries)) == (400, 0, 400)
    states = [e for e in entries if e.topic == "state"]
    assert [e.data["k"] for e in states] == list(range(200))
    assert entries[1].data == bytes(40)
    steps = {b.time - a.time for a, b in itertools.pairwise(states)}
    assert all(abs(step - 10_000_000) <= 1_000 for step in steps)
    assert abs(states[0].time - time.time_ns()) < 600e9


def test_other_readers_find_an_index(tmp_path):
    path = tmp_path / "flight.mcap"
    filled(path)
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
        assert summary.statistics.message_count == 400
        assert {c.topic for c in summary.channels.values()} == {"state", "out/vehicle_1"}
        assert summary.chunk_indexes
        first = next(make_reader(file).iter_messages(topics=["state"]))
        assert first[0].encoding == "jsonschema"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["flight.mcap"]


def test_numbers_that_json_has_not(tmp_path):
    path = tmp_path / "flight.mcap"
    log = Log(path, 0.0)
    log.write("t", 1.0, {"a": math.nan, "b": [math.inf, (1.0, -math.inf)], "c": {"d": 2}})
    log.close()
    [entry] = read(path)
    assert entry.data == {"a": None, "b": [None, [1.0, None]], "c": {"d": 2}}


def test_a_file_that_is_there_is_kept(tmp_path):
    path = tmp_path / "flight.mcap"
    path.write_text("precious")
    with pytest.raises(ml.OutputError, match=r"flight\.mcap"):
        Log(path, 0.0)
    assert path.read_text() == "precious"
    with pytest.raises(ml.OutputError, match="nowhere"):
        Log(tmp_path / "nowhere" / "flight.mcap", 0.0)
    with pytest.raises(ml.OutputError, match="absent"):
        list(read(tmp_path / "absent.mcap"))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A plain log, as it lies there while it grows, and its entries."""
    path = tmp_path_factory.mktemp("log") / "flight.mcap"
    log = Log(path, 5.0)
    for k in range(30):
        log.write("state", 5.0 + k, {"k": k})
    expected = path.stat().st_size
    while sum(1 for _ in read(path)) < 30:
        assert log.is_written
        expected = path.stat().st_size
    os.kill(log.writer, signal.SIGKILL)
    with pytest.raises(ml.OutputError, match="not complete"):
        log.close()
    assert expected <= path.stat().st_size
    return path, list(read(path))


@settings(max_examples=150, deadline=None)
@given(part=st.floats(0.0, 1.0))
def test_every_beginning_of_a_log_is_a_log(written, tmp_path_factory, part):
    path, entries = written
    content = path.read_bytes()
    cut = tmp_path_factory.getbasetemp() / "cut.mcap"
    cut.write_bytes(content[: round(part * len(content))])
    found = list(read(cut))
    assert found == entries[: len(found)]
    assert len(found) == len(entries) or part < 1.0


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=300), st.integers(0, 1000), st.booleans())
def test_whatever_a_file_holds_reading_it_ends(written, tmp_path_factory, noise, at, indexed):
    path, _entries = written
    content = bytearray(path.read_bytes())
    if indexed:
        whole = tmp_path_factory.getbasetemp() / "whole.mcap"
        if not whole.exists():
            filled(whole)
        content = bytearray(whole.read_bytes())
    content[at : at + len(noise)] = noise
    broken = tmp_path_factory.getbasetemp() / "broken.mcap"
    broken.write_bytes(content)
    assert len(list(read(broken))) <= 400


def killed(path, victim):
    """Lets a process log for a while, kills it or its writer; what it said that it had logged."""
    with subprocess.Popen(
        [sys.executable, KILLED, path], stdout=subprocess.PIPE, text=True
    ) as process:
        writer = int(process.stdout.readline())
        said = []
        while sum(1 for _ in read(path)) < 50:
            said.append(process.stdout.readline())
        os.kill(process.pid if victim == "program" else writer, signal.SIGKILL)
        process.kill()
        said += process.stdout.readlines()
    return [int(line) for line in said if line.endswith("\n")]


def is_ended(path):
    """Whether the writer has given the file its index."""
    try:
        with path.open("rb") as file:
            return bool(make_reader(file).get_summary().chunk_indexes)
    except (McapError, AttributeError):  # no end yet
        return False


def test_when_the_program_is_killed_nothing_is_lost(tmp_path):
    path = tmp_path / "flight.mcap"
    logged = killed(path, "program")
    while not is_ended(path):
        time.sleep(0.01)
    assert set(logged) <= {e.data["k"] for e in read(path)}


def test_when_the_writer_is_killed_what_it_had_is_whole(tmp_path):
    path = tmp_path / "flight.mcap"
    killed(path, "writer")
    found = [e.data["k"] for e in read(path)]
    assert len(found) >= 50
    assert found == list(range(len(found)))


class Source:
    """A socket that gives one record each time it is asked, on a clock of its own."""

    def __init__(self, count, period):
        self.now, self.left, self.period, self.given = 0.0, count, period, []

    def settimeout(self, period):
        pass

    def recv(self, _most):
        self.now += self.period
        if not self.left:
            return b""
        self.left -= 1
        if self.left % 7 == 0:
            raise TimeoutError
        head = b"" if self.given else FRAME.pack(8, 1, 0, 0) + b"json t/1"
        self.given.append(self.now)
        return head + FRAME.pack(2, 1, 1, int(self.now * 1e9)) + b"{}"


@pytest.mark.parametrize("period", [0.001, 0.007, 0.03, 0.049])
def test_what_was_taken_is_on_the_disk_within_the_promise(tmp_path, monkeypatch, period):
    path = tmp_path / "flight.mcap"
    source, on_disk = Source(200, period), []

    def sync(_number):
        on_disk.append((source.now, sum(1 for _ in read(path)), len(source.given)))

    monkeypatch.setattr(log_writer.os, "fsync", sync)
    monkeypatch.setattr(log_writer, "time", SimpleNamespace(monotonic=lambda: source.now))
    with path.open("wb") as file:
        log_writer.write(file, source)
    times = [0.0, *(now for now, _there, _given in on_disk)]
    # One period of waiting for the disk, one of waiting for a record.
    assert max(b - a for a, b in itertools.pairwise(times)) <= LOST
    assert all(there == given for _now, there, given in on_disk)
    assert on_disk[-1][2] == len(source.given)


def test_a_writer_that_is_behind_delays_nothing_and_what_is_dropped_is_counted(tmp_path):
    path = tmp_path / "flight.mcap"
    log = Log(path, 0.0)
    os.kill(log.writer, signal.SIGSTOP)
    for _ in range(400):
        log.raw("flood", 1.0, bytes(65536))  # 26 MB: more than may wait anywhere
    assert log.dropped > 0
    assert log.count + log.dropped == 400
    os.kill(log.writer, signal.SIGCONT)
    log.close()
    assert sum(1 for _ in read(path)) == log.count
