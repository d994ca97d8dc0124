"""Tuning: what is better, what is found, what is kept when killed, what comes out."""

import json
import re
import tomllib
from pathlib import Path

import multilift as ml
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift import library, study, tune
from multilift.errors import OutputError, ScenarioError
from multilift.limit.bound import law_force
from multilift.study.run import run as run_study
from multilift.study.spec import Criterion
from multilift.tune import gradients, judge, search
from multilift.tune.goals import Goal, Objective, not_dominated, violation
from multilift.tune.run import run
from multilift.tune.strategies import descents, front
from test_cli import multilift

pytest.importorskip("cma")

few = settings(max_examples=25, deadline=None, database=None)

#: A flight short enough to be flown thousands of times.
SHORT = {"simulation.duration": 1.0}

GAINS = [{"key": "controller.k_lambda", "low": 0.1, "high": 5.0, "scale": "log"},
         {"key": ["controller.k_d[0][0]", "controller.k_d[1][0]"], "name": "k_d_y",
          "low": 2.0, "high": 12.0}]  # fmt: skip


def small(**changes):
    """A tuning of two gains of Sim 1 over one second."""
    content = {
        "variable": GAINS,
        "objective": [{"metric": "swing_integral"}],
        "budget": 60,
        "population": 8,
        **changes,
    }
    return tune.parse(content, "small", Path(), base=ml.load("sim1").with_values(SHORT))


def worlds(**changes):
    """The same over worlds whose load is not as believed."""
    over = {
        "count": 8,
        "vary": [
            {
                "key": "plant.bar_mass",
                "apply": "multiply",
                "distribution": "uniform",
                "low": 0.75,
                "high": 1.25,
            }
        ],
    }
    return small(over={**over, **changes.pop("over", {})}, **changes)


# What is better.


@few
@given(
    st.lists(
        st.tuples(*[st.integers(0, 4)] * 3),
        min_size=1,
        max_size=25,
    )
)
def test_a_front_is_what_nothing_beats_and_beats_all_else(rows):
    values = np.array(rows, dtype=float)
    chosen = values[not_dominated(values)]

    def beats(a, b):
        return (a <= b).all() and (a < b).any()

    assert not any(beats(a, b) for a in chosen for b in chosen)
    assert len(np.unique(chosen, axis=0)) == len(chosen)
    for row in values:
        assert any(beats(a, row) or (a == row).all() for a in chosen)


@few
@given(st.floats(-10, 10), st.floats(-5, 5))
def test_a_violation_is_zero_exactly_where_a_study_would_succeed(value, bound):
    for constraint in (Criterion("x", bound, -np.inf, ""), Criterion("x", np.inf, bound, "")):
        kept = constraint.above < value < constraint.below
        assert (violation(constraint, np.array([value]))[0] == 0.0) == kept


def test_no_value_is_worse_than_any_value():
    for bound in ({"below": 3.0, "above": -np.inf}, {"below": np.inf, "above": 3.0}):
        assert violation(Criterion("x", unit="", **bound), np.array([np.nan]))[0] == np.inf


def test_constraints_go_before_objectives_and_these_in_their_order():
    goal = Goal((Objective("a", within=0.1), Objective("b")), (Criterion("c", 1.0, -np.inf, ""),))
    # a, b, violation, share without a value, end time
    figures = np.array([
        [0.51, 9.0, 0.0, 0.0, 1.0],
        [0.55, 1.0, 0.0, 0.0, 1.0],  # as good in a as the first, better in b
        [0.10, 0.0, 0.2, 0.0, 1.0],  # best in both, breaks the constraint
        [np.inf, 0.0, 0.0, 0.5, 1.0],
        [np.inf, 0.0, 0.0, 1.0, 1.0],  # has no value in more worlds
    ])  # fmt: skip
    order = np.lexsort(goal.order(figures).T[::-1])
    assert order.tolist() == [1, 0, 3, 4, 2]


