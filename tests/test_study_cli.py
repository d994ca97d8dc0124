"""``multilift study`` as people meet it."""

import json
import signal
import subprocess
import sys
import time

import pytest
from multilift import library
from study_files import SMALL, fingerprint, rows, write


def multilift(*arguments, cwd=None):
    command = [sys.executable, "-c", "from multilift.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd)


def test_from_the_file_to_the_report_and_on_again(tmp_path):
    write(tmp_path)
    first = multilift("study", "small.toml", "-o", "out", "--chunk", "5", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    for words in ("energy_coupled", "simulated seconds a second", "outside the compiled kernel",
                  "report.html"):  # fmt: skip
        assert words in first.stdout
    folder = tmp_path / "out"
    assert len(rows(folder)) == 40
    assert {f.name for f in folder.iterdir()} == {
        ".lock", "figures", "report.html", "rows", "scenario.toml", "study.json", "summary.json"
    }  # fmt: skip
    before = fingerprint(folder)
    sorted((folder / "rows").iterdir())[2].unlink()
    again = multilift("study", "small.toml", "-o", "out", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert "going on: 3 of 4 chunks" in again.stderr
    assert "10 runs" in again.stdout
    assert fingerprint(folder) == before
    refused = multilift("study", "small.toml", "-o", "out", "--count", "3", cwd=tmp_path)
    assert refused.returncode == 2
    assert "--force" in refused.stderr
    replaced = multilift("study", "small.toml", "-o", "out", "--count", "3", "--force",
                         "--threads", "1", cwd=tmp_path)  # fmt: skip
    assert replaced.returncode == 0, replaced.stderr
    assert json.loads((folder / "summary.json").read_text())["worlds"] == 6


def test_shipped_studies_are_listed_and_shown():
    listed = multilift("study", "--list").stdout
    assert all(f.stem in listed for f in library.studies())
    shown = multilift("study", "--show", "gains_sim1").stdout
    assert shown == library.find_study("gains_sim1").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["study"], "STUDY"),
        (["study", "small.toml"], "--output"),
        (["study", "nowhere.toml", "-o", "out"], "does not exist"),
        (["study", "small.toml", "-o", "out", "--engine", "gpu"], "local, ray"),
        (["study", "small.toml", "-o", "small.toml"], "is a file"),
        (["study", "small.toml", "-o", "out", "--count", "0"], "count"),
        (["study", "--show", "nowhere"], "does not exist"),
    ],
)
def test_bad_input_exits_with_2_and_one_message(tmp_path, arguments, words):
    write(tmp_path)
    result = multilift(*arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert words in result.stderr
    assert "Traceback" not in result.stderr
    assert [f.name for f in tmp_path.iterdir()] == ["small.toml"]


def test_ctrl_c_keeps_what_is_finished_and_says_how_to_go_on(tmp_path):
    write(tmp_path, SMALL.replace("= 0.05", "= 15.0").replace("count = 10", "count = 20000"))
    command = [sys.executable, "-c", "from multilift.cli import main; main()",
               "study", "small.toml", "-o", "out", "--chunk", "2"]  # fmt: skip
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        while len(list((tmp_path / "out").glob("rows/chunk-*"))) < 2:
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "the same command goes on" in told
    assert "Traceback" not in told
