"""Spatial scenarios through simulate, batches and laws of one's own."""

import multilift as ml
import numpy as np
import pytest
from multilift.errors import ControllerError, ScenarioError
from spatial_scenarios import FEEDBACK, plate

NOISY = {
    "vehicle.type": "paper_craft",
    "link.delay": 0.02,
    "link.jitter": 0.005,
    "link.loss": 0.05,
    "motion_capture.period": 0.01,
    "motion_capture.delay": 0.01,
    "motion_capture.position_noise": 5e-4,
    "motion_capture.dropout": 0.05,
    "wind.gust_speed": 2.0,
    "ground.present": True,
    "simulation.duration": 1.0,
    "push": [{"body": "payload", "start": 0.2, "duration": 0.1, "force": [3.0, 1.0, 0.0]}],
    "event": [{"kind": "cable_cut", "time": 0.6, "vehicle": "vehicle_2"}],
}
KINDS = {
    "ideal": {"simulation.duration": 1.0},
    "elastic": {"plant.cables": "elastic", "simulation.duration": 1.0},
    "moving": {
        "reference.kind": "min_snap",
        "reference.duration": 0.8,
        "controller.feedforward": 1.0,
        "simulation.duration": 1.0,
    },
    "noisy": NOISY,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("isa", ml.isa.available())
def test_a_world_in_a_batch_equals_the_same_world_alone(kind, isa):
    scenario = plate(changes=KINDS[kind])
    count = 11
    overrides = {
        "plant.payload_mass": np.linspace(0.8, 1.6, count),
        "plant.cable_length[1]": np.linspace(1.2, 1.25, count),
        "simulation.seed": np.arange(count),
    }
    batch = ml.simulate_batch(scenario, overrides, isa=isa, threads=2, trajectories=True)
    for k in (0, 3, 10):
        alone = ml.simulate(
            scenario.with_values({key: float(values[k]) for key, values in overrides.items()})
        )
        assert batch.status[k] == alone.status
        for name, value in alone.metrics.items():
            assert np.array_equal(batch.metrics[name][k], value, equal_nan=True), name
        for name, value in alone.audit.items():
            assert batch.audit[name][k] == value, name


def test_the_audit_closes_to_integration_error_in_every_kind():
    for kind, changes in KINDS.items():
        run = ml.simulate(plate(changes=changes))
        stored = max(abs(run.audit["storage_start"]), 1.0)
        # Quadrotors' rotors answer within 25 ms, which a step of 1 ms follows to 1e-6; cables cut
        # and caught within a step add that of a stage.
        bound = 1e-4 if kind == "noisy" else 1e-8
        assert run.audit["largest_integration_error"] < bound * stored, kind


def test_worlds_that_hold_no_rest_are_refused_by_name():
    scenario = plate()
    with pytest.raises(ScenarioError, match="world 2"):
        ml.simulate_batch(scenario, {"formation.tilt[0]": np.array([0.2, 0.2, 0.0])})


def under_heavy_vehicles(ratio):
    """The PD law's plate of the vehicles' mass by a ratio, and what its cables pull in weights."""
    inertia = (np.array([0.1, 0.1, 0.18]) / ratio).tolist()
    changes = {"plant.payload_mass": 1.486 / ratio, "plant.payload_inertia": inertia}
    run = ml.simulate(plate(changes={**changes, "simulation.duration": 1.0}).with_law("pd"))
    tensions = np.stack([run[f"tension{k}"] for k in (1, 2, 3)])
    return run, tensions * ratio / (1.486 * 9.8)


def test_tensions_under_vehicles_as_heavy_as_may_be_are_more_than_rounding():
    runs, tensions = zip(*(under_heavy_vehicles(1e5 / k) for k in (100.0, 10.0, 1.0)), strict=True)
    for run in runs:
        assert run.audit["largest_integration_error"] < 1e-8 * run.audit["storage_start"]
    # A load that weighs less disturbs its vehicles less: tensions approach their limit with the
    # inverse of the ratio, in steps of (100 - 1) and (10 - 1), which any rounding would cover. What
    # is left is of the next order, a thousandth.
    far, near = (np.abs(each - tensions[2]).max() for each in tensions[:2])
    assert near < 1e-4
    assert far / near == pytest.approx(11.0, rel=0.01)


def test_worlds_of_vehicles_too_heavy_for_their_load_are_refused_by_name():
    with pytest.raises(ScenarioError, match="world 1"):
        ml.simulate_batch(plate(), {"plant.payload_mass": np.array([1.0, 1e-9])})


def test_a_path_of_its_own_is_no_override():
    scenario = plate(changes=KINDS["moving"])
    with pytest.raises(ScenarioError, match=r"goal\.payload_position"):
        ml.simulate_batch(scenario, {"goal.payload_position[0]": np.array([1.0, 2.0])})


class Pd:
    """The PD law without estimate, written by a user."""

    def __init__(self, scenario):
        self.k_p, self.k_d = (np.array(FEEDBACK[key]) for key in ("k_p", "k_d"))

    def step(self, m):
        error = m.vehicle - m.vehicle_target
        rate = m.vehicle_velocity - m.vehicle_target_velocity
        return m.holding - self.k_p * error - self.k_d * rate


def test_a_law_of_ones_own_flies_as_the_compiled_one():
    scenario = plate(changes={"controller.gamma": 1e-300}).with_law("pd")
    compiled, own = ml.simulate(scenario), ml.simulate(scenario, Pd)
    for column in ("payload_x", "vehicle2_z", "tension3"):
        assert own[column] == pytest.approx(compiled[column], abs=1e-9)
    assert "d_hat1_x" not in own.columns


def test_a_law_that_answers_nonsense_is_named_with_the_time():
    with pytest.raises(ControllerError, match=r"finite force.*3 vehicles"):
        ml.simulate(plate(), lambda m: [0.0] * 8)


def test_a_collision_ends_the_run_with_its_time():
    push = {"body": "vehicle_1", "start": 0.5, "duration": 0.5, "force": [-20.0, 0.0, 0.0]}
    run = ml.simulate(plate(changes={"safety.vehicle_distance": 0.8, "push": [push]}))
    assert run.status == "collision"
    assert 0.5 < run.end_time < 2.0
    assert run.metrics["vehicle_distance_min"] < 0.8
    assert "too close" in run.ending
