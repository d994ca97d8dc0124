"""Worlds stepped by hand go where simulate goes, and end each on its own."""

import threading

import multilift as ml
import numpy as np
import pytest
from multilift import _core
from multilift.isa import available
from multilift.models.planar.laws import Measurement
from planar_runs import commands, coordinates, rates

SETS = available()


def compiled_law(scenario):
    """The scenario's law for one world, stepped from Python."""
    return _core.PlanarLaw(
        scenario.law,
        scenario.gain_values(),
        scenario.assumed_values(),
        scenario.goal_vector().tolist(),
        scenario.control_period(),
    )


def fly(worlds, laws):
    """Steps worlds, one law each, until all have ended; their tracks by control instant."""
    track = [(worlds.q.copy(), worlds.q_dot.copy())]
    while worlds.running.any():
        u = [law.step(q, v) for law, q, v in zip(laws, worlds.q, worlds.q_dot, strict=True)]
        worlds.step(np.array(u))
        track.append((worlds.q.copy(), worlds.q_dot.copy()))
    return np.array([q for q, _ in track]), np.array([v for _, v in track])


PUSHES = [
    {"body": "bar", "start": 0.25, "duration": 0.5, "force": [1.0, 0.3], "torque": 0.1},
    {"body": "vehicle_1", "start": 0.1, "duration": 0.7, "force": [2.0, 1.0], "shape": "half_sine"},
]


def short(name="sim1", duration=1.0, **values):
    return ml.load(name).with_values(
        {"simulation.duration": duration, "simulation.record_period": 0.001, **values}
    )


@pytest.mark.parametrize("isa", SETS)
@pytest.mark.parametrize(
    "values",
    [
        {},
        {"push": PUSHES},
        {"controller.rate": 100.0, "controller.assumed.bar_mass": 1.1},
        {"controller.rate": 40.0, "simulation.duration": 0.31},  # the last period is cut short
        {"simulation.step": 0.002, "controller.rate": 500.0, "simulation.record_period": 0.002},
    ],
)
def test_the_laws_commands_reproduce_simulate_to_the_last_bit(values, isa):
    scenario = short(**values)
    run = ml.simulate(scenario)
    worlds = ml.Worlds(scenario, count=3, isa=isa)
    laws = [compiled_law(scenario) for _ in range(3)]
    q, q_dot = fly(worlds, laws)
    every = round(worlds.period / scenario["simulation.step"])
    rows = np.unique(np.append(np.arange(0, len(run.t), every), len(run.t) - 1))
    for world in range(3):
        np.testing.assert_array_equal(q[:, world], coordinates(run)[rows])
        np.testing.assert_array_equal(q_dot[:, world], rates(run)[rows])
    assert set(worlds.status) == {"finished"}
    np.testing.assert_array_equal(worlds.t, run.end_time)


def failing():
    """Numbers under which worlds end differently: by slack, by a limit, and not at all."""
    return {
        "push[0].force[0]": np.array([0.0, 9.0, 4.0, 14.0, 0.5]),
        "push[0].force[1]": np.array([0.0, 0.0, 14.0, 5.0, 2.0]),
        "plant.bar_mass": np.array([0.8, 0.8, 0.4, 0.3, 1.0]),
    }


PUSHED = {"push": [{"body": "bar", "start": 0.2, "duration": 0.9, "force": [0.0, 0.0]}]}


def test_worlds_end_as_the_same_runs_end_and_stay_so():
    scenario = short(duration=1.5, **PUSHED)
    worlds = ml.Worlds(scenario, failing(), threads=2)
    from multilift.overrides import Columns

    alone = [Columns(scenario, failing(), None).world(k) for k in range(worlds.count)]
    runs = [ml.simulate(s) for s in alone]
    assert {"finished", "slack"} < {run.status for run in runs} | {"swing_limit"}
    q, q_dot = fly(worlds, [compiled_law(s) for s in alone])
    for k, run in enumerate(runs):
        assert worlds.status[k] == run.status
        assert worlds.t[k] == run.end_time
        assert worlds.culprit[k] == run.culprit
        np.testing.assert_array_equal(q[-1, k], coordinates(run)[-1])
        np.testing.assert_array_equal(q_dot[-1, k], rates(run)[-1])
        if run.status == "slack":
            np.testing.assert_array_equal(
                worlds.tension[k], [run["tension1"][-1], run["tension2"][-1]]
            )
    # Frozen: further steps, whatever they are given, change nothing.
    before = worlds.q.copy()
    worlds.step(np.full((worlds.count, 4), np.nan))
    np.testing.assert_array_equal(worlds.q, before)


