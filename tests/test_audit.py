"""The energy audit of whole runs, and the storage function that it follows."""

import multilift as ml
import numpy as np
import pytest
from multilift.models.planar import quantities
from planar_runs import COMPILED, SHIPPED, UNLIKE
from scipy.integrate import simpson

ENTRIES = {  # of the audit, by the column of their power
    "power_dissipation": "dissipation",
    "power_internal_force": "internal_force",
    "power_push": "push",
    "power_actuation": "actuation",
    "power_adaptation": "adaptation",
}
# Unlike vehicles on their way to a goal that deforms the formation, pushed smoothly.
EVERYTHING = UNLIKE | {
    "push": [
        {"body": body, "force": [0.7, -0.9], "torque": torque,
         "start": 0.0, "duration": 1.0, "shape": "half_sine"}
        for body, torque in (("vehicle_1", 0.0), ("vehicle_2", 0.0), ("bar", 0.5))
    ]
}  # fmt: skip


def at_rate(scenario, rate, step, duration, values=()):
    return scenario.with_values(
        {
            "controller.rate": rate,
            "simulation.step": step,
            "simulation.record_period": step,
            "simulation.duration": duration,
        }
        | dict(values)
    )


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_run_closes_its_audit(name, law):
    run = ml.simulate(ml.load(name), law)
    assert run.audit["largest_integration_error"] < 1e-11  # J, of about 10 J that are dissipated


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("values", [{}, EVERYTHING], ids=["sim1", "everything"])
def test_what_the_audit_leaves_is_of_order_four_in_the_step(values, law):
    steps = (0.01, 0.005, 0.0025)
    errors = [
        ml.simulate(at_rate(ml.load("sim1"), 50.0, step, 3.0, values), law).audit[
            "largest_integration_error"
        ]
        for step in steps
    ]
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 16, atol=1.5)


def steady_pull(_):
    return (1.0, 2.0, -1.5, 0.5)


@pytest.mark.parametrize("law", [*COMPILED, steady_pull])
def test_entries_are_the_integrals_of_their_powers(law):
    # One command is held throughout, so that no power jumps and Simpson's rule is of order 4.
    run = ml.simulate(at_rate(ml.load("sim2"), 0.5, 0.001, 1.0, EVERYTHING), law)
    for column, entry in ENTRIES.items():
        assert run.audit[entry] == pytest.approx(simpson(run[column], run.t), abs=1e-10)
    worked = {entry for entry in ENTRIES.values() if abs(run.audit[entry]) > 1e-4}
    # Neither PD nor a law of one's own has the coupling that the internal force works through.
    coupled = law == "energy_coupled"
    assert worked == set(ENTRIES.values()) - (set() if coupled else {"internal_force"})


@pytest.mark.parametrize("law", COMPILED)
def test_sampling_costs_energy_in_proportion_to_the_control_period(law):
    entries = []
    for rate in (500.0, 1000.0, 2000.0):
        audit = ml.simulate(at_rate(ml.load("sim1"), rate, 0.0005, 10.0), law).audit
        entries.append([audit["actuation"], audit["adaptation"]])
    # Halved with the period, up to the next order, some 1e-3 of it.
    np.testing.assert_allclose(np.divide(entries[:-1], entries[1:]), 2.0, atol=0.01)


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("name", ["sim1", "sim2"])
@pytest.mark.parametrize("rate", [1000.0, 5000.0])
def test_storage_never_rises_where_both_vehicles_move_alike(name, law, rate):
    run = ml.simulate(at_rate(ml.load(name), rate, 1 / rate, 15.0), law)
    assert np.diff(run["storage"]).max() < 1e-12  # J
    assert run.metrics["storage_rise"] < 1e-12


def test_storage_may_rise_where_they_do_not():
    run = ml.simulate(at_rate(ml.load("sim1"), 1000.0, 0.001, 15.0, UNLIKE))
    rise = run.metrics["storage_rise"]
    assert rise > 1e-3  # J
    # And it is the internal force that lifts it.
    lifting = np.diff(run["storage"]) > 0
    assert (run["power_internal_force"][1:][lifting] > 0).all()


def test_storage_starts_from_the_errors_of_position_and_estimate():
    scenario = ml.load("sim1").with_values({"controller.d_hat_start": [0.4, 0.3]})
    control, goal, start = scenario.controller, scenario.goal, scenario.start
    error = start.vehicle_position - goal.vehicle_position
    estimate = scenario.plant.vehicle_drag - control.d_hat_start
    expected = 0.5 * np.sum(control.k_p * error**2 + estimate**2 / control.gamma)
    assert ml.simulate(scenario).audit["storage_start"] == pytest.approx(expected, rel=1e-12)


def test_a_law_of_ones_own_is_audited_by_the_mechanical_energy():
    run = ml.simulate(at_rate(ml.load("sim2"), 100.0, 0.01, 1.0, EVERYTHING), steady_pull)
    np.testing.assert_array_equal(run["storage"], run["energy"])


def test_every_entry_is_described():
    assert set(ml.simulate(ml.load("sim1")).audit) == set(quantities.AUDIT)
    assert all(quantity.unit == "J" and quantity.doc for quantity in quantities.AUDIT.values())
