"""Scenarios: what is accepted means what it says; what cannot be meant gives one clear error."""

import math
import tomllib

import multilift as ml
import numpy as np
import pytest
from multilift import library, schema
from multilift.models.planar import tables
from multilift.scenario import Scenario

SHIPPED = ["exp1_1", "exp1_2", "exp2", "sim1", "sim2"]


def test_all_shipped_scenarios_load():
    assert set(SHIPPED) <= {f.stem for f in library.files()}
    for name in SHIPPED:
        assert ml.load(name).name == name


# The paper's tables, section 5, typed from the paper and not from the files.
PAPER_STARTS_AND_GOALS = {
    "sim1": ([0.8, 2.0, 2.6, 2.0], [1.2, 3.5, 3.0, 3.5]),
    "sim2": ([0.0, 3.0, 1.8, 3.0], [-0.8, 2.2, 1.0, 2.2]),
    "exp1_1": ([-1.5, 2.0, 0.0, 2.0], [-0.3, 2.3, 1.2, 2.3]),
    "exp1_2": ([0.0, 2.2, 1.5, 2.2], [-1.2, 1.8, 0.3, 1.8]),
    "exp2": ([-1.5, 2.2, 0.0, 2.2], [-1.5, 2.2, 0.0, 2.2]),
}


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenarios_are_as_the_paper_tables_them(name):
    scenario = ml.load(name)
    start, goal = PAPER_STARTS_AND_GOALS[name]
    assert np.array_equal(scenario.q_start[:4], start)
    assert np.array_equal(scenario.goal_vector(), goal)
    plant, law = scenario.plant, scenario.controller
    simulation = name.startswith("sim")
    assert plant.gravity == 9.8
    assert plant.bar_inertia == 0.0
    assert plant.vehicle_mass.tolist() == [2.0, 2.0] if simulation else [1.486, 1.486]
    assert plant.cable_length.tolist() == [1.8, 1.8] if simulation else [1.21, 1.21]
    assert (plant.bar_mass, plant.bar_half_thickness) == (
        (0.8, 0.03) if simulation else (0.386, 0.01)
    )
    gains = ([6.2, 6.5], [7.8, 5.8], [1.0, 0.5]) if simulation else ([4.5, 6.2], [6.2, 8.0], [5, 5])
    for key, (y, z) in zip(("k_p", "k_d", "gamma"), gains, strict=True):
        assert getattr(law, key).tolist() == [[y, z], [y, z]]
    assert law.k_lambda == (1.4 if simulation else 0.15)
    if simulation:
        assert scenario.simulation.step == 0.001
        assert scenario.is_ideal()
    if name == "exp2":
        assert [p["start"] for p in scenario.values["push"]] == [10.8, 30.8, 50.8]
        assert all(p["body"] == "bar" and p["force"][1] == 0.0 for p in scenario.values["push"])


@pytest.mark.parametrize("name", SHIPPED)
def test_the_complete_scenario_loads_to_itself(name):
    scenario = ml.load(name)
    again = Scenario(tomllib.loads(scenario.to_toml()))
    assert again.values == scenario.values
    assert again.to_toml() == scenario.to_toml()


def test_units_in_texts_are_converted():
    changed = ml.load("sim1").with_values(
        {
            "plant.bar_mass": "800 g",
            "plant.cable_length": ["180 cm", "1800 mm"],
            "actuators.tilt_max": "30 deg",
            "actuators.command_delay": "20 ms",
        }
    )
    assert changed.plant.bar_mass == pytest.approx(0.8, rel=1e-15)
    assert changed.plant.cable_length == pytest.approx([1.8, 1.8], rel=1e-15)
    assert changed.actuators.tilt_max == pytest.approx(math.pi / 6, rel=1e-15)
    assert changed.actuators.command_delay == pytest.approx(0.02, rel=1e-15)


def test_with_values_leaves_the_original_alone():
    original = ml.load("sim1")
    before = original.to_toml()
    original.with_values({"plant.vehicle_mass": [3.0, 3.0], "actuators.thrust_max": 50.0})
    assert original.to_toml() == before


