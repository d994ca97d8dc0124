"""Campaigns: how they are drawn and judged, and one flight of each dangerous sort.

A sample of twenty, one of each kind, is flown by ``make campaign-sample``, all by
``make campaign``.
"""

import csv

import pytest
from hypothesis import given
from hypothesis import strategies as st
from multilift.flight import campaign
from multilift.flight.campaign import KINDS, Outcome, Trial, command, draw, fly, write
from multilift.flight.log import read

SEED = 7


@given(st.integers(0, 10**6), st.integers(0, 10**4))
def test_a_trial_is_drawn_from_seed_and_number_alone(seed, number):
    trial = draw(seed, number)
    assert trial == draw(seed, number)
    assert trial.kind == KINDS[number % len(KINDS)]
    size, lasts = campaign._KINDS[trial.kind]
    assert size[0] <= trial.size <= size[1]
    assert lasts[0] <= trial.lasts <= lasts[1]


def test_every_twenty_flights_have_every_kind_once():
    assert len(KINDS) == 20
    assert {draw(SEED, number).kind for number in range(20)} == set(KINDS)


@pytest.mark.parametrize("kind", ["station killed", "capture frozen"])
def test_nobody_touches_or_falls_when_it_ends_in_the_air(kind):
    outcome = fly(Trial(0, kind, 15.5, 200.0, 0, 0.0), SEED)
    assert not outcome.faults
    assert outcome.course[0] == "take-off"
    assert "fly" in outcome.course


def test_a_flight_can_be_seen_again_with_its_log_and_is_the_same(tmp_path):
    trial = Trial(4, "link dies", 5.0, 200.0, 1, 0.0)
    first, again = fly(trial, SEED), fly(trial, SEED, tmp_path / "trial.mcap")
    assert first == again
    assert first.ended == "idle" or "land apart" in first.course
    truth = [e.data["vehicle"] for e in read(tmp_path / "trial.mcap") if e.topic == "truth"]
    assert all(z < 0.2 for _x, _y, z in truth[-1])


def test_what_must_not_be_is_found(monkeypatch):
    # A referee who finds nothing wrong would pass everything.
    monkeypatch.setattr(campaign, "TOUCH", 10.0)
    monkeypatch.setattr(campaign, "_HARD", 0.01)
    outcome = fly(Trial(18, "pilot lands", 0.5, 0.0, 0, 0.0), SEED)
    assert len(outcome.faults) == 2


def test_the_table_has_a_row_for_each_and_failures_name_their_command(tmp_path):
    outcomes = [Outcome(draw(SEED, k), "idle", ("take-off", "land"), 1.4, 0.3, 0.2, ["fell"] * k)
                for k in range(2)]  # fmt: skip
    write(tmp_path / "all.csv", outcomes)
    with (tmp_path / "all.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["faults"] for row in rows] == ["", "fell"]
    assert [row["kind"] for row in rows] == list(KINDS[:2])
    assert "--seed 7 --only 1 " in command(SEED, 1)