def test_figures_are_the_statistics_of_worlds_flown_one_by_one():
    plan = worlds(statistic="quantile", quantile=0.5)
    point = np.array([[0.3, 0.6]])
    drawn = study.draws.draw(plan.over, 0, 8)["plant.bar_mass.factor"]
    settled = []
    tuned = plan.tuned({k: float(x[0]) for k, x in plan.space.numbers(point).items()})
    # The law believes the scenario in every world: neither its weight nor its model follows.
    assumed = tuned.values["controller"]["assumed"]
    believed = {f"controller.assumed.{k}": v for k, v in assumed.items() if k != "model"}
    for factor in drawn:
        one = tuned.with_values(believed | {"plant.bar_mass": assumed["bar_mass"] * factor})
        settled.append(ml.simulate(one).metrics["swing_integral"])
    assert search.fly(plan, point)[0, 0] == np.quantile(settled, 0.5, method="higher")


# What is found.


def drive(strategy, figures):
    """Runs a strategy on figures given by a function; all points and figures."""
    points, told = [], []
    asked = next(strategy)
    while True:
        rows = figures(asked)
        points.append(asked)
        told.append(rows)
        try:
            asked = strategy.send(rows)
        except StopIteration:
            return np.concatenate(points), np.concatenate(told)


def shown(*objectives):
    """Figures of objectives without constraints."""
    rows = np.column_stack(objectives)
    return np.column_stack([rows, np.zeros(len(rows)), np.ones(len(rows))])


@pytest.mark.parametrize("seed", [1, 2])
def test_descents_find_the_bottom_of_a_bent_valley(seed):
    goal = Goal((Objective("a"),))
    middle = np.array([0.31, 0.62, 0.77])

    def valley(x):
        d = x - middle
        return shown((d[:, 0] + d[:, 1] ** 2) ** 2 + 10 * d[:, 1] ** 2 + d[:, 2] ** 2)

    points, told = drive(descents(goal, 3, seed, 900, 10, np.full(3, 0.5)), valley)
    assert len(points) == 900
    assert ((points >= 0) & (points <= 1)).all()
    assert points[np.argmin(told[:, 0])] == pytest.approx(middle, abs=2e-3)


def test_descents_go_on_elsewhere_once_they_are_stuck():
    goal = Goal((Objective("a"),))
    wide, narrow = np.array([0.25, 0.25]), np.array([0.8, 0.7])

    def traps(x):
        far = np.linalg.norm(x - wide, axis=1)
        near = np.linalg.norm(x - narrow, axis=1)
        return shown(np.minimum(0.2 + far, 3.0 * near))

    points, told = drive(descents(goal, 2, 1, 2000, 8, wide), traps)
    assert told[:, 0].min() < 1e-3
    assert points[np.argmin(told[:, 0])] == pytest.approx(narrow, abs=1e-3)


def test_a_front_that_is_not_convex_is_found_along_its_length():
    goal = Goal((Objective("a"), Objective("b")), combine="front")

    def bent(x):  # the front: x1 = 0.5, b = 1 - a^2
        off = 4.0 * np.abs(x[:, 1] - 0.5)
        return shown(x[:, 0] + off, 1.0 - x[:, 0] ** 2 + off)

    _, told = drive(front(goal, 2, 3, 3000, 12, np.full(2, 0.9)), bent)
    best = told[not_dominated(told[:, :2])]
    off = best[:, 1] - (1.0 - best[:, 0] ** 2)
    assert np.median(off) < 0.01 and off.max() < 0.1
    inner = np.sort(best[:, 0])
    assert inner[0] < 0.02 and inner[-1] > 0.98
    assert np.diff(inner).max() < 0.1


def test_tuning_is_better_than_the_scenario_and_its_file_says_so_to_the_last_bit(tmp_path):
    result = run(small(), tmp_path / "out")
    value = result.after.values["swing_integral"]
    assert value < result.before.values["swing_integral"]
    again = ml.simulate(ml.load(tmp_path / "out" / "tuned.toml"))
    assert again.metrics["swing_integral"] == value
    kept = json.loads((tmp_path / "out" / "result.json").read_text())
    assert kept["after"]["values"]["swing_integral"] == value
    # Within the bounds, and at every key that the variable names.
    own = ml.load(tmp_path / "out" / "tuned.toml")
    assert own["controller.k_d"][0][0] == own["controller.k_d"][1][0]
    assert 0.1 <= own["controller.k_lambda"] <= 5.0
    page = (tmp_path / "out" / "report.html").read_text()
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)
    assert "swing_integral" in page


