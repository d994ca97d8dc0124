"""The comparison of laws: equal effort, gains that fly as drawn, results to fly again."""

import json
import re
import subprocess
import sys
from pathlib import Path

import multilift as ml
import numpy as np
import pytest
import tomli_w

pytest.importorskip("scipy")
pytest.importorskip("jinja2")

from multilift.compare import CONTENDERS, TASKS, compare, costs, tune
from multilift.compare.tables import SHOWN, markdown
from multilift.compare.tuning import draws
from multilift.errors import MultiliftError, ScenarioError

DOCS = Path(__file__).resolve().parents[1] / "docs" / "_static" / "comparison"
EVERY = pytest.mark.parametrize("contender", CONTENDERS, ids=lambda c: c.name)


def short(name="platform_turn", **changes):
    return ml.load(name).with_values({"simulation.duration": 1.0, **changes})


@EVERY
def test_a_set_of_gains_flies_in_a_batch_as_it_does_alone(contender):
    drawn = draws(contender.ranges, 4, seed=5)
    one = {name: float(rows[2]) for name, rows in drawn.items()}
    alone = ml.simulate(contender.fly(short(), one))
    batch = ml.simulate_batch(alone.scenario, contender.overrides(short(), drawn))
    for name, value in alone.metrics.items():
        # Gains of a set among many may round differently from those of a set alone.
        assert batch.metrics[name][2] == pytest.approx(value, rel=1e-9, nan_ok=True), name


@EVERY
def test_draws_fill_their_ranges_and_go_on_where_fewer_ended(contender):
    few, many = (draws(contender.ranges, count, seed=3) for count in (16, 64))
    for name, (low, high) in contender.ranges.items():
        assert (few[name] == many[name][:16]).all()
        assert low <= many[name].min() < low * (high / low) ** 0.05
        assert low * (high / low) ** 0.95 < many[name].max() <= high


@EVERY
def test_other_tables_of_a_task_stay_as_they_are(contender):
    task = short(**{"controller.assumed.payload_mass": 1.0})
    drawn = {name: float(np.sqrt(low * high)) for name, (low, high) in contender.ranges.items()}
    flown = contender.fly(task, drawn)
    kept = {k: v for k, v in task.values.items() if k != "controller"}
    assert {k: v for k, v in flown.values.items() if k != "controller"} == kept
    for key in ("rate", "assumed"):
        assert flown.values["controller"][key] == task.values["controller"][key]


def test_more_draws_never_cost_more_and_the_best_is_the_least():
    (pd,) = (c for c in CONTENDERS if c.name == "pd")
    few, many = (tune(short(), pd, count, seed=2) for count in (4, 16))
    assert (np.diff(many.course) <= 0).all()
    assert (many.course[:4] == few.course).all()
    assert many.cost == many.course[-1] <= few.cost
    assert many.finished == 16


def test_what_ends_early_costs_more_than_anything_that_does_not():
    batch = ml.simulate_batch(short(), {"safety.vehicle_distance": [0.5, 2.0]})
    assert batch.status.tolist() == ["finished", "collision"]
    fine, early = costs(batch)
    assert np.isfinite(fine)
    assert np.isinf(early)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    raw = short().raw()
    raw["name"], raw["title"] = "quick", 'A <script>alert("x")</script> task'
    (folder / "quick.toml").write_text(tomli_w.dumps(raw), encoding="utf-8")
    command = [sys.executable, "-c", "from multilift.cli import main; main()", "compare",
               "quick.toml", "-o", "out", "--draws", "4"]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "out", done.stdout


def test_the_command_writes_what_can_be_flown_again(made):
    folder, shown = made
    content = json.loads((folder / "comparison.json").read_text())
    entries = content["tasks"]["quick"]
    assert set(entries) == {c.name for c in CONTENDERS}
    for contender in CONTENDERS:
        assert contender.label in shown
        again = ml.simulate(ml.load(folder / "flights" / f"quick-{contender.name}.toml"))
        for name in SHOWN:
            told = entries[contender.name]["metrics"][name]
            assert again.metrics[name] == pytest.approx(np.nan if told is None else told,
                                                        rel=1e-12, nan_ok=True)  # fmt: skip
    assert (folder / "comparison.md").read_text() == markdown(content)
    assert (folder / "figures" / "quick.png").read_bytes()[:4] == b"\x89PNG"


def test_the_page_is_complete_and_loads_nothing(made):
    html = (made[0] / "report.html").read_text(encoding="utf-8")
    code = html.replace("http://www.w3.org/2000/svg", "")  # the name of SVG elements, no address
    assert not re.search(r"https?:|@import|url\(|XMLHttpRequest|import\(", code)
    assert '<script>alert("x")' not in html
    for contender in CONTENDERS:
        assert f"multilift run out/flights/quick-{contender.name}.toml" in html
        assert all(f"<code>{name}</code>" in html for name in contender.ranges)


def test_what_cannot_be_compared_is_refused_before_anything_flies(tmp_path):
    for names, draw, words in (
        (["sim1"], 4, "plant.model"),
        (["platform_turn", "platform_turn"], 4, "twice"),
        (["platform_turn"], 0, "at least one"),
        (["nowhere"], 4, "does not exist"),
    ):
        with pytest.raises((ScenarioError, MultiliftError), match=words):
            compare(names, tmp_path / "out", draws=draw)
    assert list(tmp_path.iterdir()) == []


def test_the_printed_numbers_are_those_of_the_tuned_flights():
    content = json.loads((DOCS / "comparison.json").read_text())
    assert tuple(content["tasks"]) == TASKS
    page = (DOCS / "comparison.md").read_text(encoding="utf-8")
    assert page == markdown(content)
    by_name = {c.name: c for c in CONTENDERS}
    for task, entries in content["tasks"].items():
        assert set(entries) == set(by_name)
        for name, entry in entries.items():
            run = ml.simulate(by_name[name].fly(ml.load(task), entry["drawn"]))
            for metric, told in entry["metrics"].items():
                wanted = np.nan if told is None else told
                # A regulator's gains depend on the last digits of the linear algebra at hand.
                again = pytest.approx(run.metrics[metric], rel=1e-3, nan_ok=True)
                assert wanted == again, (task, name, metric)


def test_the_conclusions_quote_the_tables():
    page = (DOCS.parents[1] / "comparison.md").read_text(encoding="utf-8")
    told = page.partition("## Conclusions")[2].partition("## How they were tuned")[0]
    tables = (DOCS / "comparison.md").read_text(encoding="utf-8")
    number = r"(?<![\d.])\d+\.\d+(?![\d.])"
    assert set(re.findall(number, told)) <= set(re.findall(number, tables))


def test_the_printed_ranges_are_those_that_are_drawn():
    page = (DOCS.parents[1] / "comparison.md").read_text(encoding="utf-8")
    for contender in CONTENDERS:
        for name, (low, high) in contender.ranges.items():
            key = name.partition("[")[0]
            assert f"`{key}`" in page
            assert f"{low:g}–{high:g}" in page, (contender.name, name)
