"""The compiled laws against their equations, and what their integral action does."""

from dataclasses import replace

import multilift as ml
import numpy as np
import pytest
from multilift import _core
from planar_runs import COMPILED, SHIPPED, at_every_step, commands, coordinates


class EnergyCoupled:
    """Equations (47), (48), (51), (55) and Remark 6 as the paper states them."""

    def __init__(self, scenario):
        control, plant = scenario.controller, scenario["controller.assumed"]
        self.k_p, self.k_d, self.k_i = control.k_p, control.k_d, control.k_i
        self.k_lambda = getattr(control, "k_lambda", 0.0)
        self.gamma, self.limit = control.gamma, control.integral_limit
        self.l1, self.l2 = plant["cable_length"]
        self.l3, self.mass = plant["bar_half_thickness"], np.array(plant["vehicle_mass"])
        self.period = scenario.control_period()
        self.d_hat, self.integral = control.d_hat_start.copy(), np.zeros((2, 2))

    def step(self, m):
        s, c = np.sin(m.theta), np.cos(m.theta)
        w = m.theta_dot
        swing = np.array(
            [
                self.l1 * s[0] - self.l2 * s[1] + 2 * self.l3 * s[2],
                self.l1 * (1 - c[0]) + self.l2 * (1 - c[1]) + 2 * self.l3 * (1 - c[2]),
            ]
        )
        swing_dot = np.array(
            [
                self.l1 * c[0] * w[0] - self.l2 * c[1] * w[1] + 2 * self.l3 * c[2] * w[2],
                self.l1 * s[0] * w[0] + self.l2 * s[1] * w[1] + 2 * self.l3 * s[2] * w[2],
            ]
        )
        coupling = self.k_lambda / self.mass[:, None]
        eps = m.xi - m.goal - coupling * swing
        eps_dot = m.xi_dot - coupling * swing_dot
        u = -self.k_p * eps - self.k_d * eps_dot + m.xi_dot * self.d_hat + self.integral
        self.d_hat = self.d_hat - self.period * self.gamma * m.xi_dot * eps_dot
        wanted = np.clip(self.integral - self.period * self.k_i * eps, -self.limit, self.limit)
        rests = np.array(m.saturated)[:, None] & (np.abs(wanted) > np.abs(self.integral))
        self.integral = np.where(rests, self.integral, wanted)
        return u.ravel()


# Every gain different on every axis, a law that errs about its plant, integral action to its limit.
PECULIAR = {
    "controller.k_p": [[5.0, 6.0], [5.5, 6.5]],
    "controller.k_d": [[6.0, 7.0], [6.5, 7.5]],
    "controller.gamma": [[0.6, 0.7], [0.8, 0.9]],
    "controller.d_hat_start": [[0.1, -0.2], [0.3, 0.4]],
    "controller.k_i": [[0.8, 1.0], [1.2, 1.4]],
    "controller.integral_limit": [[0.6, 0.9], [0.5, 0.8]],
    "controller.assumed": {
        "vehicle_mass": [1.3, 1.7], "cable_length": [1.0, 1.2], "bar_half_thickness": 0.2,
    },
}  # fmt: skip
TIGHT = {"actuators.thrust_max": 18.0, "actuators.tilt_max": 0.05}


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize(
    ("name", "values"),
    [*((name, {}) for name in SHIPPED), ("sim1", PECULIAR), ("exp1_1", PECULIAR | TIGHT)],
    ids=[*SHIPPED, "sim1 peculiar", "exp1_1 peculiar and saturated"],
)
def test_compiled_laws_are_their_equations(name, values, law):
    scenario = ml.load(name).with_law(law).with_values(values | {"simulation.duration": 12.0})
    compiled, written_out = ml.simulate(scenario), ml.simulate(scenario, EnergyCoupled)
    assert compiled.end_time == written_out.end_time == 12.0
    # Round-off alone: the closed loop is stable and forgets it.
    np.testing.assert_allclose(coordinates(written_out), coordinates(compiled), rtol=0, atol=1e-11)
    np.testing.assert_allclose(commands(written_out), commands(compiled), rtol=0, atol=1e-10)


def test_the_saturated_case_saturates_and_reaches_the_integral_limits():
    run = ml.simulate(ml.load("exp1_1").with_values(PECULIAR | TIGHT))
    assert np.abs(commands(run) - applied(run)).max() > 0.5  # N
    u = step_by_hand("energy_coupled", [(False, False)] * 4000, PECULIAR)
    assert (u[-1] - u[0]).tolist() == pytest.approx([0.6, 0.9, 0.5, 0.8], rel=1e-9)


def applied(run):
    return np.stack([run[f"u{k}_applied"] for k in range(1, 5)], axis=1)


@pytest.mark.parametrize("name", SHIPPED)
def test_without_coupling_the_law_is_pd_to_the_last_bit(name):
    scenario = ml.load(name)
    uncoupled = ml.simulate(scenario.with_values({"controller.k_lambda": 0.0}))
    pd = ml.simulate(scenario, "pd")
    for column in pd.columns:
        np.testing.assert_array_equal(uncoupled[column], pd[column], err_msg=column)
    np.testing.assert_equal(uncoupled.metrics, pd.metrics)  # NaN, of what does not settle, is NaN
    assert uncoupled.audit == pd.audit