def test_a_seed_gives_the_same_search_and_another_another():
    def found(seed):
        strategy = descents(Goal((Objective("a"),)), 2, seed, 80, 8, np.full(2, 0.5))
        return drive(strategy, lambda x: shown(((x - 0.3) ** 2).sum(axis=1)))[0]

    assert np.array_equal(found(4), found(4))
    assert not np.array_equal(found(4), found(5))


def test_the_search_over_worlds_is_checked_by_a_study_of_others(tmp_path):
    plan = worlds(budget=24)
    result = run(plan, tmp_path / "out")
    checked = study.load(tmp_path / "out" / "check.toml")
    assert checked.seed != plan.over.seed
    run_study(checked, tmp_path / "check")
    import pandas as pd

    rows = pd.read_parquet(tmp_path / "check" / "rows")
    assert len(rows) == judge.JUDGED
    quantile = np.quantile(rows["swing_integral"], 0.95, method="higher")
    assert quantile == result.after.judged["swing_integral"]


def test_worst_is_no_better_than_a_quantile_and_that_no_better_than_the_median():
    point = np.array([[0.5, 0.5]])
    median, quantile, worst = (
        search.fly(worlds(**how), point)[0, 0]
        for how in ({"quantile": 0.5}, {"quantile": 0.9}, {"statistic": "worst"})
    )
    assert median < quantile <= worst


def test_slopes_are_those_of_the_runs_whatever_the_numbers_set():
    plan = small(
        variable=[
            *GAINS,
            {"key": ["controller.k_p[0][1]", "controller.k_p[1][1]"], "name": "k_p_z",
             "apply": "multiply", "scale": "log", "low": 0.2, "high": 1.0},
            {"key": "controller.gamma", "apply": "add", "low": 0.0, "high": 2.0},
        ],
        objective=[{"metric": "swing_integral"},
                   {"metric": "control_effort", "weight": 0.3, "sense": "maximise"}],
        combine="weighted",
    )  # fmt: skip
    point = np.array([0.4, 0.6, 0.7, 0.3])
    _, along = gradients.slope(plan, point)
    for k in range(4):
        step = np.eye(4)[k] * 1e-4
        up, down = (gradients.slope(plan, point + s)[0] for s in (step, -step))
        assert along[k] == pytest.approx((up - down) / 2e-4, rel=1e-5)


def test_a_walk_goes_down_to_where_it_is_level_or_the_box_ends():
    plan = small()
    start = np.array([0.5, 0.5])
    steps = gradients.walk(plan, start, 40)
    values = [gradients.slope(plan, x)[0] for x in (start, steps[-1])]
    assert values[1] < values[0]
    along = gradients.slope(plan, steps[-1])[1]
    free = (steps[-1] > 0) & (steps[-1] < 1)
    assert (
        np.abs(along[free]).max(initial=0.0) < 1e-2 * np.abs(gradients.slope(plan, start)[1]).max()
    )


@pytest.mark.parametrize(
    "changes",
    [
        {"objective": [{"metric": "combined_settling"}]},
        {"objective": [{"metric": "swing_integral"}, {"metric": "overshoot"}]},
        {"constraint": [{"metric": "overshoot", "below": 1.0}]},
        {"over": {"count": 4, "vary": [{"key": "plant.bar_mass", "distribution": "uniform",
                                         "low": 0.7, "high": 0.9}]}},
        {"variable": [{"key": "controller.rate", "low": 50.0, "high": 100.0}]},
    ],
)  # fmt: skip
def test_nothing_walks_where_there_is_no_slope(changes):
    assert gradients.budget(small()) == 7
    assert gradients.budget(small(**changes)) == 0


def test_a_law_without_a_gain_leaves_it_out():
    plan = tune.load("settle", scenario="sim1", controller="pd")
    assert "k_lambda" not in [v.name for v in plan.space.varied]
    assert plan.scenario.law == "pd"


