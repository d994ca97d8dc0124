"""``multilift reproduce``: everything it promises is there and says what the runs say."""

import json
import re

import multilift as ml
import numpy as np
import pyarrow.parquet as pq
import pytest
from multilift import paper
from multilift.paper import claims, page

TESTS = ("sim1", "sim2", "exp1_1", "exp1_2", "exp2")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    (folder / "mine.py").write_text(
        "def my_law(m):\n    return -6.0 * (m.xi - m.goal) - 7.0 * m.xi_dot\n"
    )
    return paper.reproduce(folder / "out", beside=[f"{folder / 'mine.py'}:my_law"])


@pytest.fixture(scope="module")
def folder(result):
    return result.report.parent


def test_every_figure_of_the_paper_has_its_counterpart(folder):
    found = sorted(f.name for f in (folder / "figures").iterdir())
    numbers = {int(name[3:5]) for name in found}
    assert numbers == {2, 3, 4, 5, 7, 8, 9, 10, 11, 12}
    assert len(found) == 20
    for file in (folder / "figures").iterdir():
        head = {"png": b"\x89PNG", "pdf": b"%PDF"}[file.suffix[1:]]
        assert file.read_bytes().startswith(head)


def test_metrics_are_those_of_the_runs(folder):
    metrics = json.loads((folder / "metrics.json").read_text())
    assert tuple(metrics) == TESTS
    for name in TESTS:
        assert tuple(metrics[name]) == ("energy_coupled", "pd", "my_law")
    run = ml.simulate(ml.load("exp1_2"), "pd")
    assert metrics["exp1_2"]["pd"]["metrics"]["peak_swing_1"] == run.metrics["peak_swing_1"]


def test_trajectories_and_effective_scenarios_lie_beside(folder):
    for name in TESTS:
        for law in ("energy_coupled", "pd", "my_law"):
            table = pq.read_table(folder / name / f"{law}.parquet")
            assert set(table["controller"].to_pylist()) == {law}
        scenario = ml.load(folder / name / "energy_coupled.toml")
        assert scenario.values == ml.load(name).values
        run = ml.simulate(scenario)
        stored = pq.read_table(folder / name / "energy_coupled.parquet")
        assert np.array_equal(run["theta1"], stored["theta1"].to_numpy())


def test_report_is_one_offline_file_with_all_of_it(folder, result):
    html = result.report.read_text()
    # Attributes and style addresses that a browser would load from elsewhere.
    markup = re.sub(r"<script\b[^>]*>.*?</script>", "", html, flags=re.DOTALL)
    assert not re.search(r"""(src|href)\s*=\s*["'](https?:)?//""", markup)
    assert not re.search(r"url\(\s*[\"']?(https?:)?//", markup)
    for claim in claims.check_claims(result.runs):
        assert claim.statement[:40] in markup
    for number in (2, 3, 4, 5, 7, 8, 9, 10, 11, 12):
        assert f"Fig. {number}" in markup
    for name in TESTS:
        assert f"multilift run {name}" in markup


def test_an_independent_constrained_simulation_agrees():
    """Numbers of a separate simulation of the same system, to the digits it was noted with."""
    noted = {  # peak |theta1| in degrees, last time it exceeds 1 degree in 15 s
        ("sim1", "pd"): (3.74, 10.2),
        ("sim1", "energy_coupled"): (1.78, 5.4),
        ("sim2", "pd"): (7.61, 14.3),
        ("sim2", "energy_coupled"): (3.63, 7.8),
    }
    for (name, law), (peak, last) in noted.items():
        run = ml.simulate(ml.load(name).with_values({"simulation.duration": 15.0}), law)
        swing = np.degrees(np.abs(run["theta1"]))
        assert swing.max() == pytest.approx(peak, abs=0.005)
        assert run.t[swing > 1.0][-1] == pytest.approx(last, abs=0.05)


def test_verdicts_follow_the_numbers(result):
    honest = claims.check_claims(result.runs)
    swapped = {
        name: {"energy_coupled": laws["pd"], "pd": laws["energy_coupled"]}
        for name, laws in result.runs.items()
    }
    turned = claims.check_claims(swapped)
    assert honest[0].verdict == "holds"
    assert turned[0].verdict == "does not hold"
    assert honest[4].verdict == "holds"
    assert turned[4].verdict == "does not hold"


def test_assumptions_name_what_the_paper_does_not_give():
    text = " ".join(page.assumptions(ml.load("exp2")))
    for word in ("Damping", "drag estimates", "command delay 20 ms", "35°", "0.5 mm", "1.3 N"):
        assert word in text


def test_two_laws_of_one_name_are_refused(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def pd(m):\n    return [0.0] * 4\n")
    with pytest.raises(ml.ControllerError, match="two laws"):
        paper.reproduce(tmp_path / "out", beside=[f"{file}:pd"])
    assert not (tmp_path / "out").exists()
