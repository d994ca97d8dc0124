"""What becomes of a command on its way to the vehicles: delay, lag, limits."""

from itertools import pairwise

import multilift as ml
import numpy as np
import pytest
from planar_runs import at_every_step, commands, coordinates, no_force

STEP = 0.001  # s
BEFORE, AFTER = (1.0, 2.0, -0.5, 1.0), (-3.0, -4.0, 2.0, 5.0)  # N
CHANGE = 0.1  # s


def step_change(m):
    """Another command from CHANGE on."""
    return AFTER if m.t > CHANGE - 0.5 * STEP else BEFORE


def applied(run):
    """u1..u4 as they act, shape (n, 4)."""
    return np.stack([run[f"u{k}_applied"] for k in range(1, 5)], axis=1)


def with_actuators(base="sim1", duration=0.5, **actuators):
    scenario = at_every_step(ml.load(base))
    values = {f"actuators.{key}": value for key, value in actuators.items()}
    return scenario.with_values(values | {"simulation.duration": duration})


def test_an_ideal_command_acts_at_once():
    run = ml.simulate(with_actuators(), step_change)
    expected = np.where(run.t[:, None] > CHANGE - 0.5 * STEP, AFTER, BEFORE)
    np.testing.assert_array_equal(commands(run), expected)
    np.testing.assert_array_equal(applied(run), expected)


@pytest.mark.parametrize("actuators", [{}, {"thrust_max": 1e6}], ids=["ideal", "testbed"])
def test_thrust_holds_the_masses_that_the_law_assumes(actuators):
    # u = 0 asks for (m + m3/2) g with those; what it is too much lifts the whole uniformly.
    assumed = {"vehicle_mass": 2.3, "bar_mass": 1.0}
    scenario = with_actuators(**actuators).with_values(
        {"controller.assumed": assumed, "plant.vehicle_drag": 0.0}
    )
    run = ml.simulate(scenario, no_force)
    lift = 9.8 * ((2.3 + 0.5) / (2.0 + 0.4) - 1.0)
    for name in ("z1", "z2"):
        np.testing.assert_allclose(run[name], 2.0 + 0.5 * lift * run.t**2, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["tension1"], 0.5 * 0.8 * (9.8 + lift), rtol=1e-12)


@pytest.mark.parametrize("delay", [0.001, 0.02, 0.123])
def test_a_command_acts_exactly_its_delay_later(delay):
    run = ml.simulate(with_actuators(command_delay=delay), step_change)
    travelled = round(delay / STEP)
    # Until the first command arrives, the vehicles hover under their share: u = 0.
    expected = np.vstack([np.zeros((travelled, 4)), commands(run)[: len(run.t) - travelled]])
    # Thrust and attitude carry the command, so it comes back within their rounding.
    np.testing.assert_allclose(applied(run), expected, rtol=0, atol=1e-13)


def test_a_held_command_acts_a_delay_after_its_instant_too():
    scenario = with_actuators(command_delay=0.013).with_values({"controller.rate": 50.0})
    run = ml.simulate(scenario, lambda m: (m.t, 0.0, 0.0, -m.t))
    instants = np.floor((run.t - 0.013) / 0.02 + 1e-6) * 0.02
    sent = np.maximum(instants, 0.0)
    np.testing.assert_allclose(run["u1_applied"], sent, rtol=0, atol=1e-13)
    np.testing.assert_allclose(run["u4_applied"], -sent, rtol=0, atol=1e-13)


@pytest.mark.parametrize("tau_thrust", [0.0, 0.05])
@pytest.mark.parametrize("tau_attitude", [0.0, 0.2])
@pytest.mark.parametrize("delay", [0.0, 0.03])
def test_thrust_and_attitude_approach_their_command_exponentially(tau_thrust, tau_attitude, delay):
    run = ml.simulate(
        with_actuators(
            thrust_time_constant=tau_thrust,
            attitude_time_constant=tau_attitude,
            command_delay=delay,
            thrust_max=1e3,  # keeps the testbed's actuators in where all else is 0
        ),
        step_change,
    )
    plant = run.scenario.plant
    share = (plant.vehicle_mass + 0.5 * plant.bar_mass) * plant.gravity

    def polar(u):
        along, up = np.reshape(u, (2, 2)).T + np.array([np.zeros(2), share])
        return {"thrust": np.hypot(along, up), "attitude": np.arctan2(along, up)}

    hover, before, after = polar(np.zeros(4)), polar(BEFORE), polar(AFTER)
    actual = run.thrust_attitude()

    def first_order(t, start, target, tau):
        return target + (start - target) * (np.exp(-t / tau) if tau else 0.0)

    for name, tau in (("thrust", tau_thrust), ("attitude", tau_attitude)):
        since_first, since_second = run.t - delay, run.t - delay - CHANGE
        for i in range(2):
            start, first, second = hover[name][i], before[name][i], after[name][i]
            at_change = first_order(CHANGE, start, first, tau)
            expected = np.where(
                since_second > -0.5 * STEP,
                first_order(since_second, at_change, second, tau),
                first_order(since_first, start, first, tau),
            )
            expected[since_first < -0.5 * STEP] = start
            np.testing.assert_allclose(
                actual[f"{name}{i + 1}_applied"], expected, rtol=1e-12, atol=1e-13
            )


