"""Where a bar can hang: rest is stationary, closed and found where it exists."""

import multilift as ml
import numpy as np
import pytest
from multilift import _core
from multilift.models.planar import geometry

SIM1 = ml.load("sim1")


def plant_of(changes):
    # A mismatched goal is not what these tests are about.
    scenario = SIM1.with_values({**changes, "goal.allow_mismatch": True})
    return scenario.values["plant"], scenario.plant_values()


def test_matched_vehicles_hang_the_load_straight_down():
    _, values = plant_of({})
    angles = geometry.rest_angles(values, np.array([[0.0, 3.0], [1.8, 3.0]]))
    assert np.array_equal(angles, np.zeros(3))


@pytest.mark.parametrize("seed", range(20))
def test_rest_is_closed_and_in_balance(seed):
    rng = np.random.default_rng(seed)
    _, values = plant_of(
        {"plant.cable_length": [1.8, 1.8 + 0.2 * rng.random()], "plant.bar_half_thickness": 0.1}
    )
    vehicles = np.array([[0.0, 3.0], [1.8 + rng.uniform(-0.8, 0.8), 3.0 + rng.uniform(-0.4, 0.4)]])
    angles = geometry.rest_angles(values, vehicles)
    q = [*vehicles.ravel().tolist(), *angles.tolist()]
    assert np.abs(_core.planar_closure(values, q)).max() < 1e-12
    # Held vehicles (enormous masses) leave the load where it is: no angular acceleration.
    heavy = list(values)
    heavy[0] = heavy[1] = 1e9
    motion = _core.planar_motion(heavy, q, [0.0] * 7, [0.0] * 11)
    # The vehicles still give way by force / 1e9 kg; stationarity is solved to 1e-9 of the weight.
    assert np.abs(motion["theta_ddot"]).max() < 1e-6


def test_mirrored_vehicles_hang_a_mirrored_load():
    _, values = plant_of({})
    a = geometry.rest_angles(values, np.array([[0.0, 3.0], [2.2, 3.3]]))
    b = geometry.rest_angles(values, np.array([[-2.2, 3.3], [0.0, 3.0]]))
    # Mirroring y swaps the cables, whose angles the paper counts mirrored already.
    assert a == pytest.approx([b[1], b[0], -b[2]], abs=1e-9)


def test_a_linkage_that_cannot_close_is_named():
    plant, _ = plant_of({})
    assert geometry.linkage_problem(plant, np.array([[0.0, 3.0], [1.8, 3.0]])) == ""
    assert "distance" in geometry.linkage_problem(plant, np.array([[0.0, 3.0], [5.5, 3.0]]))
