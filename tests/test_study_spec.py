"""Study files: what is accepted means what it says; every mistake gives one clear error."""

import tomllib

import multilift as ml
import numpy as np
import pytest
from multilift import library, study
from multilift.study import spec
from study_files import SMALL, write


def parsed(tmp_path, **changes):
    raw = tomllib.loads(SMALL)
    for key, value in changes.items():
        if value is None:
            raw.pop(key, None)
        else:
            raw[key] = value
    return spec.parse(raw, "here.toml", tmp_path)


def varied(**changes):
    """A [[vary]] table: uniform payload, changed; None drops an entry."""
    entry = {"key": "plant.bar_mass", "distribution": "uniform", "low": 0.6, "high": 1.0}
    entry |= changes
    return [{k: v for k, v in entry.items() if v is not None}]


def test_shipped_studies_load_and_are_fit_for_a_minute():
    names = [f.stem for f in library.studies()]
    assert {"robustness_sim1", "robustness_exp1_1", "gains_sim1", "starts_sim1"} <= set(names)
    for name in names:
        plan = study.load(name)
        assert plan.name == name
        steps = plan.scenario["simulation.duration"] / plan.scenario["simulation.step"]
        # At about 100 ns a step on one core.
        assert plan.worlds * len(plan.controllers) * steps * 100e-9 < 60.0, name
        assert plan.success


def test_what_the_file_says(tmp_path):
    plan = study.load(write(tmp_path))
    assert (plan.name, plan.title, plan.count, plan.cells, plan.worlds) == (
        "small", "A small study", 10, 2, 20
    )  # fmt: skip
    assert plan.controllers == ("energy_coupled", "pd")
    assert plan.scenario["simulation.duration"] == 0.05
    assert [v.name for v in plan.vary] == ["plant.bar_mass", "controller.k_lambda"]
    assert plan.vary[0].label == "plant.bar_mass (kg)"
    assert plan.success[0].sentence() == "peak_swing_1 below 0.02 deg"
    assert study.load(write(tmp_path), count=3).worlds == 6
    assert plan.under("pd").law == "pd"


def test_units_in_texts_are_converted(tmp_path):
    plan = parsed(tmp_path, vary=varied(low="600 g", high="1000 g"))
    assert plan.vary[0].bounds() == pytest.approx((0.6, 1.0))


def test_a_scenario_beside_the_study_is_found(tmp_path):
    (tmp_path / "mine.toml").write_text(library.find("sim1").read_text())
    plan = study.load(write(tmp_path, SMALL.replace('"sim1"', '"mine.toml"')))
    assert plan.reference == str(tmp_path / "mine.toml")


def test_keys_that_move_together(tmp_path):
    entry = varied(key=["plant.vehicle_mass", {"key": "plant.bar_mass", "factor": 0.5,
                                               "offset": 0.1}], low=1.0, high=2.0)  # fmt: skip
    [v] = parsed(tmp_path, vary=entry).vary
    changes = v.overrides(ml.load("sim1"), np.array([1.0, 2.0]))
    assert changes["plant.vehicle_mass"].tolist() == [1.0, 2.0]
    assert changes["plant.bar_mass"].tolist() == [0.6, 1.1]


def test_multiply_and_add_start_from_the_scenarios_own_values(tmp_path):
    [v] = parsed(tmp_path, vary=varied(key="controller.k_d", apply="multiply")).vary
    k_d = v.overrides(ml.load("sim1"), np.array([0.5, 1.0]))["controller.k_d"]
    assert k_d.tolist() == [[[3.9, 2.9], [3.9, 2.9]], [[7.8, 5.8], [7.8, 5.8]]]
    assert v.name == "controller.k_d.factor"
    [v] = parsed(tmp_path, vary=varied(key="plant.vehicle_mass[1]", apply="add")).vary
    added = v.overrides(ml.load("sim1"), np.array([0.5]))
    assert added == {"plant.vehicle_mass[1]": [2.5]}


def test_times_are_rounded_to_whole_steps(tmp_path):
    [v] = parsed(tmp_path, vary=varied(key="actuators.command_delay", low=0.0, high=0.1)).vary
    times = v.overrides(ml.load("sim1"), np.array([0.0, 0.0004, 0.0006, 0.05049]))
    assert times["actuators.command_delay"] == pytest.approx([0.0, 0.0, 0.001, 0.05], abs=1e-15)


def test_the_digest_follows_what_decides_the_rows_and_nothing_else(tmp_path):
    base = parsed(tmp_path).digest()
    for changes in (
        {"count": 11}, {"seed": 6}, {"controllers": ["pd"]}, {"method": "sobol"},
        {"set": {"simulation.duration": 0.06}}, {"scenario": "sim2"},
        {"vary": varied(high=1.1)},
    ):  # fmt: skip
        assert parsed(tmp_path, **changes).digest() != base, changes
    for changes in (
        {"title": "other"}, {"description": "other"}, {"metrics": ["overshoot"]},
        {"success": []}, {"name": "other"},
    ):  # fmt: skip
        assert parsed(tmp_path, **changes).digest() == base, changes


