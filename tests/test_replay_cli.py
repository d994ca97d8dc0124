"""``multilift view`` as people meet it."""

import importlib.util
import subprocess
import sys

import pytest


def multilift(*arguments, cwd=None):
    command = [sys.executable, "-c", "from multilift.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd)


SHORT = ("--set", "simulation.duration=1.0")


def test_view_writes_what_is_asked_for_from_a_scenario_and_from_a_saved_run(tmp_path):
    pytest.importorskip("PIL")
    done = multilift("run", "platform_turn", "-o", "run", *SHORT, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    done = multilift("view", "run", "--page", "a.html", "--gif", "a.gif", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "a.html" in done.stdout
    assert (tmp_path / "a.gif").read_bytes()[:4] == b"GIF8"
    done = multilift("view", "platform_turn", "--page", "b.html", *SHORT, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.html").read_text() == (tmp_path / "b.html").read_text()


def test_view_writes_a_recording(tmp_path):
    pytest.importorskip("rerun")
    done = multilift("view", "sim1", "--save", "sim1.rrd", *SHORT, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "sim1.rrd").stat().st_size > 10_000


def test_view_replaces_files_only_when_told_to(tmp_path):
    (tmp_path / "a.html").write_text("mine")
    again = ("view", "platform_turn", "--page", "a.html", *SHORT)
    done = multilift(*again, cwd=tmp_path)
    assert done.returncode == 2
    assert "--force" in done.stderr
    assert (tmp_path / "a.html").read_text() == "mine"
    assert multilift(*again, "--force", cwd=tmp_path).returncode == 0
    assert (tmp_path / "a.html").read_text() != "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nowhere", "--page", "a.html"), "does not exist"),
        ((".", "--page", "a.html"), "is a folder"),
        (("platform_turn", "--page", "no/a.html"), "cannot be written"),
        (("run", "--page", "a.html", *SHORT), "is a run that is over"),
    ],
)
def test_view_says_what_is_wrong(tmp_path, arguments, words):
    if arguments[0] == "run":
        assert multilift("run", "sim1", "-o", "run", *SHORT, cwd=tmp_path).returncode == 0
    done = multilift("view", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(importlib.util.find_spec("rerun") is not None, reason="rerun is installed")
def test_view_without_rerun_says_what_to_install(tmp_path):
    done = multilift("view", "platform_turn", cwd=tmp_path)
    assert done.returncode == 2
    assert "multilift[view]" in done.stderr
