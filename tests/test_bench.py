"""What the benchmark reports. How fast anything is, no test says."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import multilift as ml
import numpy as np
import pytest
from multilift import _core, bench, isa
from multilift.bench import flops
from multilift.models.planar import layout
from multilift.overrides import Columns
from rich.console import Console


def by_key(rows):
    """Rows by their short names, no name twice."""
    found = {row.key: row for row in rows}
    assert len(found) == len(rows)
    return found


def test_every_row_holds_a_measured_number(capsys):
    pytest.importorskip("mujoco")
    rows = bench.run_benchmarks(repetitions=1, worlds=8)
    found = by_key(rows)
    for row in rows:
        assert 0 < row.median < np.inf
        assert row.best == row.median
    assert found["one_ratio"].median == found["mujoco"].median / found["one"].median
    for name in isa.available():
        theirs, ours = found["mujoco_rollout"].median, found[name].median
        assert found[f"{name}_ratio"].median == theirs / ours
        rate = found["flops"].median / ours  # flop/ns
        assert found[f"{name}_rate"].median == rate
        assert found[f"{name}_share"].median == 100.0 * rate / found[f"{name}_loop"].median
        theirs, ours = found["space_mujoco_rollout"].median, found[f"space_{name}"].median
        assert found[f"space_{name}_ratio"].median == theirs / ours
    assert found["space_one_ratio"].median == (
        found["space_mujoco"].median / found["space_one"].median
    )
    # Finer than what RotorTM's integrator tolerates.
    assert found["rotortm_error"].median < 1e-6
    assert ("threads" in found) == (os.cpu_count() > 1)
    bench.print_rows(rows, Console(width=240))
    printed = capsys.readouterr().out
    assert all(row.label in printed for row in rows)


def test_without_mujoco_its_row_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    found = by_key(bench.run_benchmarks(repetitions=1, worlds=8))
    assert found["one"].median > 0 < found["law"].median
    assert found["mujoco"].median is None
    assert "not installed" in found["mujoco"].note
    assert not [key for key in found if key.endswith("_ratio")]


def test_operations_of_a_step_are_counted():
    scenario = ml.load("sim1")
    each = flops.operations(scenario)
    # Four stages with one quotient each, and none in the ideal loop besides.
    assert each.divide == 4.0
    assert each.root == 0.0
    assert each.flops == each.add + each.multiply + each.divide
    assert flops.operations(scenario.with_law("pd")).flops < each.flops
    # The law steps at every tenth step only.
    assert flops.operations(scenario.with_values({"controller.rate": 100.0})).flops < each.flops


def test_operations_grow_with_the_run():
    scenario = ml.load("sim1")
    row = layout.rows(Columns(scenario, None, 1), np.arange(1))[0][0].tolist()
    once = _core.planar_operations(scenario.law, row, 1e-3, 100, 1)
    twice = _core.planar_operations(scenario.law, row, 1e-3, 200, 1)
    for kind in ("add", "multiply"):
        assert 1.9 * once[kind] < twice[kind] < 2.0 * once[kind]
    with pytest.raises(ValueError, match="no compiled law"):
        _core.planar_operations("mine", row, 1e-3, 1, 1)
    with pytest.raises(ValueError, match="numbers"):
        _core.planar_operations(scenario.law, row[:-1], 1e-3, 1, 1)


def test_growth_is_measured_stored_and_drawn(tmp_path):
    script = Path(__file__).parents[1] / "benchmarks" / "growth.py"
    table = tmp_path / "growth.csv"
    done = subprocess.run(
        [sys.executable, str(script), "--most", "10", "--table", str(table)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    with table.open(newline="", encoding="utf-8") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert [row["worlds"] for row in rows] == [1, 10]
    assert len(done.stdout.splitlines()) == 2
    for row in rows:
        assert 0 < row["kernel_seconds"] <= row["seconds"]
        assert 0 < row["start_mib"] <= row["peak_mib"]
    assert table.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_the_growth_that_the_documentation_shows_is_whole():
    table = Path(__file__).parents[1] / "docs" / "_static" / "growth.csv"
    with table.open(newline="", encoding="utf-8") as file:
        worlds = [int(row["worlds"]) for row in csv.DictReader(file)]
    assert worlds == [10**k for k in range(7)]


def test_time_against_vehicles_is_measured_stored_and_drawn(tmp_path):
    script = Path(__file__).parents[1] / "benchmarks" / "vehicles.py"
    table = tmp_path / "vehicles.csv"
    done = subprocess.run(
        [sys.executable, str(script), "--most", "4", "--worlds", "8", "--turns", "1",
         "--table", str(table)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    with table.open(newline="", encoding="utf-8") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert [row["vehicles"] for row in rows] == [2, 4]
    assert all(row["one"] > 0 and row["lanes"] > 0 for row in rows)
    assert "exponent" in done.stdout
    assert table.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_the_times_against_vehicles_that_the_documentation_shows_are_whole():
    table = Path(__file__).parents[1] / "docs" / "_static" / "vehicles.csv"
    with table.open(newline="", encoding="utf-8") as file:
        assert [int(row["vehicles"]) for row in csv.DictReader(file)] == [2, 4, 8, 16, 32, 64]