def test_with_law_keeps_what_both_laws_know_and_drops_the_rest():
    pd = ml.load("sim1").with_law("pd")
    assert pd.law == "pd"
    assert "k_lambda" not in pd.values["controller"]
    assert pd.values["controller"]["k_p"] == ml.load("sim1").values["controller"]["k_p"]


# (changes, key the error must name, words it must hold)
MISTAKES = [
    ({"plant.bar_mas": 1.0}, "plant.bar_mas", "bar_mass"),
    ({"plnt.bar_mass": 1.0}, "plnt", "plant"),
    ({"controller.k_lamda": 1.0}, "controller.k_lamda", "k_lambda"),
    ({"controller.law": "pdd"}, "controller.law", "pd"),
    ({"plant.bar_mass": -0.8}, "plant.bar_mass", "> 0 kg"),
    ({"plant.bar_mass": 0}, "plant.bar_mass", "> 0 kg"),
    ({"plant.bar_mass": math.nan}, "plant.bar_mass", "finite"),
    ({"plant.bar_mass": math.inf}, "plant.bar_mass", "finite"),
    ({"plant.bar_mass": "0.8 m"}, "plant.bar_mass", "kg"),
    ({"plant.bar_mass": "heavy"}, "plant.bar_mass", "number"),
    ({"plant.bar_mass": True}, "plant.bar_mass", "number"),
    ({"plant.bar_mass": [1.0, 2.0]}, "plant.bar_mass", "shape"),
    ({"plant.vehicle_mass": [1.0, 2.0, 3.0]}, "plant.vehicle_mass", "shape"),
    ({"plant.vehicle_mass": [[1.0], [2.0, 3.0]]}, "plant.vehicle_mass", "shape"),
    ({"plant.vehicle_drag": -0.1}, "plant.vehicle_drag", ">= 0"),
    ({"plant.model": "planer"}, "plant.model", "planar"),
    ({"controller.k_p": 0.0}, "controller.k_p", "> 0"),
    ({"controller.k_d": [[1.0, 1.0], [1.0, -1.0]]}, "controller.k_d", "> 0"),
    ({"controller.gamma": 0.0}, "controller.gamma", "> 0"),
    ({"controller.k_lambda": -0.1}, "controller.k_lambda", ">= 0"),
    ({"controller.rate": 333.0}, "controller.rate", "whole number"),
    ({"plant.bar_length": 5.5}, "start.vehicle_position", "bar measures"),
    ({"start.vehicle_position": [[0.0, 2.0], [9.0, 2.0]]}, "start.vehicle_position", "distance"),
    ({"start.angle": [0.1, 0.0, 0.0]}, "start.angle", "closure"),
    ({"start.angle": ["100 deg", 0.0, 0.0]}, "start.angle", "pi/2"),
    ({"start.angle_rate": [1.0, 0.0, 0.0]}, "start.angle_rate", "closure"),
    ({"start.vehicle_velocity": [[1.0, 0.0], [0.0, 0.0]]}, "start.vehicle_velocity", "closure"),
    ({"goal.vehicle_position": [[1.2, 3.5], [3.1, 3.5]]}, "goal.vehicle_position", "(17)"),
    ({"goal.vehicle_position": [[1.2, 3.5], [3.0, 3.6]]}, "goal.vehicle_position", "(17)"),
    (
        {"goal.vehicle_position": [[0.0, 3.5], [9.0, 3.5]], "goal.allow_mismatch": True},
        "goal.vehicle_position",
        "impossible",
    ),
    ({"goal.allow_mismatch": "yes"}, "goal.allow_mismatch", "true or false"),
    ({"simulation.step": 0.5}, "simulation.step", "stiffest"),
    ({"plant.swing_damping": 5e3}, "simulation.step", "stiffest"),
    ({"simulation.step": 0.003}, "simulation.record_period", "whole number"),
    ({"simulation.duration": 0}, "simulation.duration", "> 0 s"),
    ({"simulation.seed": 1.5}, "simulation.seed", "whole number"),
    ({"actuators.command_delay": 0.0105}, "actuators.command_delay", "whole number"),
    ({"actuators.command_delay": 5.0}, "actuators.command_delay", "under way"),
    ({"actuators.thrust_max": 10.0}, "actuators.thrust_max", "hold"),
    ({"actuators.thrust_min": 50.0, "actuators.thrust_max": 40.0}, "actuators.thrust_min", "40"),
    ({"actuators.tilt_max": 2.0}, "actuators.tilt_max", "pi/2"),
    ({"sensors.position_noise": -1.0}, "sensors.position_noise", ">= 0"),
    ({"push": {"body": "bar"}}, "push", "[[push]]"),
    ({"push": [{"body": "bar", "start": 1.0}]}, "push[0].duration", "missing"),
    ({"push": [{"body": "rope", "start": 1, "duration": 1}]}, "push[0].body", "vehicle_1"),
    (
        {"push": [{"body": "vehicle_1", "start": 1, "duration": 1, "torque": 1.0}]},
        "push[0].torque",
        "bar only",
    ),
    (
        {"push": [{"body": "bar", "start": 1, "duration": 1, "shape": "sine"}]},
        "push[0].frequency",
        "sine",
    ),
    (
        {"push": [{"body": "bar", "start": 1, "duration": 1, "shape": "samples",
                   "sample_times": [0.0, 0.0], "sample_values": [1.0, 1.0]}]},
        "push[0].sample_times",
        "ascending",
    ),
    (
        {"push": [{"body": "bar", "start": 1, "duration": 0.0002, "force": [9.0, 0.0]}]},
        "push[0].duration",
        "at least one step",
    ),
    (
        {"push": [{"body": "bar", "start": 1.0004, "duration": 0.01, "force": [9.0, 0.0]}]},
        "push[0].duration",
        "multiples",
    ),
    ({"simulation.record_period": 0.001, "simulation.duration": 2e4}, "record_period", "rows"),
    ({"schema": 2}, "schema", "1"),
    ({"schema": True}, "schema", "1"),
    ({"plant": 3}, "plant", "table"),
    ({"controller": {}}, "controller.law", "missing"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "key", "words"), MISTAKES)