def test_forces_that_are_no_numbers_end_their_own_world_only():
    scenario = short(duration=0.1)
    alone = ml.Worlds(scenario, count=1)
    worlds = ml.Worlds(scenario, count=11)
    u = np.zeros((11, 4))
    u[4, 2] = np.nan
    u[7] = np.inf
    while worlds.running.any():
        worlds.step(u)
        alone.step(np.zeros((1, 4)))
    assert worlds.status.tolist() == ["diverged" if k in (4, 7) else "finished" for k in range(11)]
    assert worlds.failed.sum() == 2
    sound = [k for k in range(11) if k not in (4, 7)]
    np.testing.assert_array_equal(worlds.q[sound], np.tile(alone.q, (9, 1)))
    assert worlds.t[4] == 0.0 and np.isfinite(worlds.q[4]).all()  # as before the force


def random_forces(seed, steps, count):
    return np.random.default_rng(seed).normal(0.0, 2.0, (steps, count, 4))


def masses(count):
    return {"plant.bar_mass": np.random.default_rng(1).uniform(0.5, 1.0, count)}


@pytest.mark.parametrize("isa", SETS)
def test_threads_order_and_instruction_set_change_no_bit(isa):
    scenario = short(duration=0.3, **{"controller.rate": 100.0})
    count = 301
    forces = random_forces(0, 30, count)
    reference = ml.Worlds(scenario, masses(count), threads=1, isa="baseline")
    worlds = ml.Worlds(scenario, masses(count), threads=3, isa=isa)
    shuffle = np.random.default_rng(2).permutation(count)
    shuffled = ml.Worlds(scenario, {k: v[shuffle] for k, v in masses(count).items()}, isa=isa)
    for u in forces:
        reference.step(u)
        worlds.step(u)
        shuffled.step(u[shuffle])
    for name in ("q", "q_dot", "tension", "t"):
        np.testing.assert_array_equal(getattr(worlds, name), getattr(reference, name))
        np.testing.assert_array_equal(getattr(shuffled, name), getattr(reference, name)[shuffle])


def test_reset_puts_the_worlds_of_the_mask_back_and_leaves_the_others():
    scenario = short(duration=0.3, push=PUSHES)  # pushes: each world keeps its own time
    count = 13
    worlds, fresh = (ml.Worlds(scenario, masses(count)) for _ in range(2))
    undisturbed = ml.Worlds(scenario, masses(count))
    early, late = random_forces(3, 120, count), random_forces(4, 100, count)
    for u in early:
        worlds.step(u)
        undisturbed.step(u)
    mask = np.arange(count) % 3 == 0
    worlds.reset(mask)
    np.testing.assert_array_equal(worlds.t[mask], 0.0)
    for name in ("q", "q_dot", "tension"):
        np.testing.assert_array_equal(getattr(worlds, name)[mask], getattr(fresh, name)[mask])
    for u in late:
        for each in (worlds, fresh, undisturbed):
            each.step(u)
    for name in ("q", "q_dot", "tension", "t"):
        np.testing.assert_array_equal(getattr(worlds, name)[mask], getattr(fresh, name)[mask])
        np.testing.assert_array_equal(
            getattr(worlds, name)[~mask], getattr(undisturbed, name)[~mask]
        )
    worlds.reset()
    assert worlds.running.all()
    np.testing.assert_array_equal(worlds.q, ml.Worlds(scenario, masses(count)).q)


