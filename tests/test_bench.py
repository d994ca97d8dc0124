"""What the benchmark reports. How fast anything is, no test says."""

import sys

import numpy as np
import pytest
from multilift import bench
from rich.console import Console


def test_every_row_holds_a_measured_number(capsys):
    pytest.importorskip("mujoco")
    ours, theirs, ratio, law = bench.run_benchmarks(repetitions=1)
    for row in (ours, theirs, ratio, law):
        assert 0 < row.best == row.median < np.inf
    assert ratio.median == theirs.median / ours.median
    bench.print_rows([ours, theirs, ratio, law], Console(width=200))
    printed = capsys.readouterr().out
    assert f"{ratio.median:.0f} " in printed
    assert all(row.label in printed for row in (ours, theirs, ratio, law))


def test_without_mujoco_its_row_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    ours, theirs, law = bench.run_benchmarks(repetitions=1)
    assert ours.median > 0 < law.median
    assert theirs.median is None
    assert "not installed" in theirs.note
