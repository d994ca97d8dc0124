"""The momentum-coupled law: its equations, its energy audit, its linearisation."""

import multilift as ml
import numpy as np
import pytest
from multilift import _core, linear
from multilift.models.planar import loop
from planar_runs import SHIPPED, UNLIKE

LAW = "momentum_coupled"
FLOWN = {"goal.allow_mismatch": True, "simulation.duration": 5.0}


def written_out(plant, gains, goal, lead, q, q_dot):
    """docs/momentum-law, from the bodies' places."""
    m1, m2, m3 = *plant["vehicle_mass"], plant["bar_mass"]

    def swing(x):
        (l1, l2), l3 = plant["cable_length"], plant["bar_half_thickness"]
        s, c = np.sin(x), np.cos(x)
        return np.array(
            [l1 * s[0] - l2 * s[1] + 2 * l3 * s[2],
             l1 * (1 - c[0]) + l2 * (1 - c[1]) + 2 * l3 * (1 - c[2])]
        )  # fmt: skip

    def centre(vehicles, of_swing):
        bar = 0.5 * (vehicles[0] + vehicles[1] + of_swing)
        return (m1 * vehicles[0] + m2 * vehicles[1] + m3 * bar) / (m1 + m2 + m3)

    error, rate = q[:4].reshape(2, 2) - goal, q_dot[:4].reshape(2, 2)
    h = 1e-6
    swing_rate = (swing(q[4:] + h * q_dot[4:]) - swing(q[4:] - h * q_dot[4:])) / (2 * h)
    follow = lead / (1 + lead)
    y = error - follow * centre(error, swing(q[4:]))
    y_dot = rate - follow * centre(rate, swing_rate)
    k_p, k_d = np.array(gains.k_p), np.array(gains.k_d)
    y_p, y_d = ((k * x).sum(0) / k.sum(0) for k, x in ((k_p, y), (k_d, y_dot)))
    return (-k_p * (y + lead * y_p) - k_d * (y_dot + lead * y_d)).ravel()


def test_the_compiled_law_is_its_equations():
    changes = UNLIKE | {"controller.k_p": [[5.0, 6.0], [5.5, 6.5]],
                        "controller.k_d": [[6.0, 7.0], [6.5, 7.5]]}  # fmt: skip
    scenario = ml.load("sim1").with_law(LAW).with_values(changes)
    plant = scenario.values["plant"]
    (m1, m2), m3 = plant["vehicle_mass"], plant["bar_mass"]
    lead = 4 * scenario.controller.k_lambda * (m1 + m2 + m3) / ((m1 + m2) * m3)
    rng = np.random.default_rng(7)
    for _ in range(50):
        q, q_dot = rng.uniform(-0.8, 0.8, 7), rng.uniform(-1, 1, 7)
        law = _core.PlanarLaw(
            LAW, scenario.gain_values(), scenario.assumed_values(),
            scenario.goal_vector().tolist(), scenario.control_period(),
        )  # fmt: skip
        goal = scenario.goal_vector().reshape(2, 2)
        expected = written_out(plant, scenario.controller, goal, lead, q, q_dot)
        # Central differences of the swing: h^2 of truncation, eps / h of rounding, times gains.
        assert law.step(q.tolist(), q_dot.tolist()) == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("values", [{}, UNLIKE])
@pytest.mark.parametrize("name", ["sim1", "exp1_1"])
def test_no_internal_force_feeds_it_and_the_audit_closes(name, values):
    run = ml.simulate(ml.load(name).with_values(values | FLOWN), LAW)
    assert run.audit["internal_force"] == 0.0
    assert (run["power_dissipation"] <= 0.0).all()
    # Simpson's rule on what RK4 flies: of order four; steps of 1 ms leave less than this of 10 J.
    assert run.audit["largest_integration_error"] < 1e-8


def test_where_the_papers_storage_rises_this_one_does_not():
    uneven = ml.load("sim1").with_values(
        {"plant.vehicle_mass": [2.0, 1.0], "goal.vehicle_position": [[4.8, 2.0], [6.6, 2.0]]}
    )
    papers, ours = ml.simulate(uneven), ml.simulate(uneven, LAW)
    assert papers.metrics["storage_rise"] > 0.3
    # What remains is the sampling at 1 kHz, (T18), a thousandth and less of what is stored.
    assert ours.metrics["storage_rise"] < 1e-3 * ours.audit["storage_start"]


def test_along_a_way_the_audit_closes_too():
    way = {"reference.kind": "flat", **UNLIKE}
    way |= {"goal.vehicle_position": [[0.5, 2.6], [2.3, 3.0]], "goal.allow_mismatch": False,
            "start.vehicle_position": [[0.0, 2.0], [1.8, 2.4]]}  # fmt: skip
    run = ml.simulate(ml.load("sim1").with_values(way | {"simulation.duration": 5.0}), LAW)
    assert run.audit["internal_force"] == 0.0
    assert abs(run.audit["reference"]) > 1e-3
    assert run.audit["largest_integration_error"] < 1e-8


@pytest.mark.parametrize("law", ["energy_coupled", "pd", LAW])
@pytest.mark.parametrize("name", SHIPPED)
def test_dual_numbers_through_plant_and_law_are_finite_differences(name, law):
    scenario = ml.load(name).with_law(law)
    exact = loop.loop(scenario).ideal_matrix()
    differences = linear.closed_loop_matrix(scenario)
    # Rounding of central differences with h = 1e-6, over the bar's small moment.
    scale = np.abs(differences).max()
    np.testing.assert_allclose(exact, differences, rtol=0, atol=1e-8 * scale)
    assert np.linalg.eigvals(exact).real.max() < 0.0


_NOT_CLOSED = "1.1e-7 J are left that do not shrink with the step: cause unknown"


@pytest.mark.parametrize(
    "name",
    ["uneven_four",
     pytest.param("platform_turn", marks=pytest.mark.xfail(reason=_NOT_CLOSED, strict=True))],
)  # fmt: skip
def test_in_space_the_audit_closes(name):
    scenario = ml.load(name).with_values({"simulation.duration": 2.0})
    ours, papers = ml.simulate(scenario, LAW), ml.simulate(scenario)
    assert ours.status == papers.status == "finished"
    assert ours.audit["internal_force"] == 0.0
    errors = [run.audit["largest_integration_error"] for run in (ours, papers)]
    # The same quadrature on the same motion but for the law: what it leaves is alike.
    assert errors[0] < 3 * errors[1] + 1e-12
