"""Rollouts against an adaptive integration of the redundant equations."""

import sys

import multilift as ml
import numpy as np
import pytest
from multilift import reference
from planar_runs import UNLIKE, commands, coordinates, no_force, rates, released
from scipy.special import ellipj

RATE = 50.0  # Hz; its period leaves room for several integration steps
STEPS = (0.01, 0.005, 0.0025)  # s

# Pushes of every shape on every body, with edges and corners on the grid of the longest step but
# off the control instants.
PUSHES = [
    {"body": "bar", "start": 0.11, "duration": 0.5, "force": [1.5, 0.7], "torque": 0.4},
    {"body": "vehicle_1", "start": 0.33, "duration": 0.7, "force": [0.8, -1.1],
     "shape": "half_sine"},
    {"body": "vehicle_2", "start": 0.51, "duration": 1.2, "force": [-1.3, 0.9], "shape": "sine",
     "frequency": 0.8},
    {"body": "bar", "start": 0.75, "duration": 0.9, "force": [0.6, 0.0], "torque": -0.3,
     "shape": "samples", "sample_times": [0.05, 0.15, 0.7], "sample_values": [1.0, -2.0, 1.5]},
]  # fmt: skip
LIGHTER = {"vehicle_mass": [1.9, 1.7], "bar_mass": 0.6}


def leaning_law(m):
    """Some law of one's own that depends on everything it is told."""
    return [
        -5.0 * (m.xi[i] - m.goal[i])[k] - 6.0 * m.xi_dot[i][k] + 0.5 * m.theta[i] + m.theta_dot[2]
        for i in range(2)
        for k in range(2)
    ] + np.sin(m.t)


CASES = {
    "sim1": ("sim1", {}, None),
    "sim2 under PD": ("sim2", {}, "pd"),
    "pushes": ("sim1", {"push": PUSHES}, None),
    "unlike vehicles, mismatched goals": ("sim2", UNLIKE, None),
    "both, and integral action": (
        "sim1", UNLIKE | {"push": PUSHES, "controller.k_i": 0.8}, None,
    ),
    "wrong masses assumed": ("sim1", {"controller.assumed": LIGHTER}, None),
    "a Python law": ("sim2", UNLIKE | {"controller.assumed": LIGHTER}, leaning_law),
}  # fmt: skip


def case(name):
    base, values, law = CASES[name]
    timing = {
        "simulation.duration": 2.0,
        "simulation.record_period": 1 / RATE,
        "controller.rate": RATE,
    }
    return ml.load(base).with_values(timing | values), law


@pytest.mark.parametrize("name", CASES)
def test_rollouts_differ_from_the_reference_by_the_error_of_rk4_alone(name):
    scenario, law = case(name)
    truth = reference.solve(scenario, law)
    assert truth.closure_drift < 1e-13
    for quantity, expected in ((coordinates, truth.q), (rates, truth.q_dot), (commands, truth.u)):
        errors = []
        for step in STEPS:
            run = ml.simulate(scenario.with_values({"simulation.step": step}), law)
            np.testing.assert_allclose(run.t, truth.t, atol=1e-12)
            errors.append(np.abs(quantity(run) - expected).max())
        # Of order 4: a step of half the length leaves a 16th, up to terms of the next order,
        # whose share of the error is of the size of the step over the motion's own time.
        ratios = np.divide(errors[:-1], errors[1:])
        assert (np.abs(ratios - 16) < 1.0).all(), (quantity.__name__, errors)


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name][2] is not leaning_law])
def test_drag_estimates_are_those_of_the_reference(name):
    scenario, law = case(name)
    truth = reference.solve(scenario, law)
    run = ml.simulate(scenario, law)
    d_hat = np.stack([run[f"d_hat_{axis}"] for axis in ("y1", "z1", "y2", "z2")], axis=1)
    assert np.ptp(truth.d_hat, axis=0).min() > 1e-3  # they move
    np.testing.assert_allclose(d_hat, truth.d_hat, rtol=0, atol=1e-11)


def test_reference_keeps_its_accuracy_over_intervals_of_many_steps():
    # Two equal vehicles that move alike and a bar on their line of cables' ends are a pendulum,
    # solved by Jacobi's elliptic functions (derived in test_closed_forms.py).
    mass, bar_mass, length, gravity, amplitude = 2.0, 0.8, 1.8, 9.8, 1.2
    plant = {
        "vehicle_mass": mass, "cable_length": [length, length], "bar_mass": bar_mass,
        "bar_length": 1.8, "bar_half_thickness": 0.0, "gravity": gravity,
    }  # fmt: skip
    q = [0.0, 0.0, 1.8, 0.0, amplitude, -amplitude, 0.0]
    scenario = released(plant, q, np.zeros(7), 6.0, controller={"rate": 0.5})
    run = reference.solve(scenario, no_force)
    modulus = np.sin(amplitude / 2)
    pace = np.sqrt(gravity / length * (1 + bar_mass / (2 * mass)))
    _, cn, dn, _ = ellipj(pace * run.t, modulus**2)
    exact = 2 * np.arcsin(modulus * cn / dn)
    np.testing.assert_allclose(run.t, [0, 2, 4, 6], atol=1e-15)
    np.testing.assert_allclose(run.q[:, 4], exact, rtol=0, atol=1e-10)
    np.testing.assert_allclose(run.q[:, 5], -exact, rtol=0, atol=1e-10)
    assert np.isnan(run.d_hat).all()


def test_only_ideal_actuators_and_sensors_are_accepted():
    with pytest.raises(ml.ScenarioError, match="leave out \\[actuators\\] and \\[sensors\\]"):
        reference.solve(ml.load("exp2"))


def test_a_singular_state_is_named():
    # Cables that point at the centre of mass of a bar without inertia cannot turn it.
    quarter = np.pi / 4
    plant = {
        "vehicle_mass": 2.0, "cable_length": [1.0, 1.0], "bar_mass": 0.8, "bar_length": 1.0,
        "bar_half_thickness": 0.5,
    }  # fmt: skip
    reach = 0.5 + np.sin(quarter)
    q = [-reach, 0.0, reach, 0.0, quarter, quarter, 0.0]
    scenario = released(plant, q, np.zeros(7), 1.0)
    with pytest.raises(ml.MultiliftError, match="singular state at t = 0 s"):
        reference.solve(scenario, no_force)


def test_missing_scipy_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.integrate", None)
    with pytest.raises(ml.MissingExtraError, match="multilift\\[reference\\]"):
        reference.solve(ml.load("sim1"))
