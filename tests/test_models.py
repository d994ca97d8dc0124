"""The seam between everything general and a model, tried with a second one."""

import pickle
import subprocess
import sys
import tomllib

import multilift as ml
import numpy as np
import pytest
import tomli_w
from multilift import keys, linear, models, reference
from multilift.bench import mujoco_tree
from multilift.fields import Field
from multilift.models.planar import plot
from multilift.models.planar.run import PlanarRun, planar_run
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.overrides import Columns
from multilift.scenario import Scenario
from multilift.schema import core_fields
from row_model import Row, RowScenario, raw


@pytest.fixture(autouse=True)
def row(monkeypatch):
    """The second model, known during a test."""
    monkeypatch.setattr(models, "_FOUND", dict(models._FOUND))
    models.register(Row())


def test_a_scenario_is_of_its_models_class():
    assert type(ml.load("sim1")) is PlanarScenario
    assert type(Scenario(ml.load("sim1").raw())) is PlanarScenario
    assert type(ml.load("sim1").with_values({"plant.bar_mass": 0.7})) is PlanarScenario
    assert type(ml.load("sim1").with_law("pd")) is PlanarScenario
    assert type(Scenario(raw())) is RowScenario
    assert type(ml.simulate(ml.load("sim1"))) is PlanarRun
    without = ml.load("sim1").raw()
    without["plant"].pop("model", None)
    assert Scenario(without).model is models.by_name("planar")


def test_scenarios_and_runs_travel_between_processes():
    for scenario in (ml.load("exp2"), Scenario(raw(3))):
        again = pickle.loads(pickle.dumps(scenario))
        assert type(again) is type(scenario)
        assert again.values == scenario.values
        assert again.model is scenario.model
    run = ml.simulate(Scenario(raw(3)))
    assert pickle.loads(pickle.dumps(run)).quantities == run.quantities


@pytest.mark.parametrize(
    ("model", "words"), [("planr", "did you mean 'planar'"), (3, "put it in quotes")]
)
def test_an_unknown_model_is_one_clear_error(model, words):
    for act in (
        lambda: Scenario(raw(plant={"model": model}), "here"),
        lambda: Scenario(raw(), "here").with_values({"plant.model": model}),
    ):
        with pytest.raises(ml.ScenarioError) as caught:
            act()
        assert (caught.value.where, caught.value.key) == ("here", "plant.model")
        assert words in str(caught.value)
        assert "planar, spatial, row" in str(caught.value) or model == 3


def test_a_model_is_imported_when_it_is_asked_for():
    code = (
        "import sys, multilift\nfrom multilift import models\n"
        "assert 'matplotlib' not in sys.modules and 'jinja2' not in sys.modules\n"
        "assert models.by_name('planar').name in models.names()\n"
        "assert 'matplotlib' not in sys.modules and 'jinja2' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_shapes_follow_the_size_that_the_scenario_says():
    for n in (1, 2, 5):
        scenario = Scenario(raw(n))
        assert scenario.vehicles.mass.shape == (n,)
        assert scenario.vehicles.attachment.tolist() == np.zeros((n, 3)).tolist()
        assert scenario.vehicles.start.tolist() == [[1.0, 2.0, 3.0]] * n
        assert scenario.controller.k.shape == (n,)
        assert scenario["controller.assumed.vehicles.mass"] == [1.5] * n
    grown = Scenario(raw(2)).with_values({"plant.vehicles": 4})
    assert grown.vehicles.mass.tolist() == [1.5] * 4
    text = Scenario(raw(3)).to_toml()
    assert Scenario(tomllib.loads(text)).values == Scenario(raw(3)).values


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"vehicles.mass": [1.0, 2.0]}, "vehicles.mass", "give n, here 3"),
        ({"vehicles.mass": -1.0}, "vehicles.mass", "shape n, here 3, or fewer dimensions"),
        ({"vehicles.start": [1.0, 2.0]}, "vehicles.start", "give n x 3, here 3 x 3"),
        ({"plant.vehicles": 0}, "plant.vehicles", "whole number, 1 to 64"),
        ({"plant.vehicles": 2.5}, "plant.vehicles", "not a whole number"),
        ({"plant.vehicles": True}, "plant.vehicles", "not a whole number"),
        ({"plant.vehicles": "two"}, "plant.vehicles", "not a whole number"),
        ({"vehicles.mass[3]": 1.0}, "vehicles.mass[3]", "0 to 2"),
        ({"vehicles.wait": 0.005}, "vehicles.wait", "whole number"),
        ({"controller.assumed.vehicles.mas": 1.0}, "controller.assumed.vehicles.mas", "'mass'"),
        ({"controller.law": "pd"}, "controller.law", "spring"),
        ({"push": [{"body": "vehicle_4", "start": 0.0, "duration": 1.0}]}, "push[0].body",
         "load, vehicle_1, vehicle_2, vehicle_3"),
        ({"goal": {}}, "goal", "plant, simulation, vehicles, controller, push"),
    ],
)  # fmt: skip
def test_mistakes_are_named_in_the_models_terms(changes, key, words):
    with pytest.raises(ml.ScenarioError) as caught:
        Scenario(raw(3), "here").with_values(changes)
    assert caught.value.key == key
    assert words in str(caught.value)