def test_reset_takes_new_numbers_for_the_worlds_of_the_mask():
    scenario = short(duration=0.1)
    worlds = ml.Worlds(scenario, {"plant.bar_mass": [0.7, 0.8, 0.9]})
    mask = np.array([False, True, False])
    heavier = {"plant.bar_mass": np.array([5.0, 1.0, 5.0])}
    worlds.reset(mask, heavier)
    expected = ml.Worlds(scenario, {"plant.bar_mass": [0.7, 1.0, 0.9]})
    for _ in range(20):
        worlds.step(np.ones((3, 4)))
        expected.step(np.ones((3, 4)))
    np.testing.assert_array_equal(worlds.q, expected.q)


class Buffer:
    """An array of a library that offers nothing but DLPack."""

    def __init__(self, array):
        self._array = array
        self.shape = array.shape

    def __dlpack__(self, **kwargs):
        return self._array.__dlpack__(**kwargs)

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()


@pytest.mark.parametrize(
    "wrap",
    [
        Buffer,
        lambda u: u.tolist(),
        lambda u: u.astype(np.float32),
        np.asfortranarray,
        lambda u: np.repeat(u, 2, axis=1)[:, ::2],
    ],
)
def test_forces_come_as_numpy_dlpack_or_lists(wrap):
    u = np.arange(20.0).reshape(5, 4) / 8  # exact as single precision
    worlds, expected = (ml.Worlds(short(), count=5) for _ in range(2))
    worlds.step(wrap(u))
    expected.step(u)
    np.testing.assert_array_equal(worlds.q, expected.q)


@pytest.mark.parametrize(
    "forces",
    [
        np.zeros((4, 4)),
        np.zeros((5, 3)),
        np.zeros(20),
        1.0,
        np.full((5, 4), "x"),
        np.zeros((5, 4), complex),
    ],
)
def test_other_forces_are_refused(forces):
    worlds = ml.Worlds(short(), count=5)
    with pytest.raises((ml.ControllerError, ValueError)):
        worlds.step(forces)
    np.testing.assert_array_equal(worlds.t, 0.0)


def test_arrays_cannot_be_written():
    worlds = ml.Worlds(short(), count=2)
    with pytest.raises(ValueError, match="read-only"):
        worlds.q[0, 0] = 1.0


def test_what_worlds_cannot_be_is_said():
    assert ml.Worlds(ml.load("sim1")).status.tolist() == ["running"]
    with pytest.raises(ml.ScenarioError, match=r"simulation\.step"):
        ml.Worlds(ml.load("sim1"), {"simulation.step": [0.001, 0.002]})
    with pytest.raises(ml.ScenarioError, match="mask"):
        ml.Worlds(ml.load("sim1"), count=3).reset([True])
    with pytest.raises(ml.ScenarioError, match="in world 1"):
        ml.Worlds(ml.load("sim1"), {"plant.bar_mass": [1.0, -1.0]})


def test_a_vectorised_law_flies_as_the_same_law_alone():
    # A PD law over all worlds at once, with arithmetic that is the same for one.
    scenario = short(duration=0.5, **{"controller.rate": 100.0})
    goal = scenario.goal_vector()

    def pd(q, q_dot):
        return -6.0 * (q[..., :4] - goal) - 7.0 * q_dot[..., :4]

    def alone(m: Measurement):
        q = np.concatenate([m.xi.ravel(), m.theta])
        return pd(q, np.concatenate([m.xi_dot.ravel(), m.theta_dot]))

    run = ml.simulate(scenario, alone)
    worlds = ml.Worlds(scenario, count=4)
    np.testing.assert_array_equal(worlds.goal, np.tile(goal, (4, 1)))
    while worlds.running.any():
        worlds.step(pd(worlds.q, worlds.q_dot))
    np.testing.assert_array_equal(worlds.q, np.tile(coordinates(run)[-1], (4, 1)))
    assert commands(run).any()


def test_other_threads_run_while_worlds_step():
    worlds = ml.Worlds(short(duration=1.0, **{"controller.rate": 10.0}), count=4000, threads=1)
    ticks, stop = [], threading.Event()

    def count():
        while not stop.wait(0.001):
            ticks.append(None)

    thread = threading.Thread(target=count)
    thread.start()
    worlds.step(np.zeros((4000, 4)))
    during = len(ticks)
    stop.set()
    thread.join()
    assert during > 0