def test_a_mistake_gives_one_error_that_names_file_and_key(changes, key, words):
    with pytest.raises(ml.ScenarioError) as caught:
        ml.load("sim1").with_values(changes)
    assert caught.value.where == "sim1"
    assert key in caught.value.key
    assert words in str(caught.value)


def test_every_required_key_is_missed_by_name(tmp_path):
    raw = tomllib.loads(library.find("sim1").read_text())
    required = [
        (table.name, field.name)
        for table in (tables.PLANT, tables.START, tables.GOAL, schema.SIMULATION)
        for field in table.fields
        if field.required
    ] + [("controller", f.name) for f in tables.LAWS["energy_coupled"].gains if f.required]
    assert len(required) >= 11
    for table, key in required:
        broken = {**raw, table: {k: v for k, v in raw[table].items() if k != key}}
        with pytest.raises(ml.ScenarioError, match="missing") as caught:
            Scenario(broken, "here")
        assert caught.value.key == f"{table}.{key}"


@pytest.mark.parametrize("text", ["a = = 1", "schema = 1\nplant = [", "\x00"])
def test_broken_toml_names_the_file_and_place(tmp_path, text):
    file = tmp_path / "broken.toml"
    file.write_text(text)
    with pytest.raises(ml.ScenarioError, match=r"line|control") as caught:
        ml.load(file)
    assert str(file) in str(caught.value)


def test_missing_file_names_the_shipped_scenarios(tmp_path):
    with pytest.raises(ml.ScenarioError, match="sim1"):
        ml.load(tmp_path / "nowhere.toml")
    with pytest.raises(ml.ScenarioError, match="folder"):
        ml.load(tmp_path)


def test_mismatched_goals_fly_when_asked_for():
    scenario = ml.load("sim1").with_values(
        {"goal.vehicle_position": [[1.2, 3.5], [3.1, 3.6]], "goal.allow_mismatch": True}
    )
    assert ml.simulate(scenario).finished