def test_keys_find_fields_of_any_model_and_size():
    scenario = Scenario(raw(3, push=[{"body": "vehicle_3", "start": 0.0, "duration": 1.0}]))
    for key, dims in (
        ("vehicles.attachment[2][1]", (3, 3)),
        ("controller.k[2]", (3,)),
        ("controller.assumed.vehicles.mass", (3,)),
        ("push[0].start", ()),
        ("plant.vehicles", ()),
    ):
        assert keys.field_of(key, scenario.values, "here").dims == dims
    for key in ("vehicles.mass[3]", "controller.k[3]", "push[1].start", "controller.assumed.mass"):
        with pytest.raises(ml.ScenarioError):
            keys.field_of(key, scenario.values, "here")
    with pytest.raises(AssertionError, match="not resolved"):
        _ = Field("x", "", shape=("n",)).dims


def test_fields_of_the_core_may_have_sizes_in_their_shapes():
    mass, arm = core_fields(
        [
            ("mass", "kg", "positive", ["n"], [np.nan], "of each"),
            ("arm", "m", "any", ["n", 3], [0.0, 0.0, 1.0], "of each"),
        ]
    )
    assert mass.required
    assert mass.shape == ("n",)
    assert arm.resolved({"n": 2}).default == [[0.0, 0.0, 1.0]] * 2


def test_overrides_of_places_that_depend_on_the_size():
    columns = Columns(Scenario(raw(3)), {"vehicles.mass[2]": [2.0, 3.0]}, None)
    assert columns.own("vehicles.mass").tolist() == [[1.5, 1.5, 2.0], [1.5, 1.5, 3.0]]
    assert columns.world(1).vehicles.mass.tolist() == [1.5, 1.5, 3.0]
    for key, words in (
        ("vehicles.mass[3]", "no such element"),
        ("plant.vehicles", "not a known key"),
        ("goal.x", "vehicles, controller, push[K]"),
    ):
        with pytest.raises(ml.ScenarioError) as caught:
            Columns(Scenario(raw(3)), {key: [2.0, 3.0]}, None)
        assert words in str(caught.value)


def test_runs_have_the_columns_of_their_scenario(tmp_path):
    run = ml.simulate(Scenario(raw(3)))
    assert run.columns[-1] == "x3_z"
    assert run.ending == "ran to its end at t = 1.000 s"
    assert run.summary()["audit"] == {"work": run.audit["work"]}
    folder = run.save(tmp_path / "out")
    assert {f.name for f in folder.iterdir()} >= {"trajectory.parquet", "overview.png"}
    assert ml.load(folder / "scenario.toml").values == run.scenario.values
    far = ml.simulate(Scenario(raw(2, vehicles={"mass": [9.0, 1.0], "start": [9.0, 0.0, 0.0]})))
    assert far.ending == "stopped at t = 1.000 s: vehicle 1 was far"
    own = ml.simulate(Scenario(raw(2)), lambda start: np.zeros(len(start)))
    assert own["x1_x"][-1] == own["x1_x"][0] == 1.0
    with pytest.raises(ml.ControllerError, match="one stiffness for each vehicle"):
        ml.simulate(Scenario(raw(2)), lambda _: [1.0])
    with pytest.raises(ml.ControllerError, match="permitted: spring"):
        ml.simulate(Scenario(raw(2)), "pd")


