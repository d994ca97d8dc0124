"""The command line as people meet it: what it prints, what it writes, how it exits."""

import json
import subprocess
import sys

import multilift as ml
import pytest


def multilift(*arguments, cwd=None):
    command = [sys.executable, "-c", "from multilift.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd)


def test_help_names_every_command_and_the_exit_codes():
    shown = multilift("--help")
    assert shown.returncode == 0
    for word in (
        "run",
        "view",
        "reproduce",
        "check",
        "scenarios",
        "bench",
        "Exit codes",
        "completion",
    ):
        assert word in shown.stdout
    assert "Examples" in multilift("run", "--help").stdout


def test_version():
    assert multilift("--version").stdout.strip() == f"multilift {ml.__version__}"


def test_run_prints_and_writes(tmp_path):
    result = multilift(
        "run", "sim1", "-o", "out", "--set", "controller.k_lambda=0.8",
        "--set", "simulation.duration=1.0", cwd=tmp_path,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert "peak_swing_1" in result.stdout
    saved = ml.load(tmp_path / "out" / "scenario.toml")
    assert saved["controller.k_lambda"] == 0.8
    assert saved["simulation.duration"] == 1.0
    assert multilift("run", "sim1", "-o", "out", cwd=tmp_path).returncode == 2
    assert multilift("run", "sim1", "-o", "out", "--force", cwd=tmp_path).returncode == 0


def test_run_under_another_law(tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Mine:\n"
        "    def __init__(self, scenario):\n"
        "        self.k = 6.0\n"
        "    def step(self, m):\n"
        "        return -self.k * (m.xi - m.goal) - 7.0 * m.xi_dot\n"
    )
    for law, name in (("pd", "pd"), ("mine.py:Mine", "Mine")):
        out = multilift("run", "sim1", "--controller", law, "-o", name, cwd=tmp_path)
        assert out.returncode == 0, out.stderr
        assert name in json.loads((tmp_path / name / "metrics.json").read_text())["sim1"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "nowhere.toml"], "does not exist"),
        (["run", "sim1", "--set", "plant.bar_mass=-1"], "plant.bar_mass"),
        (["run", "sim1", "--set", "k"], "KEY=VALUE"),
        (["run", "sim1", "--controller", "lqr"], "energy_coupled"),
        (["run", "sim1", "--controller", "nowhere.py:Law"], "does not exist"),
        (["run"], "Missing argument"),
        (["hover"], "No such command"),
        (["check", "sim1", "nowhere.toml"], "does not exist"),
        (["reproduce", "-o", "out", "--with", "nowhere.py:Law"], "does not exist"),
    ],
)
def test_bad_input_exits_with_2_and_one_message(tmp_path, arguments, words):
    result = multilift(*arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert words in result.stderr
    assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["check", "empty.toml"], "[plant]"),
        (["run", "sim1", "--set", "push=3"], "[[push]]"),
        (["run", "sim1", "--set", "controller.law=[red]"], "[red]"),
        (["run", "[/bold]x.toml"], "[/bold]x.toml"),
        (["run", "sim1", "--set", "simulation.step=1e-320"], "simulation.step"),
        (["run", "sim1", "--set", "simulation.duration=1e300"], "simulation.duration"),
        (["run", "sim1", "--set", "plant.bar_mass=" + "9" * 400], "too large"),
        (["run", "sim1", "--set", "plant.bar_mass=1e308"], "plant"),
        (["run", "sim1", "-o", "x" * 300], "cannot be"),
    ],
)
def test_messages_say_what_they_mean_to_the_letter(tmp_path, arguments, words):
    (tmp_path / "empty.toml").write_text("schema = 1\n")
    result = multilift(*arguments, cwd=tmp_path)
    assert "Traceback" not in result.stderr
    assert result.returncode == 2
    assert words in result.stderr


def test_titles_are_no_markup(tmp_path):
    result = multilift("run", "sim1", "--set", "title=[/]", "--set", "simulation.duration=0.1")
    assert result.returncode == 0, result.stderr
    assert "[/]" in result.stdout


def test_check_reports_every_wrong_file(tmp_path):
    for k in (1, 2):
        (tmp_path / f"bad{k}.toml").write_text(f"schema = 1\nunknown{k} = 1\n")
    result = multilift("check", "sim1", "bad1.toml", "bad2.toml", cwd=tmp_path)
    assert result.returncode == 2
    assert "unknown1" in result.stderr
    assert "unknown2" in result.stderr
    assert "sim1" in result.stdout


def test_a_run_that_ends_early_exits_with_3_and_keeps_what_it_had(tmp_path):
    result = multilift(
        "run", "sim1", "-o", "out", "--set", "actuators.command_delay=0.2", cwd=tmp_path
    )
    assert result.returncode == 3
    assert "slack" in result.stderr
    summary = json.loads((tmp_path / "out" / "metrics.json").read_text())["sim1"]["energy_coupled"]
    assert summary["status"] == "slack"
    assert 0.0 < summary["end_time"] < 15.0


def test_scenarios_lists_and_shows():
    listed = multilift("scenarios").stdout
    assert all(name in listed for name in ("sim1", "sim2", "exp1_1", "exp1_2", "exp2"))
    assert "k_lambda = 1.4" in multilift("scenarios", "--show", "sim1").stdout
