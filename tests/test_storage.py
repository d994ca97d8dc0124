"""Output folders: complete or not there at all, and never somebody else's."""

import errno
import os

import multilift as ml
import pytest
from multilift import storage

RUN = ml.simulate(ml.load("sim1").with_values({"simulation.duration": 0.1}))


def listing(folder):
    return sorted(entry.name for entry in folder.iterdir())


def test_an_existing_result_needs_force(tmp_path):
    target = RUN.save(tmp_path / "run")
    with pytest.raises(ml.OutputError, match="--force"):
        RUN.save(target)
    RUN.save(target, force=True)
    assert listing(tmp_path) == ["run"]


def test_somebody_elses_folder_is_never_replaced(tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter1.txt").write_text("years of work")
    for force in (False, True):
        with pytest.raises(ml.OutputError, match="not written by multilift"):
            RUN.save(tmp_path / "thesis", force=force)
    assert (tmp_path / "thesis" / "chapter1.txt").read_text() == "years of work"


def test_an_empty_folder_may_be_used(tmp_path):
    (tmp_path / "run").mkdir()
    RUN.save(tmp_path / "run")
    assert "metrics.json" in listing(tmp_path / "run")


def test_a_file_in_the_way(tmp_path):
    (tmp_path / "run").write_text("a file")
    with pytest.raises(ml.OutputError, match="is a file"):
        RUN.save(tmp_path / "run")
    with pytest.raises(ml.OutputError, match="cannot be made"):
        RUN.save(tmp_path / "run" / "below")
    assert (tmp_path / "run").read_text() == "a file"


@pytest.mark.parametrize("failure", [OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt()])
def test_a_failure_while_writing_leaves_nothing_behind(tmp_path, failure):
    expected = KeyboardInterrupt if isinstance(failure, KeyboardInterrupt) else ml.OutputError
    with pytest.raises(expected), storage.new_folder(tmp_path / "run") as folder:
        (folder / "half.txt").write_text("half")
        raise failure
    assert listing(tmp_path) == []


def test_a_failure_keeps_the_earlier_result(tmp_path):
    target = RUN.save(tmp_path / "run")
    before = (target / "metrics.json").read_bytes()
    with pytest.raises(ml.OutputError), storage.new_folder(target, force=True) as folder:
        (folder / "half.txt").write_text("half")
        raise OSError(errno.ENOSPC, "No space left")
    assert (target / "metrics.json").read_bytes() == before
    assert listing(tmp_path) == ["run"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_place(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(ml.OutputError, match="write"):
        RUN.save(tmp_path / "run")
