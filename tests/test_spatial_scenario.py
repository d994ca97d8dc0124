"""What a spatial scenario accepts, refuses and works out."""

import numpy as np
import pytest
from multilift import library, load
from multilift.errors import ScenarioError
from multilift.models.spatial import vehicles
from multilift.scenario import Scenario
from spatial_scenarios import plate, tables

WRONG = [
    ({"plant.vehicles": 0}, "plant.vehicles", "1 to 64"),
    ({"plant.vehicles": 65}, "plant.vehicles", "1 to 64"),
    ({"plant.cables": "rubber"}, "plant.cables", "rigid, elastic"),
    ({"plant.cable_length": [1.0, 1.0]}, "plant.cable_length", "n, here 3"),
    ({"plant.payload_inertia": [0.0, 0.1, 0.1]}, "plant.payload_inertia", "three moments > 0"),
    ({"plant.payload_inertia": [0.1, 0.1, 0.3]}, "plant.payload_inertia", "sum of the others"),
    ({"plant.payload_inertia": 0.0}, "plant.attachment", "all 0"),
    ({"plant.payload_mass": 1e-5}, "plant.payload_mass", ">= 1.486e-05 kg"),
    ({"plant.cable_restitution": 1.5}, "plant.cable_restitution", "0 to 1"),
    ({"plant.gravity": 0.0}, "plant.gravity", "> 0"),
    ({"vehicle.kind": "helicopter"}, "vehicle.kind", "ideal, quadrotor"),
    ({"vehicle.kind": "quadrotor"}, "vehicle.inertia", "vehicle.type"),
    ({"vehicle.type": "zeppelin"}, "vehicle.type", "crazyflie"),
    ({"formation.tilt": 1.6}, "formation.tilt", "pi/2"),
    ({"formation.tilt": [0.2, 0.2, 0.0]}, "formation.tilt", "level"),
    ({"formation.tilt": "-3 deg"}, "formation.tilt", ">= 0"),
    ({"start.payload_position": [0.0, 0.0]}, "start.payload_position", "3"),
    ({"start.vehicle_position": [0.0, 0.0, 9.0]}, "start.vehicle_position", "1.2 m"),
    ({"start.rotors": "idle"}, "start.rotors", "running, stopped"),
    ({"reference.kind": "teleport"}, "reference.kind", "min_snap"),
    ({"reference.kind": "min_snap"}, "reference.duration", "needs it"),
    ({"reference.kind": "circle", "reference.duration": 5.0}, "goal.payload_position", "around"),
    (
        {"reference.kind": "waypoints", "reference.times": [1.0], "reference.points": [1.0, 2.0]},
        "reference.points",
        "four numbers",
    ),
    (
        {
            "reference.kind": "waypoints",
            "reference.times": [1.0],
            "reference.points": [9.0, 0.0, 1.5, 0.0],
        },
        "reference.points",
        "last four",
    ),
    ({"limits.thrust_min": 30.0, "limits.thrust_max": 20.0}, "limits.thrust_min", "< "),
    ({"limits.tilt_max": 2.0}, "limits.tilt_max", "pi/2"),
    ({"link.loss": 1.0}, "link.loss", "0.999"),
    ({"link.delay": 0.0005}, "link.delay", "multiples"),
    ({"motion_capture.dropout": 1.0}, "motion_capture.dropout", "0.999"),
    ({"motion_capture.period": 0.0101}, "motion_capture.period", "multiples"),
    ({"wind.mean": [1.0, 2.0]}, "wind.mean", "3"),
    ({"ground.sink": 0.0}, "ground.sink", "> 0"),
    ({"push": [{"body": "vehicle_4", "start": 0.0, "duration": 1.0}]}, "push[0].body", "vehicle_3"),
    (
        {"push": [{"body": "vehicle_1", "start": 0.0, "duration": 1.0, "torque": 1.0}]},
        "push[0].torque",
        "payload only",
    ),
    (
        {"event": [{"kind": "rotor_stopped", "time": 1.0, "vehicle": "vehicle_1"}]},
        "event[0].kind",
        "vehicle_lost",
    ),
    (
        {"event": [{"kind": "cable_cut", "time": 1.0, "vehicle": "vehicle_9"}]},
        "event[0].vehicle",
        "vehicle_1",
    ),
    ({"controller.law": "magic"}, "controller.law", "energy_coupled"),
    ({"controller.k_p": [1.0, 2.0]}, "controller.k_p", "n x 3, here 3 x 3"),
    ({"weather.mean": 1.0}, "weather", "wind"),
]


@pytest.mark.parametrize(("changes", "key", "advice"), WRONG)
def test_a_mistake_gives_one_error_that_names_key_and_what_is_permitted(changes, key, advice):
    with pytest.raises(ScenarioError) as caught:
        plate(changes=changes)
    assert caught.value.key == key
    assert advice in str(caught.value)


SPATIAL = sorted(
    f.stem for f in library.files() if 'model = "spatial"' in f.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("name", SPATIAL)
def test_shipped_scenarios_load_and_come_back_from_their_own_text(name, tmp_path):
    scenario = load(name)
    assert scenario.name == name
    file = tmp_path / f"{name}.toml"
    file.write_text(scenario.to_toml(), encoding="utf-8")
    assert load(file).values == scenario.values


@pytest.mark.parametrize("name", vehicles.names())
def test_shipped_vehicles_hover_below_their_greatest_thrust(name):
    raw = tables()
    del raw["plant"]["vehicle_mass"]
    raw["plant"]["payload_mass"] = 1e-3
    raw["vehicle"] = {"type": name}
    scenario = Scenario(raw)
    craft = scenario.vehicle
    greatest = 4 * craft.thrust_coefficient * craft.rotor_speed_max**2
    weight = np.array(scenario["plant.vehicle_mass"]) * scenario["plant.gravity"]
    assert (weight < 0.7 * greatest).all()


def test_a_scenario_says_more_than_its_vehicle_does():
    scenario = plate(changes={"vehicle.type": "crazyflie"})
    assert scenario["plant.vehicle_mass"] == [1.486] * 3  # the file's 27 g are not asked for
    raw = tables()
    del raw["plant"]["vehicle_mass"]
    raw["vehicle"] = {"type": "crazyflie"}
    raw["plant"]["payload_mass"] = 0.01
    assert Scenario(raw)["plant.vehicle_mass"] == [0.027] * 3


@pytest.mark.parametrize("n", [1, 2, 3, 5, 12])
def test_cables_at_rest_hold_the_payload(n):
    changes = {"plant.payload_inertia": 0.0, "plant.attachment": 0.0} if n == 1 else {}
    if n == 1:
        changes["formation.tilt"] = 0.0
    rest = plate(n, changes).rest
    weight = 1.2 * 9.8
    assert rest.cable_force[0].sum(axis=0) == pytest.approx([0.0, 0.0, weight], abs=1e-12 * weight)
    arms = np.array(plate(n, changes)["plant.attachment"])
    moment = np.cross(arms, rest.cable_force[0]).sum(axis=0)
    assert np.abs(moment).max() < 1e-12 * weight


def test_elastic_cables_start_as_long_as_their_load_stretches_them():
    changes = {"plant.cables": "elastic", "plant.cable_stiffness": 400.0}
    scenario = plate(changes=changes)
    rest = scenario.rest
    length = np.linalg.norm(rest.offset[0] - np.array(scenario["plant.attachment"]), axis=1)
    tension = np.linalg.norm(rest.cable_force[0], axis=1)
    assert length == pytest.approx(1.2 + tension / 400.0, abs=1e-12)
