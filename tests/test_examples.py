"""Every example runs as its first lines say, and writes nothing unasked."""

import subprocess
import sys
from pathlib import Path

import multilift as ml
import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


def run(example, folder, *arguments):
    return subprocess.run(
        [sys.executable, example, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda e: e.stem)
def test_example_runs_and_writes_nothing(example, tmp_path):
    done = run(example, tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) >= 5
    assert not list(tmp_path.iterdir())


def test_first_run_saves_where_it_is_told_to(tmp_path):
    done = run(EXAMPLES[0], tmp_path, "here")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "here" / "metrics.json").is_file()


def test_law_of_the_example_can_be_named_from_outside():
    example = next(e for e in EXAMPLES if "controller" in e.stem)
    result = ml.simulate(ml.load("sim1"), f"{example}:MyLaw")
    baseline = ml.simulate(ml.load("sim1"), "pd")
    assert result.finished
    assert result.metrics["swing_settling_time"] < baseline.metrics["swing_settling_time"]
