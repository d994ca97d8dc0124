"""Derivatives of spatial runs by dual numbers against differences of rows and of runs."""

import multilift as ml
import numpy as np
import pytest
from multilift.keys import field_of
from multilift.models.spatial import rows
from multilift.models.spatial.gradient import WITHOUT_DERIVATIVE, tangent
from spatial_scenarios import plate

# Unlike numbers everywhere, so that no derivative is zero or right by symmetry.
GENERAL = {
    "plant.vehicle_mass": [1.4, 1.5, 1.6],
    "plant.vehicle_drag": [[0.1, 0.12, 0.2], [0.15, 0.1, 0.1], [0.08, 0.1, 0.12]],
    "plant.cable_length": [1.2, 1.25, 1.15],
    "plant.payload_drag": [0.05, 0.06, 0.07],
    "plant.payload_drag_quadratic": 0.02,
    "plant.payload_spin_damping": [0.01, 0.02, 0.03],
    "formation.azimuth": [0.0, 2.0943951023931953, -2.0943951023931953],
    "start.payload_yaw": 0.3,
    "start.payload_velocity": [0.1, 0.05, 0.0],
    "goal.payload_yaw": 0.5,
    "controller.assumed": {"payload_mass": 1.1},
    "controller.k_i": 0.3,
    "controller.d_hat_start": 0.05,
    "limits.tilt_max": 1.2,
    "wind.mean": [1.0, 0.5, 0.0],
    "push": [{"body": "payload", "start": 0.1002, "duration": 0.40005, "shape": "half_sine",
              "force": [1.0, 0.3, 0.2], "torque": [0.05, 0.02, 0.03]}],
    "simulation.duration": 1.0,
}  # fmt: skip
GENERAL_ELASTIC = {**GENERAL, "plant.cables": "elastic", "plant.cable_damping": 40.0,
                   "plant.cable_stiffness": [2000.0, 2500.0, 1800.0]}  # fmt: skip
CRAFT = {
    **GENERAL, "vehicle.type": "x500", "autopilot.hover_thrust": 0.5,
    "autopilot.thrust_curve": 0.8, "link.delay": 0.01,
    "motion_capture.position_noise": 1e-3, "motion_capture.velocity_noise": 1e-2,
    "motion_capture.attitude_noise": 2e-3, "motion_capture.rate_noise": 1e-2,
}  # fmt: skip
#: Vehicles start lower, so that cables are slack, then jerk taut one after the other.
JERKED = {**GENERAL, "controller.k_i": 0.0, "plant.cable_restitution": 0.3}

KEYS = (
    "plant.payload_mass", "plant.gravity", "plant.payload_inertia[1]", "plant.vehicle_mass[1]",
    "plant.cable_length[0]", "plant.attachment[2][1]", "plant.vehicle_drag[0][1]",
    "formation.tilt", "start.payload_position[1]", "start.payload_yaw", "goal.payload_position[0]",
    "goal.payload_yaw", "controller.k_p", "controller.k_lambda", "controller.gamma[1][0]",
    "controller.assumed.payload_mass", "push[0].force[1]", "push[0].duration", "wind.mean[0]",
)  # fmt: skip
#: Parts of the names of quantities with kinks, which differences see only if they are taken close
#: by; the error's mean is summed over instants that impacts pass by.
KINKED = (
    "payload_error_rms", "_max", "peak_", "_tension", "_rise", "residual", "largest_", "_min",
    "hardest",
)  # fmt: skip


def scenario_of(changes, **more):
    scenario = plate(changes={**changes, **more})
    if changes is not JERKED:
        return scenario
    places = scenario.vehicle_start[:, :3] - [[0.0, 0.0, 0.03], [0, 0, 0.05], [0, 0, 0.04]]
    return scenario.with_values({"start.vehicle_position": places})


def scalar_keys(scenario):
    """Every number of the scenario's tables that a file may give, with indices."""
    tables = scenario.model.tables_of(scenario.values)
    for name, table in tables.items():
        for field in table.fields:
            given = [name]
            if name == "push":
                given = [f"push[{k}]" for k in range(len(scenario.values["push"]))]
            elif name == "controller.assumed" and not scenario.gives(f"{name}.{field.name}"):
                continue
            for one in given if field.kind == "number" and name != "event" else []:
                for place in np.ndindex(*field.dims):
                    yield f"{one}.{field.name}" + "".join(f"[{k}]" for k in place)


def differentiable(scenario):
    found = {}
    for key in scalar_keys(scenario):
        try:
            found[key] = tangent(scenario, key)
        except ml.ScenarioError:
            continue
    return found


def difference(f, x, width):
    """Two central differences, extrapolated to order width^4."""
    near, far = ((f(x + h) - f(x - h)) / (2 * h) for h in (width, 2 * width))
    return (4 * near - far) / 3


@pytest.mark.parametrize("changes", [GENERAL_ELASTIC, CRAFT])
def test_rows_change_with_every_key_as_differences_say(changes):
    scenario = scenario_of(changes)
    tangents = differentiable(scenario)
    assert len(tangents) > 100
    for key, found in tangents.items():
        x = scenario[key]
        if not np.isfinite(x):
            continue

        def row(value, key=key):
            return rows.problem(scenario.with_values({key: float(value)}))[1]

        width = 1e-4 * abs(x) or 1e-5
        # What is 0 and must not be less enters rows as it is: its difference is the same beside 0.
        signed = field_of(key, scenario.values, "here").range == "any"
        with np.errstate(invalid="ignore"):  # limits that are infinite
            expected = difference(row, x if x or signed else 2 * width, width)
        moves = ~np.isnan(expected)
        # Round-off over the width, of numbers up to 2500.
        np.testing.assert_allclose(
            found[moves], expected[moves], rtol=1e-8, atol=1e-12 / width, err_msg=key
        )


