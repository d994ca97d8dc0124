"""NMPC: its coordinates and its look ahead against the plant, its plans against the bound's law."""

import multilift as ml
import numpy as np
import pytest
from multilift.controllers import ControllerError, PythonLaw
from multilift.errors import ScenarioError
from test_cli import multilift

pytest.importorskip("casadi")

from multilift.limit.bound import law_force
from multilift.limit.bounds import Limits
from multilift.nmpc import Horizon, Nmpc, Weights

#: Flights of both plants in which forces act at once, under a law that makes the load swing.
FLIGHTS = ("exp1_1", "exp1_1_quadrotors")


def ideal(name, duration):
    scenario = ml.load(name)
    return scenario.with_values(
        {**scenario.model.unhindered(scenario), "simulation.duration": duration}
    )


def watched(scenario, law):
    """A run under a law, and everything that the law was told and answered."""
    seen = []

    def make(given):
        step = law(given)

        def watch(measured):
            answer = np.array(step(measured), dtype=float).ravel()
            state = scenario.model.free_coordinates(scenario, measured)
            seen.append((measured.t, *state, answer))
            return answer

        return watch

    return ml.simulate(scenario, PythonLaw("watched", "watched", make)), seen


def shaken(scenario):
    """Forces that move everything, smoothly enough to differentiate."""
    n = 2
    if scenario.model.name == "planar":
        return lambda _: lambda m: [2 * np.sin(3 * m.t), 1 + np.sin(5 * m.t),
                                    1 - np.cos(4 * m.t), np.sin(2 * m.t)]  # fmt: skip

    def make(_):
        def law(m):
            push = np.array([[2 * np.sin(3 * m.t), np.sin(2 * m.t), np.sin(5 * m.t)]] * n)
            push[1] = [1 - np.cos(4 * m.t), -np.sin(3 * m.t), 0.5 * np.sin(2 * m.t)]
            return m.holding + push

        return law

    return make


def move_of(scenario):
    return scenario.model.move(scenario, Limits(force=law_force(scenario)))


@pytest.mark.parametrize("name", FLIGHTS)
def test_rates_are_the_derivatives_of_the_coordinates(name):
    scenario = ideal(name, 1.0)
    _, seen = watched(scenario, shaken(scenario))
    t = np.array([row[0] for row in seen])
    q, v = (np.array([row[k] for row in seen]) for k in (1, 2))
    slope = (q[2:] - q[:-2]) / (t[2:] - t[:-2])[:, None]
    # A central difference is off by a sixth of the third derivative times the period squared.
    rough = np.abs(np.diff(v, 2, axis=0)).max(axis=0) / 6.0 + 1e-9
    assert (np.abs(slope - v[1:-1]).max(axis=0) <= 2.0 * rough).all()
    assert np.abs(v).max() > 0.3


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_look_ahead_is_the_plants_own_way(name):
    scenario = ideal(name, 0.6)
    _, seen = watched(scenario, shaken(scenario))
    horizon = Horizon(move_of(scenario), length=1.0, intervals=2)
    first, last = 10, len(seen) - 1
    held = [(b[0] - a[0], a[3]) for a, b in zip(seen[first:last], seen[first + 1 :], strict=False)]
    n = len(seen[first][1])
    then = horizon.ahead(seen[first][1], seen[first][2], held)
    assert then[:n] == pytest.approx(seen[last][1], abs=1e-6)
    assert then[n:] == pytest.approx(seen[last][2], abs=1e-5)


def test_both_solvers_find_the_same_plan():
    scenario = ideal("exp1_1", 1.0)
    move = move_of(scenario)
    plans = [
        Horizon(move, length=2.0, intervals=16, solver=solver).plan(move.start, 0.0 * move.start)
        for solver in ("fatrop", "ipopt")
    ]
    assert all(p.solved for p in plans)
    size = move.input_upper.max()
    assert plans[0].inputs == pytest.approx(plans[1].inputs, abs=1e-3 * size)
    assert plans[0].q == pytest.approx(plans[1].q, abs=1e-4)
    assert (plans[0].inputs <= move.input_upper + 1e-6).all()
    assert (plans[0].inputs >= move.input_lower - 1e-6).all()


def test_at_the_goal_there_is_nothing_to_do():
    move = move_of(ideal("exp1_1", 1.0))
    plan = Horizon(move, length=1.0, intervals=8).plan(move.goal, 0.0 * move.goal)
    assert plan.inputs == pytest.approx(np.tile(move.input_goal, (8, 1)), abs=1e-4)
    assert plan.q == pytest.approx(np.tile(move.goal, (9, 1)), abs=1e-5)


@pytest.mark.parametrize("name", FLIGHTS)
def test_it_flies_sooner_to_rest_than_the_papers_law_with_no_more_force(name):
    scenario = ideal(name, 4.0)
    run = ml.simulate(scenario, "nmpc")
    assert run.finished
    most = np.array(law_force(scenario))
    assert (np.array(scenario.model.command_peaks(run)) <= most + 1e-4).all()
    assert run.metrics["combined_settling"] < 4.0
    assert np.isnan(ml.simulate(scenario).metrics["combined_settling"])


def test_delay_is_made_up_for():
    scenario = ideal("exp1_1", 5.0).with_values({"actuators.command_delay": 0.1})

    def left(lead):
        law = PythonLaw("nmpc", "NMPC", lambda s: Nmpc(s, lead=lead, weights=Weights()).step)
        run = ml.simulate(scenario, law)
        late = run["t"] > 4.0
        return np.abs(run["theta1"][late]).max()

    assert left(None) < 0.5 * left(0.0)


def test_what_it_cannot_do_is_said():
    with pytest.raises(ControllerError, match="is the start: there is no move"):
        ml.simulate(ml.load("exp2").with_values({"simulation.duration": 0.1}),
                    PythonLaw("nmpc", "NMPC", lambda s: Nmpc(s, force=(3, 3)).step))  # fmt: skip
    with pytest.raises(ScenarioError, match=r"plant\.cables"):
        Nmpc(
            ideal("exp1_1_quadrotors", 1.0).with_values({"plant.cables": "elastic"}),
            force=(3, 3, 3),
        )


def test_the_command_knows_it_by_name(tmp_path):
    arguments = ("run", "exp1_1", "--controller", "nmpc", "--set", "simulation.duration=0.2")
    flown = multilift(*arguments, cwd=tmp_path)
    assert flown.returncode == 0, flown.stderr
    assert "NMPC" in flown.stdout
    assert "nmpc" in multilift("run", "exp1_1", "--controller", "what", cwd=tmp_path).stderr