# What is kept.


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tuning") / "out"
    run(small(), folder)
    return folder


@pytest.mark.parametrize("share", [0.0, 0.3, 0.77, 1.0])
def test_a_killed_search_goes_on_to_the_same_bits(finished, tmp_path, share):
    whole = (finished / search.FILE).read_bytes()
    folder = tmp_path / "out"
    folder.mkdir()
    for name in (search.FILE, "tuning.json"):
        (folder / name).write_bytes((finished / name).read_bytes())
    (folder / search.FILE).write_bytes(whole[: int(share * len(whole))])
    result = run(small(), folder)
    assert (folder / search.FILE).read_bytes() == whole
    assert (folder / "tuned.toml").read_bytes() == (finished / "tuned.toml").read_bytes()
    lines = whole[: int(share * len(whole))].count(b"\n")
    known = [json.loads(line) for line in whole.splitlines()[:lines]]
    assert result.found.replayed == sum(len(k["points"]) for k in known)


def test_another_tuning_does_not_go_on_there(finished):
    before = (finished / search.FILE).read_bytes()
    with pytest.raises(OutputError, match="another tuning"):
        run(small(seed=2), finished)
    assert (finished / search.FILE).read_bytes() == before


def test_damaged_generations_are_named_not_overwritten(finished, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    for name in (search.FILE, "tuning.json"):
        (folder / name).write_bytes((finished / name).read_bytes())
    damaged = b"what\n" + (folder / search.FILE).read_bytes()
    (folder / search.FILE).write_bytes(damaged)
    with pytest.raises(OutputError, match=r"line 1, is damaged(.|\n)*--force"):
        run(small(), folder)
    assert (folder / search.FILE).read_bytes() == damaged
    run(small(), folder, force=True)
    assert (folder / search.FILE).read_bytes() == (finished / search.FILE).read_bytes()


def test_a_folder_of_someone_else_is_not_touched(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="holds no tuning"):
        run(small(), tmp_path, force=True)
    assert [f.name for f in tmp_path.iterdir()] == ["mine.txt"]


# Bad input.


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"budgets": 5}, r"budgets = 5: .*\n.*budget"),
        ({"budget": 2}, r"budget = 2: .*\n  permitted: .*4"),
        ({"variable": []}, r"variable: is missing"),
        ({"objective": []}, r"objective: is missing"),
        ({"objective": [{"metric": "swing"}]}, r"objective\[0\].metric = 'swing'"),
        ({"objective": [{"metric": "overshoot", "weight": -1.0}]}, r"weight = -1.0: is not posit"),
        ({"combine": "front"}, r"combine = 'front': needs two or three objectives"),
        ({"statistic": "worst"}, r"statistic = 'worst': goes over draws, of which there are none"),
        ({"variable": [{"key": "controller.k_q", "low": 1, "high": 2}]}, r"controller.k_q"),
        ({"variable": [{"key": "controller.k_lambda", "low": 2, "high": 1}]}, r"is not below high"),
        (
            {"variable": [{"key": "controller.k_lambda", "low": 0, "high": 1, "scale": "log"}]},
            r"has no logarithm",
        ),
        (
            {"variable": [{"key": "controller.k_lambda", "low": -1, "high": 1}]},
            r"variable\[0\].low: reaches -1, which the scenario does not permit",
        ),
        ({"variable": GAINS + GAINS[:1]}, r"is the name of a column of variable\[0\]"),
        ({"over": {"count": 8}}, r"\[over\]: vary: is missing"),
        ({"over": {"study": "nothing"}}, r"nothing: does not exist"),
        ({"over": {"believe": "me"}}, r"believe = 'me'"),
        ({"constraint": [{"metric": "overshoot"}]}, r"constraint\[0\].below: is missing"),
    ],
)
def test_a_wrong_tuning_gets_one_answer_with_key_and_advice(changes, message):
    with pytest.raises(ScenarioError) as error:
        small(**changes)
    assert re.search(message, str(error.value))