def test_batches_agree_with_runs():
    scenario = Scenario(raw(2))
    draws = {
        "vehicles.mass[1]": np.array([0.5, 1.0, 50.0]),
        "vehicles.start[1][0]": np.array([1.0, 1.0, 60.0]),
        "simulation.duration": np.array([1.0, 0.5, 1.0]),
    }
    batch = ml.simulate_batch(scenario, draws)
    assert batch.final_state.shape == (3, 6)
    assert batch.status.tolist() == ["finished", "finished", "far"]
    for k in range(3):
        alone = ml.simulate(Columns(scenario, draws, None).world(k))
        assert alone.metrics == {name: values[k] for name, values in batch.metrics.items()}
        assert (alone.culprit, alone.end_time) == (batch.culprit[k], batch.end_time[k])
    with pytest.raises(ml.ScenarioError, match="world 1 cannot be"):
        ml.simulate_batch(scenario, {"vehicles.wait": np.array([0.0, 0.005])})
    with pytest.raises(ml.ControllerError, match="spring, not 'pd'"):
        ml.simulate_batch(scenario, controller="pd", count=2)


def test_a_study_of_any_model(tmp_path):
    from multilift import study
    from multilift.study.run import run

    (tmp_path / "base.toml").write_text(tomli_w.dumps(raw(3)))
    file = tmp_path / "row_study.toml"
    file.write_text(
        'scenario = "base.toml"\ncount = 40\n'
        '[[vary]]\nkey = "vehicles.start[2][0]"\ndistribution = "uniform"\nlow = 0.0\nhigh = 20.0\n'
        '[[vary]]\nkey = "vehicles.wait"\ndistribution = "uniform"\nlow = 0.0\nhigh = 0.5\n'
        '[[success]]\nmetric = "largest"\nbelow = 3.0\n'
    )
    plan = study.load(file)
    assert plan.metrics == ("largest",)
    assert plan.success[0].sentence() == "largest below 3 m"
    assert not plan.draws_noise
    result = run(plan, tmp_path / "out")
    law = result.summary.laws[0]
    assert set(law.outcomes) == {"finished", "far", "diverged"}
    assert law.outcomes["far"] > 0
    assert law.outcomes["finished"] > 0
    assert "vehicle 3 was far" in (tmp_path / "out" / "summary.json").read_text()


def test_the_command_line_takes_any_model(tmp_path, monkeypatch, capsys):
    from multilift import cli

    file = tmp_path / "row.toml"
    file.write_text(tomli_w.dumps(raw(2)))
    monkeypatch.setattr(sys, "argv", ["multilift", "run", str(file), "--set", "plant.vehicles=3"])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert not ended.value.code
    assert "greatest distance at the end" in capsys.readouterr().out


def test_what_knows_the_planar_plant_only_says_so():
    scenario = Scenario(raw(), "here")
    run = ml.simulate(scenario)
    pytest.importorskip("gymnasium")
    from multilift.gym import TwinLiftVectorEnv

    for use in (
        lambda: ml.Worlds(scenario),
        lambda: TwinLiftVectorEnv(scenario),
        lambda: ml.gradient(scenario, "vehicles.mass"),
        lambda: reference.solve(scenario),
        lambda: mujoco_tree(scenario, 0.001),
        lambda: linear.closed_loop_matrix(scenario),
        lambda: plot.response([run]),
        lambda: planar_only(scenario, "this"),
        lambda: planar_run(run),
    ):
        with pytest.raises(ml.ScenarioError) as caught:
            use()
        assert (caught.value.where, caught.value.key) == ("here", "plant.model")
        assert "'row'" in str(caught.value)


def test_the_reference_reads_well():
    import importlib.util
    from pathlib import Path

    file = Path(__file__).resolve().parents[1] / "docs" / "_ext" / "scenario_reference.py"
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    pages = module.pages()
    tables = pages["row/scenario-tables.md"].replace(module.NBSP, " ")
    assert "| `mass` | > 0 kg (n) | **required** |" in tables
    assert "| `attachment` | m (n × 3) | 0 |" in tables
    assert "| `vehicles` | 1 to 64, n in shapes | 2 |" in tables
    assert "`load`, `vehicle_1` … `vehicle_n`" in tables
    assert "(table-row-controller.assumed.vehicles)=" in pages["row/law-tables.md"]


def test_no_gain_has_the_name_of_another_key_of_its_table():
    for name in models.names():
        model = models.by_name(name)
        for law in model.laws:
            keys = [field.name for field in model.controller_table(law).fields]
            assert len(set(keys)) == len(keys), (name, law)
