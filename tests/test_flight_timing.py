"""What a loop measures of itself."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from multilift.flight.timing import LoopTimes, Spread

#: Of a bin: its ratio.
WIDTH = 0.02

durations = st.lists(st.floats(2e-6, 100.0), min_size=1, max_size=60)


@given(durations, st.floats(0.0, 1.0))
def test_a_quantile_is_passed_by_no_more_than_its_part(times, part):
    spread = Spread()
    for t in times:
        spread.add(t)
    bound = spread.quantile(part)
    assert sum(t > bound * (1 + 1e-9) for t in times) <= (1 - part) * len(times) + 1e-9
    exact = sorted(times)[max(math.ceil(part * len(times)) - 1, 0)]
    assert exact * (1 - 1e-9) <= bound <= exact * (1 + WIDTH) * (1 + 1e-9)


def test_nothing_has_no_quantile():
    assert Spread().quantile(0.5) == 0.0


@given(st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_a_tick_is_never_made_up_for_and_each_period_is_counted(late, work):
    times = LoopTimes(100.0)
    due = 5.0
    after = times.ticked(due, due + late, due + late + work)
    assert after >= due + late + work - 1e-9
    assert after - (due + late + work) <= 0.01 + 1e-9
    # Whole periods went by: one with this tick, the rest without any.
    assert (after - due) * 100.0 == pytest.approx(1 + times.missed, abs=1e-6)
