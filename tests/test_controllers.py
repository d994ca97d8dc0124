"""Control laws by name, from files and from Python."""

import multilift as ml
import numpy as np
import pytest
from multilift import controllers

SHORT = ml.load("sim1").with_values({"simulation.duration": 0.5})


def hold(m):
    return -6.0 * (m.xi - m.goal) - 7.0 * m.xi_dot


class Counting:
    """Counts its steps and remembers what it was told."""

    title = "a law that counts"

    def __init__(self, scenario):
        self.scenario = scenario
        self.times = []
        Counting.last = self

    def step(self, m):
        self.times.append(m.t)
        self.measured = m
        return [0.0, 0.0, 0.0, 0.0]


def test_a_function_and_a_class_fly():
    run = ml.simulate(SHORT, hold)
    assert run.finished
    assert run.controller == "hold"
    assert ml.simulate(SHORT, Counting).controller_title == "a law that counts"


def test_a_law_is_stepped_at_the_control_rate():
    ml.simulate(SHORT.with_values({"controller.rate": 50.0}), Counting)
    assert Counting.last.times == pytest.approx(np.arange(26) * 0.02)


def test_a_law_is_made_afresh_for_each_run():
    ml.simulate(SHORT, Counting)
    first = Counting.last
    ml.simulate(SHORT, Counting)
    assert Counting.last is not first
    assert Counting.last.times == first.times


def test_a_law_is_told_the_state_it_can_measure():
    ml.simulate(SHORT.with_values({"simulation.duration": 0.001}), Counting)
    m = Counting.last.measured
    assert m.xi.shape == m.xi_dot.shape == m.goal.shape == (2, 2)
    assert m.theta.shape == m.theta_dot.shape == (3,)
    assert np.array_equal(m.goal, [[1.2, 3.5], [3.0, 3.5]])
    assert m.saturated == (False, False)


def test_a_law_from_a_file(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def law(m):\n    return -6.0 * (m.xi - m.goal) - 7.0 * m.xi_dot\n")
    from_file = ml.simulate(SHORT, f"{file}:law")
    assert np.array_equal(from_file["y1"], ml.simulate(SHORT, hold)["y1"])


def test_pd_written_in_python_is_the_compiled_one_without_adaptation():
    frozen = SHORT.with_values({"controller.gamma": 1e-300}).with_law("pd")
    k_p, k_d = frozen.controller.k_p, frozen.controller.k_d

    def pd(m):
        return -k_p * (m.xi - m.goal) - k_d * m.xi_dot

    ours, theirs = ml.simulate(frozen, pd), ml.simulate(frozen)
    for column in ("y1", "z2", "theta1", "u1", "tension2"):
        # Only the order of two additions differs.
        assert ours[column] == pytest.approx(theirs[column], rel=1e-12, abs=1e-13)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ([1.0, 2.0], "four"),
        ([np.nan, 0.0, 0.0, 0.0], "finite"),
        ("up", "four"),
        (None, "four"),
    ],
)
def test_a_wrong_answer_is_named_with_its_time(answer, words):
    def wrong(m):
        return answer if m.t > 0.1 else [0.0] * 4

    with pytest.raises(ml.ControllerError, match=words) as caught:
        ml.simulate(SHORT, wrong)
    assert "t = 0.101 s" in str(caught.value)


def test_an_exception_in_a_law_is_named_with_its_time():
    def broken(m):
        return 1 / 0

    with pytest.raises(ml.ControllerError, match="ZeroDivisionError") as caught:
        ml.simulate(SHORT, broken)
    assert "t = 0 s" in str(caught.value)


@pytest.mark.parametrize(
    ("reference", "words"),
    [
        ("unknown", "energy_coupled, pd"),
        ("nowhere.py:law", "does not exist"),
        (3, "no control law"),
    ],
)
def test_a_law_that_is_not_there(reference, words):
    with pytest.raises(ml.ControllerError, match=words):
        ml.simulate(SHORT, reference)


def test_a_law_from_a_file_may_use_dataclasses_and_cannot_move_the_goal(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "from __future__ import annotations\n"
        "from dataclasses import dataclass\n"
        "@dataclass\n"
        "class Gains:\n"
        "    k: float = 6.0\n"
        "def law(m):\n"
        "    m.goal[:] += 1.0\n"
        "    return [0.0] * 4\n"
    )
    with pytest.raises(ml.ControllerError, match="read-only"):
        ml.simulate(SHORT, f"{file}:law")


def test_a_file_without_the_law_or_that_fails(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("x = 1\n")
    with pytest.raises(ml.ControllerError, match="defines no 'law'"):
        ml.simulate(SHORT, f"{file}:law")
    file.write_text("import nothing_like_this\n")
    with pytest.raises(ml.ControllerError, match="fails"):
        ml.simulate(SHORT, f"{file}:law")


def test_a_class_without_step():
    class Idle:
        pass

    with pytest.raises(ml.ControllerError, match="step"):
        controllers.python_law(Idle)
