"""The shipped flights end as their files say, and docs/flights.md tells their numbers."""

import re
from pathlib import Path

import flight_tables
import multilift as ml
import numpy as np
import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = (DOCS / "flights.md").read_text(encoding="utf-8")
ROWS = [(heads, cells) for heads, rows in flight_tables.tables(PAGE) for cells in rows]


@pytest.mark.parametrize(("heads", "cells"), ROWS, ids=[" ".join(c[:3]) for _, c in ROWS])
def test_the_printed_numbers_are_those_of_the_flight(heads, cells):
    assert flight_tables.row(heads, cells) == cells


def test_the_answers_to_the_paper_quote_measured_numbers():
    answers = PAGE.partition("| the paper says | here |")[2].partition("\n\n")[0]
    planar = ml.simulate(ml.load("exp1_1")).metrics["swing_settling_time"]
    measured = {cell for _, cells in ROWS for cell in cells} | {f"{planar:.1f}"}
    assert set(re.findall(r"\d+\.\d+", answers)) <= measured


def test_every_flight_has_numbers_a_figure_and_a_small_animation():
    told = {cells[0].strip("`") for _, cells in ROWS}
    assert len(told) == 9
    for name in told:
        for kind in ("png", "gif"):
            assert f"_static/flights/{name}.{kind}" in PAGE
    shown = re.findall(r"_static/\S+", PAGE)
    assert sum((DOCS / file).stat().st_size for file in shown) < 5e6


def test_a_set_down_load_and_its_vehicles_rest_on_the_floor_with_slack_cables():
    run = ml.simulate(ml.load("takeoff_to_setdown"))
    assert run.finished
    assert run.metrics["payload_tilt_max"] < 5.0  # it is carried level
    resting = run.t > run.end_time - 2.0
    standing = {"payload": 0.05} | {f"vehicle{k}": 0.15 for k in (1, 2, 3)}  # m, as the file says
    for body, height in standing.items():
        # The floor is a spring that gives way by millimetres, and holds sideways by a friction that
        # is viscous below 2 cm/s.
        assert np.abs(run[f"{body}_z"][resting] - height).max() < 2e-3, body
        assert np.linalg.norm(run.vector(f"{body}_v")[resting], axis=1).max() < 5e-3, body
    assert max(run[f"tension{k}"][resting].max() for k in (1, 2, 3)) == 0.0
    lifted = run["payload_z"] > 0.9
    assert lifted.any()
    assert min(run[f"tension{k}"][lifted].min() for k in (1, 2, 3)) > 0.0
    assert np.abs(run["payload_x"][-1] - 2.0) < 0.05
