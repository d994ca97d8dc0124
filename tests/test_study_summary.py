"""What the summary says, against pandas on the same rows; commands replay their rows."""

import json
import math
import shlex

import multilift as ml
import numpy as np
import pytest
from multilift import study
from multilift.options import _parse_change, load_changed
from multilift.study import run as runner
from multilift.study.summary import replay_command
from multilift.toml_text import inline
from study_files import rows, write

TEXT = """
name = "varied"
scenario = "exp1_1"
controllers = ["energy_coupled", "pd"]
count = 24
seed = 2
method = "sobol"
metrics = ["peak_swing_1", "swing_settling_time", "audit.push"]

[set]
simulation.duration = 3.0
controller.assumed.bar_mass = 0.386
[[set.push]]
body = "bar"
start = 0.5
duration = 0.5

[[vary]]
key = ["push[0].force[0]", { key = "push[0].force[1]", factor = -0.5 }]
name = "push"
label = "push"
distribution = "normal"
mean = 0.0
std = 2.0

[[vary]]
key = "actuators.command_delay"
label = "delay"
distribution = "uniform"
low = 0.0
high = 0.3

[[vary]]
key = "controller.k_lambda"
apply = "multiply"
distribution = "list"
values = [1.0, 3.0]

[[success]]
metric = "peak_swing_1"
below = 15.0
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    plan = study.load(write(folder, TEXT))
    return plan, runner.run(plan, folder / "out"), rows(folder / "out"), folder / "out"


def test_some_worlds_end_early_and_some_do_not(result):
    outcomes = result[2]["outcome"].value_counts()
    assert outcomes["finished"] > 10
    assert outcomes["slack"] > 3


def test_counts_and_success(result):
    plan, found, table, _ = result
    for law in found.summary.laws:
        mine = table[table.controller == law.law]
        assert len(mine) == plan.worlds == 48
        assert sum(law.outcomes.values()) == 48
        for name, count in law.outcomes.items():
            assert count == (mine.outcome == name).sum()
        good = (mine.outcome == "finished") & (mine.peak_swing_1 < 15.0)
        assert law.successes == good.sum()
        assert law.success.estimate == good.mean()
        assert law.success.low <= law.success.estimate <= law.success.high


def test_metrics(result):
    _, found, table, _ = result
    for law in found.summary.laws:
        mine = table[(table.controller == law.law) & (table.outcome == "finished")]
        for name, summary in law.metrics.items():
            x = mine[name].dropna()
            assert summary.count == len(mine)
            assert summary.missing == len(mine) - len(x)
            if len(x):
                assert (summary.least, summary.greatest) == (x.min(), x.max())
                assert summary.mean == pytest.approx(x.mean(), rel=1e-12)
            ranked = sorted(mine[name].fillna(math.inf))
            median = ranked[math.ceil(0.5 * (len(ranked) - 1))]
            assert summary.quantiles[2] == median or math.isnan(summary.quantiles[2])


def test_pairs_compare_the_same_worlds(result):
    _, found, table, _ = result
    [pair] = found.summary.pairs
    wide = table.pivot_table(index="world", columns="controller", values=["push"], observed=True)
    assert (wide["push"]["energy_coupled"] == wide["push"]["pd"]).all()
    table = table.assign(ok=(table.outcome == "finished") & (table.peak_swing_1 < 15.0))
    ok = table.pivot_table(index="world", columns="controller", values="ok", observed=True) > 0.5
    first, second = ok[pair.first], ok[pair.second]
    assert pair.both == (first & second).sum()
    assert pair.only_first == (first & ~second).sum()
    assert pair.only_second == (~first & second).sum()
    assert pair.neither == (~first & ~second).sum()
    finished = table[table.outcome == "finished"]
    both = finished.pivot_table(index="world", columns="controller", values="peak_swing_1",
                                observed=True).dropna()  # fmt: skip
    interval, count = pair.metrics["peak_swing_1"]
    assert count == len(both)
    assert interval.estimate == pytest.approx((both[pair.first] - both[pair.second]).mean())


def run_command(command):
    """What the command line would run."""
    words = shlex.split(command)
    assert words[:2] == ["multilift", "run"]
    changes = [words[k + 1] for k, word in enumerate(words) if word == "--set"]
    return ml.simulate(load_changed(words[2], changes), words[words.index("--controller") + 1])


def test_commands_replay_their_rows_to_the_last_bit(result):
    plan, found, table, _ = result
    assert {w.kind for w in found.summary.worst} == {
        "ended early", "greatest peak_swing_1", "greatest swing_settling_time"
    }  # fmt: skip
    commands = {(w.law, w.world): w.command for w in found.summary.worst}
    commands |= {("pd", 0): replay_command(plan, "pd", 0)}
    for (law, world), command in commands.items():
        row = table[(table.controller == law) & (table.world == world)].iloc[0]
        again = run_command(command)
        assert again.status == row["outcome"]
        assert again.end_time == row["end_time"]
        for name, value in again.metrics.items():
            assert np.array_equal(row[name], value, equal_nan=True), name
        for name, value in again.audit.items():
            assert np.array_equal(row[f"audit.{name}"], value, equal_nan=True), name


def test_worst_cases_are_the_worst(result):
    _, found, table, _ = result
    for law in ("energy_coupled", "pd"):
        mine = table[table.controller == law]
        worst = [w for w in found.summary.worst if w.law == law]
        mine = mine.set_index("world")
        early = [w.world for w in worst if w.kind == "ended early"]
        ended = mine[mine.outcome != "finished"].end_time
        assert ended[early].tolist() == sorted(ended)[:5]  # worlds may tie
        high = [w.world for w in worst if w.kind == "greatest peak_swing_1"]
        peaks = mine[mine.outcome == "finished"].peak_swing_1
        assert peaks[high].tolist() == sorted(peaks, reverse=True)[:5]


def test_the_summary_on_the_disk_is_the_one_returned(result):
    plan, found, _, folder = result
    written = json.loads((folder / "summary.json").read_text())
    assert written["worlds"] == plan.worlds
    assert written["laws"][0]["successes"] == found.summary.laws[0].successes
    assert written["made_by"]["multilift"] == ml.__version__
    assert len(written["worst_cases"]) == len(found.summary.worst)


def test_the_page_is_whole_and_loads_nothing(result):
    plan, found, _, folder = result
    text = (folder / "report.html").read_text()
    assert "<script src" not in text
    assert "http://" not in text.replace("http://www.w3.org/", "")
    assert "https://" not in text
    assert "default-src 'none'" in text
    for case in found.summary.worst:
        assert case.command.split(" --set")[0] in text
    for v in plan.vary:
        assert v.label in text
    names = {f.name for f in (folder / "figures").iterdir()}
    assert names == {"outcomes.png", "distributions.png", "influence.png", "map_1.png"}


@pytest.mark.parametrize("value", [1.5, 0.1 + 0.2, 1e-300, -3, True, "a \"b\" \\", [1.0, [2.0]],
                                   math.inf, [{"body": "bar", "force": [0.0, 1.0]}]])  # fmt: skip
def test_values_come_back_from_the_command_line(value):
    assert _parse_change(f"key={inline(value)}") == ("key", value)
