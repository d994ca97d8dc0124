"""Newtons to normalised thrust: hover, bounds, sagging batteries, an estimate that converges."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from multilift.flight.link.thrust import ThrustMap, command, share

CURVES = st.floats(0.0, 1.0)
HOVERS = st.floats(0.1, 0.8)


@given(st.floats(0.0, 1.0), CURVES)
def test_the_curve_is_undone(part, curve):
    u = command(part, curve)
    assert 0.0 <= u <= 1.0
    assert share(u, curve) == pytest.approx(part, rel=1e-12, abs=1e-300)


@given(HOVERS, CURVES, st.floats(1.0, 100.0))
def test_its_weight_is_its_hover_thrust(hover, curve, weight):
    craft = ThrustMap(weight, hover, curve)
    u, cut = craft.to_command(weight)
    assert (u, cut) == (pytest.approx(hover, rel=1e-12), False)
    assert craft.hover_now == pytest.approx(hover, rel=1e-12)
    assert craft.to_newton(u) == pytest.approx(weight, rel=1e-12)


@given(st.floats(), HOVERS, CURVES)
def test_every_command_is_within_bounds_and_says_when_it_was_cut(newton, hover, curve):
    craft = ThrustMap(10.0, hover, curve)
    u, cut = craft.to_command(newton)
    assert 0.0 <= u <= 1.0
    assert cut == (not 0.0 <= newton <= craft.full)


@given(st.floats(0.75, 1.2), HOVERS, CURVES)
def test_a_sagging_battery_is_made_up_for(sag, hover, curve):
    craft = ThrustMap(10.0, hover, curve, voltage=16.0)
    for _ in range(2000):
        craft.sees_voltage(16.0 * sag, 0.02)
    u, cut = craft.to_command(10.0)
    truth = 10.0 / share(hover, curve) * sag**2 * share(u, curve)
    assert cut or truth == pytest.approx(10.0, rel=1e-6)  # 20 time constants: e^-20


@pytest.mark.parametrize("volts", [0.0, -1.0, math.nan, math.inf, 65.535])
def test_voltages_that_no_battery_has_change_nothing(volts):
    craft = ThrustMap(10.0, 0.5, voltage=16.0)
    craft.sees_voltage(volts, 0.1)
    assert craft.to_command(10.0) == (0.5, False)


@given(st.floats(0.7, 1.45), HOVERS, CURVES)
def test_the_estimate_finds_the_true_thrust_from_hovering(error, hover, curve):
    craft = ThrustMap(10.0, hover, curve)
    truth = 10.0 / share(hover, curve) * error
    for _ in range(3000):
        u, _cut = craft.to_command(10.0)
        craft.sees_hover(u, truth * share(u, curve), 0.02)
    held, cut = craft.to_command(10.0)
    # What is left after 60 s of a filter that averages over about 30 s.
    assert cut or truth * share(held, curve) == pytest.approx(10.0, rel=0.02)


@given(st.lists(st.tuples(st.floats(), st.floats()), max_size=50))
def test_whatever_it_sees_the_estimate_stays_near_the_lab_file(seen):
    craft = ThrustMap(10.0, 0.5)
    said = craft.full
    for u, newton in seen:
        craft.sees_hover(u, newton, 0.02)
        assert said / 1.5 <= craft.full <= said * 1.5