def test_draws_and_variables_may_not_move_the_same_key():
    with pytest.raises(ScenarioError, match="is moved by variables and draws"):
        worlds(variable=[{"key": "plant.bar_mass", "low": 0.5, "high": 1.0}])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Missing"),
        (["sim1"], "--output"),
        (["nothing", "-o", "out"], "nothing: does not exist"),
        (["sim1", "-o", "out", "--vary", "controller.k_lambda=1"], "is not KEY=LOW:HIGH"),
        (["sim1", "-o", "out", "--keep", "overshoot=2"], "is not METRIC<X or METRIC>X"),
        (["sim1", "-o", "out", "--tuning", "none"], "none: does not exist"),
        (["sim1", "-o", "out", "--controller", "mine"], "controller"),
        (["sim1", "-o", "out", "--statistic", "worst"], "of which there are none"),
        (["--tuning", "settle", "-o", "out"], "scenario: is missing"),
        (["--tuning", "settle", "-o", "out", "--set", "a=1"], "needs a scenario"),
    ],
)
def test_the_command_refuses_in_one_message_and_leaves_nothing(tmp_path, arguments, message):
    result = multilift("tune", *arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    assert not list(tmp_path.iterdir())


def test_the_command_tunes_prints_and_writes_what_it_names(tmp_path):
    result = multilift(
        "tune", "sim1", "-o", "out", "--vary", "controller.k_lambda=0.1:3:log",
        "--vary", "controller.k_p[0][1]=2:6", "--minimise", "peak_swing_1",
        "--minimise", "control_effort", "--keep", "overshoot<1", "--front", "--budget", "30",
        "--set", "simulation.duration=1.0", cwd=tmp_path,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    for line in ("peak_swing_1", "Tuned: out/tuned.toml", "Report: out/report.html"):
        assert line in result.stdout
    command = result.stdout.split("Check it: ")[1].split()
    assert command[0] == "multilift"
    assert multilift(*command[1:], cwd=tmp_path).returncode == 0
    rows = (tmp_path / "out" / "front.csv").read_text().splitlines()
    assert rows[0] == "controller.k_lambda,controller.k_p[0][1],peak_swing_1,control_effort"
    assert len(rows) > 3


# What ships.

#: Time-optimal from rest to rest, s: `multilift limit`, docs/limit.md. Exp 2 starts at its goal;
#: its bound is of the way back from a push.
BOUND = {"sim1": 1.93, "sim2": 2.03, "exp1_1": 1.88, "exp1_2": 1.87, "exp2": 1.00}
LAST_PUSH_ENDS = {"exp2": 51.0}  # s


def test_shipped_tunings_parse_for_what_they_are_made_for():
    for file in library.tunings():
        base = "exp1_1_quadrotors" if "space" in file.stem else "exp1_1"
        assert tune.load(file.stem, scenario=base).space.dimensions >= 6
        assert tomllib.loads(file.read_text())["title"]


@pytest.mark.parametrize("name", BOUND)
def test_shipped_gains_settle_near_the_bound_with_its_forces(name):
    tuned = ml.load(f"{name}_tuned")
    flown = ml.simulate(tuned)
    settled = flown.metrics["combined_settling"] - LAST_PUSH_ENDS.get(name, 0.0)
    # Of Exp 2 no gains of the law come nearer, whatever their force: docs/tuning.md.
    assert settled < (2.0 if name == "exp2" else 1.6) * BOUND[name]
    if name != "exp2":  # of which the law commands nothing before it is pushed
        assert (np.array(law_force(tuned)) <= np.array(law_force(ml.load(name)))).all()


@pytest.mark.parametrize("file", library.tuned(), ids=lambda f: f.stem)
def test_shipped_gains_are_the_scenario_with_other_gains(file):
    tuned = ml.load(file)
    assert tuned.name == file.stem
    law = "_pd" if tuned.law == "pd" else ""
    origin = ml.load(re.sub(rf"{law}_(tuned|robust)$", "", tuned.name)).with_law(tuned.law)
    for table, values in origin.values.items():
        if table not in ("name", "title", "description", "controller"):
            assert tuned.values[table] == values
    gains = {"k_p", "k_d", "k_i", "gamma", "k_lambda"}
    for key, value in origin.values["controller"].items():
        assert key in gains or tuned.values["controller"][key] == value
