"""Keys with indices: what they change, and what they refuse."""

import multilift as ml
import numpy as np
import pytest
from multilift import keys
from multilift.scenario import Scenario


def test_a_key_is_its_steps():
    assert keys.parse("plant.bar_mass") == ("plant", "bar_mass")
    assert keys.parse("controller.k_d[0][1]") == ("controller", "k_d", 0, 1)
    assert keys.parse("push[12].force[0]") == ("push", 12, "force", 0)
    for bad in ("", ".", "a.", "a[", "a[x]", "a[0", "a[-1]", "[0]", "a[0]b", "a..b"):
        with pytest.raises(ml.ScenarioError, match="not a key"):
            keys.parse(bad)


def test_one_place_of_an_array_changes_and_its_neighbours_stay():
    base = ml.load("sim1")  # gives k_d as [7.8, 5.8] for both vehicles
    changed = base.with_values({"controller.k_d[0][1]": 5.0, "plant.vehicle_mass[1]": "2100 g"})
    assert changed["controller.k_d"] == [[7.8, 5.0], [7.8, 5.8]]
    assert changed["plant.vehicle_mass"] == [2.0, 2.1]
    assert changed["controller.k_d[0][1]"] == 5.0
    assert base["controller.k_d"] == [[7.8, 5.8], [7.8, 5.8]]


def test_places_in_tables_within_lists():
    base = ml.load("exp2")
    force = base["push[0].force[0]"]
    changed = base.with_values({"push[0].force[0]": 2 * force, "push[1].start": 31.0})
    assert changed["push[0].force[0]"] == 2 * force
    assert changed["push[1].start"] == 31.0
    assert changed.values["push"][2] == base.values["push"][2]
    assert changed["push[0].duration"] == base["push[0].duration"]


def test_the_same_as_giving_the_whole_array():
    one = ml.load("sim1").with_values({"goal.vehicle_position[0][1]": 3.0,
                                       "goal.vehicle_position[1][1]": 3.0})  # fmt: skip
    two = ml.load("sim1").with_values({"goal.vehicle_position": [[1.2, 3.0], [3.0, 3.0]]})
    assert one.values == two.values
    assert ml.simulate(one).metrics == ml.simulate(two).metrics


def test_a_whole_value_is_set_before_its_places_whatever_the_order():
    for order in (1, -1):
        changes = {"plant.vehicle_mass[0]": 1.5, "plant.vehicle_mass": 1.8}
        changed = ml.load("sim1").with_values(dict(list(changes.items())[::order]))
        assert changed["plant.vehicle_mass"] == [1.5, 1.8]


def test_what_the_law_assumes_follows_the_plant_as_for_whole_values():
    changed = ml.load("sim1").with_values({"plant.vehicle_mass[0]": 1.5})
    assert changed["controller.assumed.vehicle_mass"] == [1.5, 2.0]
    fixed = changed.with_values({"controller.assumed.vehicle_mass[0]": 2.0})
    assert fixed["controller.assumed.vehicle_mass"] == [2.0, 2.0]
    assert fixed["plant.vehicle_mass"] == [1.5, 2.0]


def test_arrays_of_numpy_are_taken():
    changed = ml.load("sim1").with_values({"plant.vehicle_mass[0]": np.float64(1.5)})
    assert changed["plant.vehicle_mass"] == [1.5, 2.0]
    assert Scenario(changed._raw).values["plant"] == changed.values["plant"]


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("plant.vehicle_mass[2]", "0 to 1"),
        ("plant.bar_mass[0]", "drop the last index"),
        ("controller.k_d[0][2]", "0 to 1"),
        ("controller.k_d[0][1][0]", "drop the last index"),
        ("push[0].force[0]", "there is none"),
        ("start.angle[0]", "set all of it"),
        ("plant.vehicle_mas[0]", "did you mean 'vehicle_mass'"),
        ("plnt.vehicle_mass[0]", "plant"),
        ("plant.vehicle_mass[x]", "not a key"),
    ],
)
def test_a_place_that_is_not_there_is_named(key, words):
    with pytest.raises(ml.ScenarioError) as caught:
        ml.load("sim1").with_values({key: 1.0})
    assert caught.value.where == "sim1"
    assert caught.value.key == key
    assert words in str(caught.value)


def test_a_place_keeps_the_range_of_its_key():
    with pytest.raises(ml.ScenarioError, match="not positive"):
        ml.load("sim1").with_values({"plant.vehicle_mass[0]": -1.0})