def test_lagging_forces_keep_the_order_of_the_integrator():
    # They change within a step; order 4 needs them right at its middle too.
    lag = {"thrust_time_constant": 0.05, "attitude_time_constant": 0.08}
    base = with_actuators(duration=2.0, **lag).with_values(
        {"controller.rate": 50.0, "simulation.record_period": 0.02}
    )
    runs = [
        coordinates(ml.simulate(base.with_values({"simulation.step": step})))
        for step in (0.01, 0.005, 0.0025, 0.00125)
    ]
    changes = [np.abs(a - b).max() for a, b in pairwise(runs)]
    np.testing.assert_allclose(np.divide(changes[:-1], changes[1:]), 16, atol=1.0)


def test_limits_bound_thrust_and_tilt_each_on_its_own():
    limits = {"thrust_min": 15.0, "thrust_max": 25.0, "tilt_max": 0.2}
    seen = []

    def wide(m):
        seen.append(m.saturated)
        angle = 20.0 * m.t
        return (8.0 * np.sin(angle), 8.0 * np.cos(angle), 0.5, 0.5)

    run = ml.simulate(with_actuators(duration=1.0, **limits), wide)
    flown = run.thrust_attitude()
    plant = run.scenario.plant
    cut = []
    for i in (1, 2):
        up = run[f"u{2 * i}"] + (plant.vehicle_mass[i - 1] + plant.bar_mass / 2) * plant.gravity
        # The vertical part is kept and the sideways part cut to the cone of the greatest tilt.
        side = np.clip(run[f"u{2 * i - 1}"], -np.tan(0.2) * up, np.tan(0.2) * up)
        thrust = np.clip(np.hypot(side, up), 15.0, 25.0)
        np.testing.assert_allclose(flown[f"thrust{i}_applied"], thrust, rtol=1e-13)
        np.testing.assert_allclose(
            flown[f"attitude{i}_applied"], np.arctan2(side, up), rtol=0, atol=1e-14
        )
        cut.append((side != run[f"u{2 * i - 1}"]) | (np.abs(thrust - np.hypot(side, up)) > 1e-12))
    # The law learns at each instant whether its last command was cut.
    expected = np.stack(cut, axis=1)
    np.testing.assert_array_equal(np.array(seen)[1:], expected[:-1])
    assert seen[0] == (False, False)
    assert 0 < expected[:, 0].mean() < 1
    assert not expected[:, 1].any()


def test_rotors_do_not_pull_down_and_nothing_turns_sideways_for_it():
    """A command below minus the gravity share asks for no thrust, not for thrust to the side."""

    def dive(m):
        return (1e-9, -80.0, -1e-9, -80.0)

    run = ml.simulate(with_actuators(duration=0.3, thrust_max=100.0, tilt_max=0.5), dive)
    for i in (1, 2):
        assert run[f"u{2 * i - 1}_applied"] == pytest.approx(0.0, abs=1e-12)
        assert run.thrust_attitude()[f"thrust{i}_applied"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", ["sim1", "sim2"])
def test_limits_that_are_never_reached_change_nothing(name):
    ideal = ml.simulate(with_actuators(name, duration=10.0))
    limited = ml.simulate(with_actuators(name, duration=10.0, thrust_max=1e6))
    # The command passes through thrust and attitude and back, which rounds it.
    np.testing.assert_allclose(coordinates(limited), coordinates(ideal), rtol=0, atol=1e-11)
    np.testing.assert_allclose(commands(limited), commands(ideal), rtol=0, atol=1e-10)
