"""Rows on the disk: killed, full, damaged, contested; at the end always the same, bit for bit."""

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import multilift as ml
import numpy as np
import pytest
from multilift import study
from multilift.study import run as runner
from multilift.study import store as stores
from study_files import SMALL, fingerprint, rows, write

HERE = Path(__file__).parent


@pytest.fixture(autouse=True)
def no_figures(monkeypatch):
    monkeypatch.setattr(runner.page, "write", lambda *_: None)


@pytest.fixture
def plan(tmp_path):
    return study.load(write(tmp_path))


def test_fifty_kills_at_random_instants_change_no_bit(tmp_path):
    file = write(tmp_path, SMALL.replace("count = 10", "count = 30"))
    runner.run(study.load(file), tmp_path / "calm")
    out = subprocess.run(
        [sys.executable, str(HERE / "study_killed.py"), str(file), str(tmp_path), "50", "1"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert out.returncode == 0, out.stderr
    told = json.loads(out.stdout)
    assert told["kills"] >= 50
    assert told["lost"] == told["leftovers"] == 0
    expected = rows(tmp_path / "calm")
    for name in told["folders"]:
        table = rows(tmp_path / name)
        assert len(table) == len(expected) == 120
        key = ["controller", "world"]
        assert not table.duplicated(key).any()
        # Other chunks, so another order of the rows: the same after sorting.
        table, wanted = (t.sort_values(key, ignore_index=True) for t in (table, expected))
        for column in wanted.columns:
            a, b = table[column].to_numpy(), wanted[column].to_numpy()
            assert a.tobytes() == b.tobytes() if a.dtype.kind in "if" else (a == b).all(), column


def test_chunks_do_not_change_the_rows(tmp_path, plan):
    tables = []
    for chunk in (1, 7, 20, None):
        runner.run(plan, tmp_path / str(chunk), chunk=chunk)
        table = rows(tmp_path / str(chunk)).sort_values(["controller", "world"])
        tables.append(table.reset_index(drop=True))
    for other in tables[1:]:
        assert tables[0].astype({"controller": str}).equals(other.astype({"controller": str}))


def test_every_row_is_the_run_of_its_world(tmp_path, plan):
    runner.run(plan, tmp_path / "out")
    table = rows(tmp_path / "out")
    assert len(table) == 40
    for _, row in table.iterrows():
        changes = {"plant.bar_mass": row["plant.bar_mass"], "simulation.duration": 0.05,
                   "controller.k_lambda": row["controller.k_lambda"]}  # fmt: skip
        one = ml.simulate(ml.load("sim1").with_values(changes), row["controller"])
        assert one.status == row["outcome"]
        for name, value in one.metrics.items():
            assert np.array_equal(row[name], value, equal_nan=True), name
        for name, value in one.audit.items():
            assert np.array_equal(row[f"audit.{name}"], value, equal_nan=True), name


def test_columns_say_what_they_are(tmp_path, plan):
    import pyarrow.parquet as pq

    runner.run(plan, tmp_path / "out")
    for part in (tmp_path / "out" / "rows").iterdir():
        for field in pq.read_schema(part):
            assert field.metadata[b"description"], field.name
    field = pq.read_schema(part).field("plant.bar_mass")
    assert field.metadata[b"unit"] == b"kg"


def broken_after(monkeypatch, calls, error):
    """The system call that ends every write fails from now on, after so many good ones."""
    count = {"n": 0}
    real = os.fsync

    def fsync(descriptor):
        count["n"] += 1
        if count["n"] > calls:
            raise OSError(error, os.strerror(error))
        return real(descriptor)

    monkeypatch.setattr(stores.os, "fsync", fsync)


@pytest.mark.parametrize("calls", [0, 1, 2, 3, 6, 7])
def test_a_full_disk_is_named_and_the_study_goes_on_later(tmp_path, plan, monkeypatch, calls):
    runner.run(plan, tmp_path / "calm", chunk=5)
    with monkeypatch.context() as patch:
        broken_after(patch, calls, errno.ENOSPC)
        with pytest.raises(ml.OutputError, match="disk is full") as caught:
            runner.run(plan, tmp_path / "out", chunk=5)
    assert "same command again" in str(caught.value)
    assert not list((tmp_path / "out").rglob(".tmp-*"))
    runner.run(plan, tmp_path / "out", chunk=5)
    assert fingerprint(tmp_path / "out") == fingerprint(tmp_path / "calm")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a small disk")
def test_a_disk_that_is_really_full(tmp_path, plan):
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=96k", "tmpfs", str(disk)], check=False,
        capture_output=True,
    )  # fmt: skip
    if mounted.returncode != 0:
        pytest.skip("this container may not mount a small disk")
    try:
        with pytest.raises(ml.OutputError, match="disk is full"):
            runner.run(plan, disk / "out", chunk=1)
        kept = len(list((disk / "out" / "rows").glob("chunk-*")))
        assert 0 < kept < 20
        subprocess.run(["mount", "-o", "remount,size=16m", str(disk)], check=True)
        assert runner.run(plan, disk / "out").cost.runs == 2 * (20 - kept)
        runner.run(plan, tmp_path / "calm", chunk=1)
        assert fingerprint(disk / "out") == fingerprint(tmp_path / "calm")
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)