# (changes, key the error must name, words it must hold)
MISTAKES = [
    ({"cout": 3}, "cout", "did you mean 'count'"),
    ({"schema": 2}, "schema", "1"),
    ({"scenario": None}, "scenario", "sim1"),
    ({"scenario": "sim9"}, "scenario", "does not exist"),
    ({"scenario": 3}, "scenario", "not a text"),
    ({"controllers": []}, "controllers", "energy_coupled"),
    ({"controllers": "pd"}, "controllers", "list"),
    ({"controllers": ["pdd"]}, "controllers[0]", "did you mean 'pd'"),
    ({"controllers": ["pd", "pd"]}, "controllers", "twice"),
    ({"count": 0}, "count", "1 to"),
    ({"count": 1.5}, "count", "whole"),
    ({"count": True}, "count", "whole"),
    ({"count": None}, "count", "missing"),
    ({"count": 20_000_000, "method": "latin_hypercube"}, "count", "sobol"),
    ({"count": 2**31, "method": "sobol"}, "count", "random"),
    ({"seed": -1}, "seed", "0 to"),
    ({"seed": "x"}, "seed", "whole"),
    ({"method": "sobel"}, "method", "did you mean 'sobol'"),
    ({"metrics": []}, "metrics", "peak_swing_1"),
    ({"metrics": "overshoot"}, "metrics", "list"),
    ({"metrics": ["overshot"]}, "metrics[0]", "did you mean 'overshoot'"),
    ({"metrics": [1]}, "metrics[0]", "text"),
    ({"set": 3}, "set", "[set]"),
    ({"set": {"plant.bar_mas": 1.0}}, "set", "did you mean 'bar_mass'"),
    ({"set": {"plant": {"bar_mass": -1.0}}}, "set", "not positive"),
    ({"set": {"controller.law": "pd"}}, "set.controller.law", "controllers"),
    ({"vary": None}, "vary", "[[vary]]"),
    ({"vary": []}, "vary", "[[vary]]"),
    ({"vary": {"key": "plant.bar_mass"}}, "vary", "list of tables"),
    ({"vary": [3]}, "vary[0]", "not a table"),
    ({"vary": varied(key=None)}, "vary[0].key", "missing"),
    ({"vary": varied(key=[])}, "vary[0].key", "empty"),
    ({"vary": varied(key=3)}, "vary[0].key", "not a key"),
    ({"vary": varied(key="plant.bar_mas")}, "plant.bar_mas", "did you mean 'bar_mass'"),
    ({"vary": varied(key="plnt.bar_mass")}, "plnt.bar_mass", "plant"),
    ({"vary": varied(key="plant")}, "plant", "not a known key"),
    ({"vary": varied(key="plant.bar_mass[0]")}, "plant.bar_mass[0]", "no place"),
    ({"vary": varied(key="plant.vehicle_mass[2]")}, "plant.vehicle_mass[2]", "no place"),
    ({"vary": varied(key="push[0].start")}, "push[0].start", "not a known key"),
    ({"vary": varied(key="a..b")}, "a..b", "names joined by dots"),
    ({"vary": varied(key="plant.model")}, "vary[0].key", "text, not a number"),
    ({"vary": varied(key="goal.allow_mismatch")}, "vary[0].key", "flag"),
    ({"vary": varied(key=[{"key": "plant.bar_mass", "fctor": 1.0}])}, "vary[0].key.fctor",
     "did you mean 'factor'"),
    ({"vary": varied(distribution=None)}, "vary[0].distribution", "missing"),
    ({"vary": varied(distribution="unifrom")}, "vary[0].distribution", "did you mean 'uniform'"),
    ({"vary": varied(apply="times")}, "vary[0].apply", "multiply"),
    ({"vary": varied(lo=3)}, "vary[0].lo", "did you mean 'low'"),
    ({"vary": varied(mean=3)}, "vary[0].mean", "not a known key"),
    ({"vary": varied(low=None)}, "vary[0].low", "missing"),
    ({"vary": varied(high=None)}, "vary[0].high", "missing"),
    ({"vary": varied(low="1 m")}, "vary[0].low", "wrong unit"),
    ({"vary": varied(low=float("nan"))}, "vary[0].low", "finite"),
    ({"vary": varied(low=1.0)}, "vary[0].low", "not below high"),
    ({"vary": varied(low=2.0)}, "vary[0].low", "swap"),
    ({"vary": varied(low=-0.5)}, "vary[0].low", "not positive"),
    ({"vary": varied(high=20.0), "set": {"actuators.thrust_max": 50.0}}, "vary[0].high", "hold"),
    ({"vary": varied(key="actuators.command_delay", low=0.0, high=9.0)}, "vary[0].high",
     "under way"),
    ({"vary": varied(distribution="log_uniform", low=0.0)}, "vary[0].low", "logarithm"),
    ({"vary": varied(distribution="normal")}, "vary[0].mean", "missing"),
    ({"vary": varied(distribution="normal", mean=0.8, std=0.0)}, "vary[0].std", "not positive"),
    ({"vary": varied(distribution="normal", mean=0.8, std=0.2, low=None)}, "vary[0].low",
     "8.3 standard deviations"),
    ({"vary": varied(distribution="normal", mean=9.0, std=0.1)}, "vary[0].mean", "outside"),
    ({"vary": varied(distribution="list")}, "vary[0].low", "not a known key"),
    ({"vary": varied(distribution="list", low=None, high=None)}, "vary[0].values", "missing"),
    ({"vary": varied(distribution="list", low=None, high=None, values=[])}, "vary[0].values",
     "empty"),
    ({"vary": varied(distribution="list", low=None, high=None, values=[1.0, 1.0])},
     "vary[0].values", "twice"),
    ({"vary": varied(distribution="list", low=None, high=None, values=[1.0, "x"])},
     "vary[0].values", "number"),
    ({"vary": varied(distribution="list", low=None, high=None, values=[-1.0, 1.0])},
     "vary[0].values", "not positive"),
    ({"vary": varied(distribution="grid")}, "vary[0].points", "missing"),
    ({"vary": varied(distribution="grid", points=1)}, "vary[0].points", "2 to"),
    ({"vary": varied(distribution="grid", points=2.5)}, "vary[0].points", "whole"),
    ({"vary": varied(distribution="grid", points=3, spacing="lin")}, "vary[0].spacing", "linear"),
    ({"vary": varied(distribution="grid", points=3, spacing="log", low=0.0)}, "vary[0].low",
     "logarithm"),
    ({"vary": varied(name="world")}, "vary[0].name", "every row"),
    ({"vary": varied(name="x") + varied(key="plant.cable_length", name="x", low=1.7, high=1.9)},
     "vary[1].name", "vary[0]"),
    ({"vary": varied() + varied(name="again")}, "vary[1].key", "vary[0]"),
    ({"vary": varied(key="plant.cable_length", low=1.7, high=1.9)
      + varied(key="plant.cable_length[0]", low=1.7, high=1.9)}, "vary[1].key", "vary[0]"),
    ({"vary": varied(key="start.angle[0]", apply="add", low=-0.1, high=0.1)}, "vary[0].key",
     "no value of its own"),
    ({"vary": varied(key="goal.vehicle_position[1][0]", low=2.0, high=3.0)}, "vary[0].low",
     "breaks (17)"),
    ({"success": {"metric": "overshoot"}}, "success", "[[success]]"),
    ({"success": [3]}, "success[0]", "not a table"),
    ({"success": [{"below": 1.0}]}, "success[0].metric", "missing"),
    ({"success": [{"metric": "overshot", "below": 1.0}]}, "success[0].metric", "'overshoot'"),
    ({"success": [{"metric": "overshoot"}]}, "success[0].below", "missing"),
    ({"success": [{"metric": "overshoot", "belw": 1.0}]}, "success[0].belw", "'below'"),
    ({"success": [{"metric": "overshoot", "below": "x"}]}, "success[0].below", "number"),
    ({"success": [{"metric": "overshoot", "below": 1.0, "above": 1.0}]}, "success[0].above",
     "nothing succeeds"),
    ({"map": [{"x": "plant.bar_mass", "y": "plant.bar_mass"}]}, "map[0].y", "same"),
    ({"map": [{"x": "plant.bar_mas", "y": "controller.k_lambda"}]}, "map[0].x", "did you mean"),
    ({"map": [{"x": "plant.bar_mass"}]}, "map[0].y", "missing"),
    ({"map": [{"x": "plant.bar_mass", "y": "controller.k_lambda", "show": "swing"}]},
     "map[0].show", "success"),
    ({"map": 3}, "map", "[[map]]"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "key", "words"), MISTAKES)
def test_a_mistake_gives_one_error_that_names_file_and_key(tmp_path, changes, key, words):
    with pytest.raises(ml.ScenarioError) as caught:
        parsed(tmp_path, **changes)
    assert caught.value.where.startswith("here.toml")
    assert caught.value.key == key
    assert words in str(caught.value)


def test_broken_and_missing_files_are_named(tmp_path):
    with pytest.raises(ml.ScenarioError, match="line"):
        study.load(write(tmp_path, "count = = 1"))
    with pytest.raises(ml.ScenarioError, match="robustness_sim1"):
        study.load(tmp_path / "nowhere.toml")
    with pytest.raises(ml.ScenarioError, match="folder"):
        study.load(tmp_path)
