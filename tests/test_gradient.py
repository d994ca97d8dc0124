"""Derivatives by dual numbers against differences of the simulation itself."""

import itertools

import multilift as ml
import numpy as np
import pytest
from multilift.isa import VARIABLE, available
from multilift.models.planar import quantities
from multilift.models.planar.gradient import WITHOUT_DERIVATIVE, numbers, tangent
from multilift.models.planar.quantities import FINAL_STATE

# Unlike numbers everywhere, so that no derivative is zero or right by symmetry. The half sine
# begins and ends between the integrator's instants: at them its derivative has a kink.
GENERAL = {
    "plant.vehicle_mass": [2.0, 2.3],
    "plant.cable_length": [1.8, 1.7],
    "plant.bar_inertia": 0.1,
    "plant.vehicle_drag": [[0.1, 0.2], [0.15, 0.12]],
    "plant.swing_damping": [0.02, 0.03, 0.04],
    "start.vehicle_position": [[0.8, 2.0], [2.55, 1.95]],
    "start.vehicle_velocity": [[0.0, 0.0], [0.0, 0.0]],
    "start.angle_rate": [0.0, 0.0, 0.0],
    "goal.vehicle_position": [[1.2, 3.5], [2.95, 3.45]],
    "goal.allow_mismatch": True,
    "controller.assumed": {"bar_mass": 0.9, "cable_length": [1.75, 1.75]},
    "controller.k_i": 0.3,
    "controller.integral_limit": [[0.4, 1e3], [1e3, 0.5]],
    "controller.d_hat_start": 0.05,
    "controller.rate": 100.0,
    "push": [
        {"body": "bar", "start": 0.2, "duration": 0.5, "force": [1.0, 0.3], "torque": 0.1},
        {"body": "vehicle_2", "start": 0.3502, "duration": 0.80005, "force": [0.5, 0.2],
         "shape": "half_sine"},
        {"body": "vehicle_1", "start": 0.1, "duration": 1.1, "force": [0.3, 0.2],
         "shape": "sine", "frequency": 1.7},
    ],
    "simulation.duration": 2.0,
}  # fmt: skip
TESTBED = {
    "actuators": {
        "thrust_min": 21.0, "thrust_max": 31.0, "tilt_max": 0.12, "thrust_time_constant": 0.05,
        "attitude_time_constant": 0.1, "command_delay": 0.02,
    },
    "sensors": {
        "period": 0.01, "delay": 0.01, "position_noise": 5e-4, "velocity_noise": 0.01,
        "angle_noise": 2e-3, "angle_rate_noise": 0.02,
    },
}  # fmt: skip

#: Worlds of a difference: f(x + h) - f(x - h) at h and 2h, extrapolated to order h^4.
OFFSETS = np.array([1.0, -1.0, 2.0, -2.0])

#: Quantities with kinks: a greatest value passes from one instant to the next, |theta| through 0.
#: Their differences are taken a hundred times closer, so that none is likely to lie between.
KINKED = {
    "peak_swing_1", "peak_swing_2", "peak_swing_3", "overshoot", "swing_integral", "peak_thrust",
    "peak_tilt", "min_tension", "storage_rise", "audit.largest_integration_error",
}  # fmt: skip


def scenario_of(law, *tables):
    scenario = ml.load("sim1").with_law(law)
    return scenario.with_values({k: v for table in tables for k, v in table.items()})


def scalar_keys(scenario):
    """Every scalar of the scenario that the simulation reads, with index."""
    _, sources = numbers(scenario)
    keys = dict.fromkeys(itertools.chain.from_iterable(map(sorted, sources)))
    on_points = [k for k, p in enumerate(scenario["push"]) if p["body"] != "bar"]
    # A torque on a point mass is refused.
    return [key for key in keys if key not in {f"push[{k}].torque" for k in on_points}]


def differentiable(scenario):
    keys = []
    for key in scalar_keys(scenario):
        try:
            tangent(scenario, key, numbers(scenario)[1])
        except ml.ScenarioError:
            continue
        keys.append(key)
    return keys


def value_of(scenario, key):
    values, sources = numbers(scenario)
    return next(x for x, names in zip(values, sources, strict=True) if key in names)


