"""Whole rollouts whose motion is known in closed form."""

from dataclasses import replace

import multilift as ml
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planar_random import Plant, State, plants, states
from planar_runs import (
    COMPILED,
    commands,
    constant,
    coordinates,
    cross,
    no_force,
    released_from,
    whole_runs,
)
from scipy.interpolate import CubicSpline
from scipy.special import ellipj, ellipk

DURATION = 0.4  # s


@whole_runs
@given(plants(vehicle_drag=(0.0,) * 4), states, st.floats(0.1, 10.0))
def test_forces_in_balance_accelerate_the_whole_without_deforming_it(plant, state, pull):
    # Tensions that do not turn the bar: pull is their sum. Hovering, free fall (nearly: pull is
    # small), spread formations and tilted bars are cases of it.
    still = replace(state, theta_dot=(0.0, 0.0, 0.0))
    (s1, s2, s3), (c1, c2, c3) = np.sin(state.theta), np.cos(state.theta)
    direction = np.array([[-s1, c1], [s2, c2]])
    up, along = np.array([-s3, c3]), np.array([c3, s3])
    arm = plant.bar_half_thickness * up + 0.5 * plant.bar_length * np.array([-along, along])
    lever = cross(arm, direction)
    tension = pull * np.array([lever[1], -lever[0]]) / (lever[1] - lever[0])
    cable_force = tension[:, None] * direction
    acceleration = cable_force.sum(axis=0) / plant.bar_mass - [0.0, plant.gravity]
    half_weight = [0.0, 0.5 * plant.bar_mass * plant.gravity]
    u = np.outer(plant.vehicle_mass, acceleration) + cable_force - half_weight

    run = ml.simulate(released_from(plant, still, DURATION), constant(u))
    assert run.finished
    q, v = still.seven(plant)
    t = run.t[:, None]
    travelled = t * v + 0.5 * t**2 * np.concatenate([acceleration, acceleration, np.zeros(3)])
    np.testing.assert_allclose(coordinates(run), q + travelled, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        np.stack([run["tension1"], run["tension2"]], axis=1),
        np.tile(tension, (len(run.t), 1)),
        rtol=0,
        atol=1e-8,
    )


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("unlike", [False, True])
def test_the_goal_is_an_equilibrium_with_half_of_the_weight_on_each_cable(law, unlike):
    goal = [[0.0, 2.0], [1.8, 2.3 if unlike else 2.0]]
    values = {"plant.cable_length": [1.5, 1.8], "plant.vehicle_mass": [1.5, 2.5]} if unlike else {}
    scenario = ml.load("sim1").with_values(
        {"start.vehicle_position": goal, "goal.vehicle_position": goal} | values
    )
    run = ml.simulate(scenario, law)
    q = np.concatenate([np.ravel(goal), np.zeros(3)])
    half_weight = 0.5 * scenario.plant.bar_mass * scenario.plant.gravity
    assert run.end_time == 15.0
    np.testing.assert_allclose(coordinates(run), np.tile(q, (len(run.t), 1)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(commands(run), 0.0, rtol=0, atol=1e-11)
    for name in ("tension1", "tension2"):
        np.testing.assert_allclose(run[name], half_weight, rtol=1e-12)


# Two equal vehicles that move alike and a bar whose centre of mass is on the line of its ends
# (l3 = 0) are two bodies on a rod of length l: 2m, pulled up by the weight m3 g that u's share
# leaves over, and m3, pulled down by it. About their centre of mass, with the reduced mass
# mu = 2m m3 / (2m + m3), mu l^2 theta_ddot = -m3 g l sin(theta): a pendulum of frequency
# sqrt((1 + m3/2m) g/l), and for heavy vehicles the simple pendulum.


def pair_with_bar(vehicle_mass, amplitude, duration, step):
    plant = Plant(
        vehicle_mass=(vehicle_mass, vehicle_mass), cable_length=(1.8, 1.8), bar_mass=0.8,
        bar_length=1.3, bar_half_thickness=0.0, bar_inertia=0.0, gravity=9.8,
        vehicle_drag=(0.0,) * 4, swing_damping=(0.0,) * 3,
    )  # fmt: skip
    swung_out = State((0.0, 0.0), (amplitude, -amplitude, 0.0), (0.0, 0.0), (0.0, 0.0, 0.0))
    scenario = released_from(plant, swung_out, duration, step, controller={"rate": 12.5})
    frequency = np.sqrt(plant.gravity / 1.8 * (1 + 0.8 / (2 * vehicle_mass)))
    return ml.simulate(scenario, no_force), frequency


@pytest.mark.parametrize("amplitude", [0.1, 0.7, 1.4])
def test_swing_below_a_pair_is_jacobis_pendulum_to_order_four(amplitude):
    modulus = np.sin(0.5 * amplitude)
    errors = []
    for step in (0.02, 0.01, 0.005):
        run, frequency = pair_with_bar(2.0, amplitude, 4.0, step)
        _, cn, dn, _ = ellipj(frequency * run.t, modulus**2)
        exact = 2 * np.arcsin(modulus * cn / dn)
        errors.append(np.abs(run["theta1"] - exact).max())
        np.testing.assert_allclose(run["theta2"], -run["theta1"], rtol=0, atol=1e-11)
        np.testing.assert_allclose(run["theta3"], 0.0, rtol=0, atol=1e-11)
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 16, rtol=0.05)


def period_of(run):
    """Between the first and the third passage through the vertical, s."""
    crossings = CubicSpline(run.t, run["theta1"]).roots(extrapolate=False)
    return crossings[2] - crossings[0]


@pytest.mark.parametrize("amplitude", [0.3, 0.9, 1.4])
def test_period_below_fixed_suspensions_is_the_elliptic_integral(amplitude):
    run, _ = pair_with_bar(1e6, amplitude, 6.0, 0.002)
    expected = 4 * ellipk(np.sin(0.5 * amplitude) ** 2) * np.sqrt(1.8 / 9.8)
    # The suspensions give way by m3/2m = 4e-7 of the mass, half of which the period feels.
    np.testing.assert_allclose(period_of(run), expected, rtol=1e-6)


def test_small_swings_have_the_period_of_the_simple_pendulum():
    run, _ = pair_with_bar(1e6, 1e-3, 6.0, 0.002)
    # A swing of amplitude a takes a^2/16 longer.
    np.testing.assert_allclose(period_of(run), 2 * np.pi * np.sqrt(1.8 / 9.8), rtol=1e-6)