@pytest.mark.parametrize("name", ["sim1", "sim2"])
def test_drag_estimates_under_pd_only_fall(name):
    # (72) with the true velocity: d_hat_dot = -gamma velocity^2.
    run = ml.simulate(at_every_step(ml.load(name)), "pd")
    for axis in ("y1", "z1", "y2", "z2"):
        moved = run[f"d_hat_{axis}"]
        speed = run[f"{axis}_dot"]
        gamma = run.scenario.controller.gamma[0, "yz".index(axis[0])]
        np.testing.assert_allclose(np.diff(moved), -0.001 * gamma * speed[:-1] ** 2, atol=1e-15)


def test_commands_and_estimates_are_held_between_control_instants():
    scenario = at_every_step(ml.load("sim1").with_values({"controller.rate": 50.0}))
    run = ml.simulate(scenario)
    for name in ("u1", "u2", "u3", "u4", "d_hat_y1", "d_hat_z1", "d_hat_y2", "d_hat_z2"):
        periods = run[name][:-1].reshape(-1, 20)
        np.testing.assert_array_equal(periods, np.repeat(periods[:, :1], 20, axis=1))
        assert (np.diff(periods[1:20, 0]) != 0).all()


# Integral action (Remark 6).

WIND = [1.2, -0.8]  # N, on each vehicle, for good
STEADY = {
    "start.vehicle_position": [[1.2, 3.5], [3.0, 3.5]],
    "simulation.duration": 80.0,
    "push": [
        {"body": f"vehicle_{i}", "start": 0.0, "duration": 1e3, "force": WIND} for i in (1, 2)
    ],
}


@pytest.mark.parametrize("law", COMPILED)
def test_a_steady_push_leaves_an_offset_that_integral_action_removes(law):
    scenario = ml.load("sim1").with_law(law).with_values(STEADY)
    goal = scenario.goal_vector()
    # At rest the load hangs straight, and the spring balances the push.
    offset = np.array(WIND * 2) / np.ravel(scenario.controller.k_p)
    without = ml.simulate(scenario)
    np.testing.assert_allclose(coordinates(without)[-1, :4], goal + offset, rtol=0, atol=1e-6)
    cured = ml.simulate(scenario.with_values({"controller.k_i": 1.0}))
    np.testing.assert_allclose(coordinates(cured)[-1, :4], goal, rtol=0, atol=1e-6)


def step_by_hand(law, saturated, values, offset=-0.5):
    """Commands of a law that is told the same every time, shape (n, 4).

    Vehicles at rest, off their goal by `offset` along both axes, or by one offset per step.
    """
    scenario = ml.load("sim1").with_law(law).with_values(values)
    goal = scenario.goal_vector()
    stepped = _core.PlanarLaw(
        law, scenario.gain_values(), scenario.assumed_values(), goal.tolist(), 0.001
    )
    offsets = np.broadcast_to(offset, len(saturated))
    return np.array(
        [
            stepped.step([*(goal + e), 0.0, 0.0, 0.0], [0.0] * 7, flags)
            for e, flags in zip(offsets, saturated, strict=True)
        ]
    )


@pytest.mark.parametrize("law", COMPILED)
def test_the_integral_rests_while_its_vehicle_is_saturated_but_may_unwind(law):
    gains = {"controller.k_i": 2.0}
    per_step = 2.0 * 0.001 * 0.5  # N: k_i * period * offset
    flags = [(False, False)] * 10 + [(True, False)] * 10 + [(True, True)] * 10
    u = step_by_hand(law, flags, gains)
    grown = np.diff(u, axis=0)
    # What a step integrates shows in the next command.
    for vehicle, resting_from in ((slice(0, 2), 10), (slice(2, 4), 20)):
        np.testing.assert_allclose(grown[:resting_from, vehicle], per_step, rtol=1e-9)
        np.testing.assert_array_equal(grown[resting_from:, vehicle], 0.0)
    # An error of the other sign takes the integral back, saturated or not.
    turned = step_by_hand(law, flags, gains, offset=np.repeat([-0.5, 0.5], [15, 15]))
    np.testing.assert_allclose(np.diff(turned, axis=0)[15:24], -per_step, rtol=1e-9)


class Winding(EnergyCoupled):
    """The same law without that protection."""

    def step(self, m):
        return super().step(replace(m, saturated=(False, False)))


@pytest.mark.parametrize("law", COMPILED)
def test_saturation_does_not_wind_the_integral_up(law):
    # Thrust that can barely lift makes the climb of 1.5 m slow. What the integral gathers
    # meanwhile would carry the vehicles past the goal; at rest it gathers nothing, so they pass it
    # by no more than without limits.
    values = {"controller.k_i": 2.0, "controller.rate": 200.0, "simulation.duration": 30.0}
    scenario = ml.load("sim1").with_law(law).with_values(values)
    weak = scenario.with_values({"actuators.thrust_max": 23.8})
    limited, free = ml.simulate(weak), ml.simulate(scenario)
    held_down = np.mean(commands(limited)[:, 1] - applied(limited)[:, 1] > 1e-9)
    assert held_down > 0.1
    assert limited.metrics["overshoot"] <= free.metrics["overshoot"]
    winding = ml.simulate(weak, Winding)
    assert winding.metrics["overshoot"] > 2 * limited.metrics["overshoot"]