def differences(scenario, key, widths):
    """Derivatives along a key by differences of each width, by name."""
    x = value_of(scenario, key)
    offsets = np.multiply.outer(widths, OFFSETS)
    batch = ml.simulate_batch(scenario, {key: x + offsets.ravel()}, threads=1)
    assert set(batch.status) == {"finished"}
    columns = dict(zip(FINAL_STATE, batch.final_state.T, strict=True))
    columns |= batch.metrics | {f"audit.{k}": v for k, v in batch.audit.items()}
    result = {}
    for name, values in columns.items():
        f = values.reshape(len(widths), 4).T
        result[name] = (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12 * np.array(widths))
    return result


def width_of(scenario, key):
    """Half the width of a difference: a 1e-4 part of the number, or what changes as much."""
    if key.startswith(("start.angle", "start.vehicle_velocity")):
        return 2e-7  # the closure and its rate are checked to 1e-6 m and m/s
    if key.startswith("sensors."):
        return 1e-3 * value_of(scenario, key)
    return 1e-4 * max(abs(value_of(scenario, key)), 0.1)


@pytest.mark.parametrize("law", ["energy_coupled", "pd"])
@pytest.mark.parametrize("tables", [(GENERAL,), (GENERAL, TESTBED)], ids=["ideal", "testbed"])
def test_derivatives_along_every_key_are_those_of_differences(law, tables):
    scenario = scenario_of(law, *tables)
    keys = [k for k in differentiable(scenario) if tables[-1] is TESTBED or k[:9] != "actuators"]
    assert len(keys) > 70
    exact = ml.gradient(scenario, keys)
    assert exact.status == "finished"
    wrong = []
    for k, key in enumerate(keys):
        widths = width_of(scenario, key) * np.array([1.0, 0.01])
        for name, by_width in differences(scenario, key, widths).items():
            if name in WITHOUT_DERIVATIVE:
                continue
            found, which = exact[name][k], int(name in KINKED)
            # Differences know a derivative to the rounding of a run of 2000 steps over their width;
            # beyond that to order h^4, which leaves less than the relative part.
            rounding = 3e-13 * max(1.0, abs(exact.values[name])) / widths[which]
            if not np.isclose(found, by_width[which], rtol=2e-6, atol=rounding):
                wrong.append((key, name, float(found), by_width))
    assert not wrong, "\n".join(map(str, wrong))


def test_a_start_with_given_angles_is_differentiated_along_them():
    resting = scenario_of("energy_coupled", GENERAL)
    scenario = resting.with_values({"start.angle": resting.q_start[4:].tolist()})
    keys = [f"start.angle[{k}]" for k in range(3)] + ["start.vehicle_position[0][0]"]
    exact = ml.gradient(scenario, keys)
    for k, key in enumerate(keys):
        h = 2e-7  # the closure is checked to 1e-6 m
        for name, (expected,) in differences(scenario, key, [h]).items():
            if name not in WITHOUT_DERIVATIVE and name not in KINKED:
                np.testing.assert_allclose(
                    exact[name][k], expected, rtol=2e-6,
                    atol=3e-13 * max(1.0, abs(exact.values[name])) / h, err_msg=f"{name}, {key}",
                )  # fmt: skip