def run_differences(scenario, key, width):
    """Derivatives of a run's numbers along a key by differences, by name."""
    x = np.mean(scenario[key])
    offsets = width * np.array([1.0, -1.0, 2.0, -2.0])
    values = [np.add(scenario[key], offset) for offset in offsets]
    batch = ml.simulate_batch(scenario, {key: np.array(values)}, threads=1)
    assert np.isfinite(x)
    assert set(batch.status) == {"finished"}
    columns = dict(zip(scenario.quantities.final_state, batch.final_state.T, strict=True))
    columns |= batch.metrics | {f"audit.{k}": v for k, v in batch.audit.items()}
    return {name: (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12 * width) for name, f in columns.items()}


@pytest.mark.parametrize(
    ("changes", "noise"),
    # What a run's numbers are known to: round-off of a thousand steps with energies of 50 J; with
    # impacts, whose times are found to 2^-20 of a step, two jumps of a metre a second for as long.
    [(GENERAL, 1e-12), (GENERAL_ELASTIC, 1e-12), (CRAFT, 1e-12), (JERKED, 2e-9)],
    ids=["ideal", "elastic", "quadrotors", "impacts"],
)
def test_derivatives_are_those_of_differences(changes, noise):
    scenario = scenario_of(changes)
    exact = ml.gradient(scenario, KEYS)
    assert exact.status == "finished"
    assert (exact.values["impacts"] > 0) == (changes is JERKED)
    wrong = []
    for k, key in enumerate(KEYS):
        width = 1e-4 * max(np.abs(scenario[key]).max(), 0.1)
        for name, found in run_differences(scenario, key, width).items():
            if name in WITHOUT_DERIVATIVE or any(part in name for part in KINKED):
                continue
            allowed = noise * max(1.0, abs(exact.values[name])) / width
            if not np.isclose(exact[name][k], found, rtol=1e-5, atol=allowed):
                wrong.append((key, name, float(exact[name][k]), float(found)))
    assert not wrong, "\n".join(map(str, wrong))


@pytest.mark.parametrize("changes", [GENERAL, GENERAL_ELASTIC, CRAFT, JERKED])
def test_values_are_those_of_simulate_to_the_last_bit(changes):
    scenario = scenario_of(changes)
    run, exact = ml.simulate(scenario), ml.gradient(scenario, "plant.payload_mass")
    assert (exact.status, exact.end_time) == (run.status, run.end_time)
    for name in scenario.quantities.final_state:
        assert exact.values[name] == run[name][-1], name
    for name, value in run.metrics.items():
        np.testing.assert_equal(exact.values[name], value)
    for name, value in run.audit.items():
        assert exact.values[f"audit.{name}"] == value, name


def test_a_key_of_several_numbers_is_all_of_them_growing_together():
    scenario = scenario_of(GENERAL)
    each = [f"plant.vehicle_mass[{k}]" for k in range(3)]
    exact = ml.gradient(scenario, ["plant.vehicle_mass", *each])
    rows = exact.final_state
    np.testing.assert_allclose(rows[:, 0], rows[:, 1:].sum(axis=1), rtol=1e-9, atol=1e-12)


def test_what_counts_has_no_derivative():
    exact = ml.gradient(scenario_of(GENERAL), "controller.k_p")
    for name in WITHOUT_DERIVATIVE:
        assert np.isnan(exact.metrics[name]).all()
    assert np.isfinite(exact.final_state).all()


@pytest.mark.parametrize(
    ("key", "reason"),
    [
        ("controller.rate", "counts integration steps"),
        ("link.delay", "counts integration steps"),
        ("motion_capture.dropout", "counts integration steps"),
        ("motion_capture.position_noise", "without noise"),
        ("safety.vehicle_distance", "decides when a run ends"),
        ("wind.gust_speed", "before the run"),
        ("simulation.seed", "no quantity"),
        ("push[0].frequency", "sine"),
        ("plant.model", "not the key"),
        ("plant.vehicle_mass[3]", "not the key"),
        ("start.vehicle_position[0][0]", "not the key"),
        ("vehicle.arm_length", "not the key"),
        ("ground.height", "not the key"),
        ("", "not the key"),
    ],
)
def test_keys_without_a_derivative_are_refused_with_the_reason(key, reason):
    with pytest.raises(ml.ScenarioError, match=reason) as error:
        ml.gradient(scenario_of(GENERAL), ["plant.payload_mass", key])
    assert error.value.key == key


def test_what_moves_a_path_or_makes_tensions_jump_is_refused():
    moving = {"reference.kind": "min_snap", "reference.duration": 0.8}
    with pytest.raises(ml.ScenarioError, match="path"):
        ml.gradient(plate(changes=moving), "goal.payload_position[0]")
    with pytest.raises(ml.ScenarioError, match="tensions jump"):
        ml.gradient(plate(4, {"formation.tilt": 0.0}), "formation.tilt[0]")