def truncate(part):
    part.write_bytes(part.read_bytes()[: part.stat().st_size // 2])


def empty(part):
    part.write_bytes(b"")


def flip(part):
    content = bytearray(part.read_bytes())
    content[len(content) // 2] ^= 1
    part.write_bytes(bytes(content))


@pytest.mark.parametrize("damage", [truncate, empty, flip, Path.unlink])
def test_a_damaged_part_is_found_and_made_again(tmp_path, plan, damage):
    runner.run(plan, tmp_path / "out", chunk=5)
    before = fingerprint(tmp_path / "out")
    part = sorted((tmp_path / "out" / "rows").iterdir())[1]
    damage(part)
    result = runner.run(plan, tmp_path / "out")
    assert result.cost.runs == 10
    assert result.damaged == ((part.name,) if damage is not Path.unlink else ())
    assert fingerprint(tmp_path / "out") == before


def test_a_part_twice_is_counted_once(tmp_path, plan):
    runner.run(plan, tmp_path / "out", chunk=5)
    before = fingerprint(tmp_path / "out")
    parts = sorted((tmp_path / "out" / "rows").iterdir())
    twin = parts[1].name.replace("chunk-0000001", "chunk-0000009")
    (parts[1].parent / twin).write_bytes(parts[1].read_bytes())  # of no chunk of this study
    runner.run(plan, tmp_path / "out")
    assert fingerprint(tmp_path / "out") == before


def test_another_study_is_refused_and_force_replaces_it(tmp_path, plan):
    runner.run(plan, tmp_path / "out")
    other = study.load(tmp_path / "small.toml", count=11)
    with pytest.raises(ml.OutputError, match="another study"):
        runner.run(other, tmp_path / "out")
    assert len(rows(tmp_path / "out")) == 40
    runner.run(other, tmp_path / "out", force=True)
    assert len(rows(tmp_path / "out")) == 44


def test_other_criteria_need_no_new_rows(tmp_path, plan):
    first = runner.run(plan, tmp_path / "out")
    text = SMALL.replace("below = 0.02", "below = 10.0")
    again = runner.run(study.load(write(tmp_path, text)), tmp_path / "out")
    assert (first.cost.runs, again.cost.runs) == (40, 0)
    assert first.summary.laws[0].successes != again.summary.laws[0].successes


def test_rows_of_another_version_are_not_continued(tmp_path, plan):
    runner.run(plan, tmp_path / "out")
    manifest = json.loads((tmp_path / "out" / "study.json").read_text())
    manifest["made_by"]["compiler"] = "other"
    (tmp_path / "out" / "study.json").write_text(json.dumps(manifest))
    with pytest.raises(ml.OutputError, match="compiler was other"):
        runner.run(plan, tmp_path / "out")


def test_other_chunks_are_refused_for_a_study_begun(tmp_path, plan):
    runner.run(plan, tmp_path / "out", chunk=5)
    with pytest.raises(ml.OutputError, match="chunks of 5"):
        runner.run(plan, tmp_path / "out", chunk=6)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"chunk": 3}'])
def test_a_broken_manifest_is_named(tmp_path, plan, text):
    runner.run(plan, tmp_path / "out")
    (tmp_path / "out" / "study.json").write_text(text)
    with pytest.raises(ml.OutputError, match="cannot be read"):
        runner.run(plan, tmp_path / "out")
    runner.run(plan, tmp_path / "out", force=True)


def test_two_writers_do_not_meet(tmp_path, plan):
    with (
        stores.open_store(tmp_path / "out", plan),
        pytest.raises(ml.OutputError, match="another process"),
    ):
        runner.run(plan, tmp_path / "out")
    runner.run(plan, tmp_path / "out")


def test_somebody_elses_folder_is_never_touched(tmp_path, plan):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter1.txt").write_text("years of work")
    for force in (False, True):
        with pytest.raises(ml.OutputError, match="holds no study"):
            runner.run(plan, tmp_path / "thesis", force=force)
    assert [f.name for f in (tmp_path / "thesis").iterdir()] == ["chapter1.txt"]
    (tmp_path / "file").write_text("")
    with pytest.raises(ml.OutputError, match="is a file"):
        runner.run(plan, tmp_path / "file")


def test_a_world_that_cannot_be_is_named(tmp_path):
    """Each end alone is possible; both at once are not."""
    text = SMALL.replace("[[success]]", """
[[vary]]
key = "start.vehicle_position[1][0]"
distribution = "list"
values = [2.6, 5.9]
[[vary]]
key = "start.vehicle_position[0][0]"
distribution = "list"
values = [0.8, 0.2]
[[success]]""")  # fmt: skip
    with pytest.raises(ml.ScenarioError, match="does not permit") as caught:
        runner.run(study.load(write(tmp_path, text)), tmp_path / "out")
    assert caught.value.key == "vary"