def test_the_rest_angles_follow_the_plant_and_the_positions():
    # A run of one step that is all but the start: rest angles of an uneven linkage.
    scenario = scenario_of("pd", GENERAL, {"simulation.duration": 0.001, "controller.rate": 1000.0})
    keys = ["plant.bar_length", "plant.cable_length[0]", "start.vehicle_position[1][0]"]
    exact = ml.gradient(scenario, keys)
    assert np.abs(exact["theta1"]).min() > 0.01
    for k, key in enumerate(keys):
        found = differences(scenario, key, [1e-4])
        for name in ("theta1", "theta2", "theta3", "bar_y", "bar_z"):
            np.testing.assert_allclose(exact[name][k], found[name], rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("tables", [(GENERAL,), (GENERAL, TESTBED)], ids=["ideal", "testbed"])
def test_values_are_those_of_simulate_to_the_last_bit(tables):
    scenario = scenario_of("energy_coupled", *tables)
    run = ml.simulate(scenario)
    exact = ml.gradient(scenario, "plant.bar_mass")
    assert (exact.status, exact.end_time) == (run.status, run.end_time)
    for name in quantities.METRICS:
        np.testing.assert_equal(exact.values[name], run.metrics[name])
    for name in quantities.AUDIT:
        assert exact.values[f"audit.{name}"] == run.audit[name]
    for name in ("bar_y", "bar_z", "theta1", "theta2", "theta3", "theta1_dot"):
        assert exact.values[name] == run[name][-1]


def test_derivatives_have_the_same_bits_on_every_instruction_set(monkeypatch):
    scenario = scenario_of("energy_coupled", GENERAL, TESTBED)
    keys = differentiable(scenario)[:19]
    results = []
    for name in available():
        monkeypatch.setenv(VARIABLE, name)
        results.append(ml.gradient(scenario, keys))
    for result in results[1:]:
        for name in result.values:
            np.testing.assert_array_equal(result[name], results[0][name])


def test_keys_do_not_depend_on_their_company():
    scenario = scenario_of("energy_coupled", GENERAL)
    keys = [k for k in differentiable(scenario) if k.startswith(("plant", "push"))][:21]
    together = ml.gradient(scenario, keys)
    for k in (0, 7, 8, 20):
        alone = ml.gradient(scenario, keys[k])
        for name in together.values:
            np.testing.assert_array_equal(alone[name], together[name][k : k + 1])


def test_a_key_of_several_numbers_is_all_of_them_growing_together():
    scenario = scenario_of("pd", GENERAL)
    each = [f"controller.k_d[{i}][{j}]" for i in range(2) for j in range(2)]
    exact = ml.gradient(scenario, ["controller.k_d", "controller.k_d[1]", *each])
    np.testing.assert_allclose(exact.final_state[:, 0], exact.final_state[:, 2:].sum(1), rtol=1e-12)
    np.testing.assert_allclose(exact.final_state[:, 1], exact.final_state[:, 4:].sum(1), rtol=1e-12)


def test_settling_times_have_no_derivative():
    exact = ml.gradient(ml.load("sim1"), "controller.k_lambda")
    for name in WITHOUT_DERIVATIVE:
        assert np.isfinite(exact.values[name])
        assert np.isnan(exact.metrics[name]).all()
    others = [exact[n] for n in exact.values if n not in WITHOUT_DERIVATIVE]
    assert np.isfinite(others).all()
    assert exact.final_state.shape == (10, 1)


def test_a_run_that_ends_early_is_differentiated_at_its_end():
    push = [{"body": "bar", "start": 0.2, "duration": 0.9, "force": [4.0, 14.0]}]
    scenario = ml.load("sim1").with_values({"push": push, "simulation.duration": 1.5})
    exact = ml.gradient(scenario, "push[0].force[0]")
    assert exact.status == "slack"
    held = scenario.with_values({"simulation.duration": exact.end_time - 0.001})
    before = ml.gradient(held, "push[0].force[0]")
    np.testing.assert_allclose(exact.final_state, before.final_state, atol=0.1)
    assert np.isfinite(exact.final_state).all()


def test_another_law_and_tables():
    scenario = ml.load("sim1")
    exact = ml.gradient(scenario, ["plant.bar_mass", "controller.k_p"], controller="pd")
    assert exact.scenario.law == "pd"
    table = exact.to_dataframe()
    assert list(table.index) == ["plant.bar_mass", "controller.k_p"]
    assert table.loc["plant.bar_mass", "peak_swing_1"] == exact.metrics["peak_swing_1"][0]
    assert table.loc["controller.k_p", "audit.dissipation"] == exact.audit["dissipation"][1]
    with pytest.raises(ml.ControllerError, match="compiled laws"):
        ml.gradient(scenario, "plant.bar_mass", controller="law.py:law")


@pytest.mark.parametrize(
    ("key", "reason"),
    [
        ("controller.rate", "counts integration steps"),
        ("simulation.step", "counts integration steps"),
        ("simulation.seed", "no quantity"),
        ("actuators.command_delay", "counts integration steps"),
        ("actuators.thrust_time_constant", "below one step"),
        ("sensors.angle_noise", "without noise"),
        ("start.angle", "starts at rest"),
        ("start.angle[1]", "starts at rest"),
        ("push[0].start", "jump"),
        ("push[2].duration", "jump"),
        ("push[1].frequency", "sine"),
        ("push[3].force", "not the key"),
        ("plant.bar_mas", "not the key"),
        ("plant.model", "not the key"),
        ("plant.vehicle_mass[2]", "not the key"),
        ("plant", "not the key"),
        ("controller.k_lambda", "not the key"),
        ("", "not the key"),
    ],
)
def test_keys_without_a_derivative_are_refused_with_the_reason(key, reason):
    scenario = scenario_of("pd", GENERAL)
    with pytest.raises(ml.ScenarioError, match=reason) as error:
        ml.gradient(scenario, ["plant.bar_mass", key])
    assert error.value.key == key
