"""Worlds stepped by hand through actuators and sensors that are not ideal, as simulate has them."""

import multilift as ml
import numpy as np
import pytest
from multilift import _core
from multilift.isa import available
from multilift.overrides import Columns
from planar_runs import coordinates, rates

SETS = available()
SHOWN = ("q", "q_dot", "measured_q", "measured_q_dot", "saturated", "tension", "t", "culprit")
# Sampling that falls on few control instants, and a delay that falls on none.
ODD = {"sensors.period": 0.015, "sensors.delay": 0.007}


def shortened(name="exp1_1", duration=1.5, **values):
    return ml.load(name).with_values(
        {"simulation.duration": duration, "simulation.record_period": 0.001, **values}
    )


def compiled_law(scenario):
    return _core.PlanarLaw(
        scenario.law,
        scenario.gain_values(),
        scenario.assumed_values(),
        scenario.goal_vector().tolist(),
        scenario.control_period(),
    )


def told(worlds):
    """What each world's law is told: coordinates, rates, whether its command hit a limit."""
    return zip(worlds.measured_q, worlds.measured_q_dot, worlds.saturated.tolist(), strict=True)


def fly(worlds, laws):
    """Steps worlds, one law each, until all have ended; their true tracks by control instant."""
    track = [np.hstack([worlds.q, worlds.q_dot])]
    while worlds.running.any():
        worlds.step(np.array([law.step(*m) for law, m in zip(laws, told(worlds), strict=True)]))
        track.append(np.hstack([worlds.q, worlds.q_dot]))
    return np.array(track)


def control_instants(run, worlds):
    """The run's rows at which worlds stood still between steps, shape (n, 14)."""
    every = round(worlds.period / run.scenario["simulation.step"])
    rows = np.unique(np.append(np.arange(0, len(run.t), every), len(run.t) - 1))
    return np.hstack([coordinates(run), rates(run)])[rows]


@pytest.mark.parametrize("isa", SETS)
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("exp1_1", {}),
        ("exp2", {}),  # with a push
        ("exp1_2", ODD),
        ("exp1_1", {"actuators.tilt_max": 0.05, "actuators.thrust_max": 17.0}),  # saturates
        ("exp1_1", {"controller.assumed.bar_mass": 0.5, "simulation.duration": 0.333}),
        ("exp1_1", {"actuators": {"command_delay": 0.013}, "sensors": {"delay": 0.3}}),
        ("exp1_1", {"actuators": {}, "controller.rate": 1000.0}),
        ("sim1", {"actuators.thrust_time_constant": 0.05}),  # and no sensors
    ],
)
def test_the_laws_commands_reproduce_simulate_to_the_last_bit(name, values, isa):
    scenario = shortened(name).with_values(values)
    run = ml.simulate(scenario)
    worlds = ml.Worlds(scenario, count=3, isa=isa)
    assert not worlds.ideal
    track = fly(worlds, [compiled_law(scenario) for _ in range(3)])
    for world in range(3):
        np.testing.assert_array_equal(track[:, world], control_instants(run, worlds))
    assert set(worlds.status) == {run.status} == {"finished"}
    np.testing.assert_array_equal(worlds.t, run.end_time)


def own_numbers(count):
    draw = np.random.default_rng(5)
    return {
        "simulation.seed": np.arange(count) + 2**40,
        "actuators.command_delay": np.round(draw.uniform(0.0, 0.05, count), 3),
        "actuators.attitude_time_constant": draw.uniform(0.0, 0.15, count),
        "sensors.delay": np.round(draw.uniform(0.0, 0.03, count), 3),
        "plant.bar_mass": draw.uniform(0.3, 0.5, count),
    }


def test_worlds_that_differ_go_where_each_would_go_alone():
    scenario, count = shortened(duration=1.0), 11
    worlds = ml.Worlds(scenario, own_numbers(count))
    alone = [Columns(scenario, own_numbers(count), None).world(k) for k in range(count)]
    track = fly(worlds, [compiled_law(s) for s in alone])
    for k, s in enumerate(alone):
        np.testing.assert_array_equal(track[:, k], control_instants(ml.simulate(s), worlds))


@pytest.mark.parametrize("values", [{}, ODD], ids=["shipped", "odd"])
def test_what_is_measured_is_what_a_law_in_simulate_is_told(values):
    scenario = shortened(duration=0.5, **values)
    seen = []

    def law(m):
        seen.append(np.concatenate([m.xi.ravel(), m.theta, m.xi_dot.ravel(), m.theta_dot]))
        return force(m.t)

    def force(t):
        return np.array([np.sin(9.0 * t), 0.4, -0.3, np.cos(7.0 * t)])

    ml.simulate(scenario, law)
    worlds = ml.Worlds(scenario, count=2)
    for k, expected in enumerate(seen):
        shown = np.hstack([worlds.measured_q, worlds.measured_q_dot])
        np.testing.assert_array_equal(shown, np.tile(expected, (2, 1)))
        assert k == 0 or not np.array_equal(worlds.measured_q, worlds.q)
        worlds.step(np.tile(force(k * worlds.period), (2, 1)))


def forces(seed, steps, count):
    return np.random.default_rng(seed).normal(0.0, 2.0, (steps, count, 4))


def assert_same(worlds, mask, others, other_mask=None):
    for name in SHOWN:
        expected = getattr(others, name)[mask if other_mask is None else other_mask]
        np.testing.assert_array_equal(getattr(worlds, name)[mask], expected, err_msg=name)


@pytest.mark.parametrize("isa", SETS)
def test_threads_order_and_instruction_set_change_no_bit(isa):
    scenario, count = shortened(duration=0.3, **ODD), 301
    numbers = own_numbers(count)
    shuffle = np.random.default_rng(2).permutation(count)
    reference = ml.Worlds(scenario, numbers, threads=1, isa="baseline")
    worlds = ml.Worlds(scenario, numbers, threads=3, isa=isa)
    shuffled = ml.Worlds(scenario, {k: v[shuffle] for k, v in numbers.items()}, isa=isa)
    everyone = np.ones(count, dtype=bool)
    for u in forces(0, 30, count):
        reference.step(u)
        worlds.step(u)
        shuffled.step(u[shuffle])
    assert_same(worlds, everyone, reference)
    assert_same(shuffled, everyone, reference, shuffle)


@pytest.mark.parametrize("values", [{}, ODD, {"sensors.period": 0.001}], ids=str)
def test_worlds_begin_again_one_by_one_with_the_noise_they_had(values):
    # After every reset a world goes where a fresh one goes that is given the same forces, whatever
    # its neighbours in the register do and whenever they began.
    scenario, count = shortened(duration=0.25, **values), 9  # 25 steps an episode
    worlds = ml.Worlds(scenario, own_numbers(count))
    every = forces(4, 25, count)
    begun = np.zeros(count, dtype=int)
    fresh = [ml.Worlds(scenario, own_numbers(count)) for _ in range(25)]  # step k of an episode
    for k, each in enumerate(fresh):
        for u in every[:k]:
            each.step(u)
    choice = np.random.default_rng(6)
    for step in range(60):
        mask = choice.random(count) < 0.15
        mask |= step - begun >= 24
        worlds.reset(mask)
        worlds.reset(mask)  # twice does no harm
        begun[mask] = step
        age = step - begun
        for k in range(count):
            assert_same(worlds, np.arange(count) == k, fresh[age[k]])
        worlds.step(every[age, np.arange(count)])


def test_a_new_seed_gives_new_noise_and_the_old_one_the_old():
    scenario = shortened(duration=0.2)
    worlds = ml.Worlds(scenario, {"simulation.seed": [1, 1, 2]})
    assert np.array_equal(worlds.measured_q[0], worlds.measured_q[1])
    worlds.step(np.zeros((3, 4)))
    first = worlds.measured_q.copy()
    assert np.array_equal(first[0], first[1]) and not np.array_equal(first[0], first[2])
    mask = np.array([True, False, True])
    worlds.reset(mask, {"simulation.seed": np.array([2, 7, 1])})
    worlds.step(np.zeros((3, 4)))
    np.testing.assert_array_equal(worlds.measured_q[[0, 2]], first[[2, 0]])
    worlds.reset(overrides={"simulation.seed": np.array([1, 1, 2])})
    worlds.step(np.zeros((3, 4)))
    np.testing.assert_array_equal(worlds.measured_q, first)


def test_an_ended_world_shows_what_it_was_told_last():
    push = {"body": "bar", "start": 0.1, "duration": 0.8, "force": [0.0, 0.0]}
    scenario = shortened(duration=1.0, push=[push], **ODD)
    upwards = np.where(np.arange(10) == 3, 20.0, 0.0)  # N, several times the load's weight
    worlds = ml.Worlds(scenario, {"push[0].force[1]": upwards})
    lonely = ml.Worlds(scenario, {"push[0].force[1]": upwards[3:4]})
    u = np.zeros((10, 4))
    while worlds.running[3]:
        worlds.step(u)
        lonely.step(u[3:4])
    assert worlds.status[3] == "slack"
    third = np.arange(10) == 3
    assert_same(worlds, third, lonely, np.array([True]))
    for _ in range(5):
        worlds.step(u)
    assert_same(worlds, third, lonely, np.array([True]))
    assert worlds.running.sum() == 9


def test_ideal_worlds_are_told_the_truth():
    worlds = ml.Worlds(ml.load("sim1"), count=2)
    assert worlds.ideal
    worlds.step(np.ones((2, 4)))
    np.testing.assert_array_equal(worlds.measured_q, worlds.q)
    np.testing.assert_array_equal(worlds.measured_q_dot, worlds.q_dot)
    assert not worlds.saturated.any()


def test_a_world_without_imperfections_among_others_flies_as_an_ideal_one_to_round_off():
    scenario = ml.load("sim1").with_values({"simulation.duration": 1.0})
    mixed = ml.Worlds(scenario, {"actuators.command_delay": [0.0, 0.02]})
    ideal = ml.Worlds(scenario, count=1)
    assert not mixed.ideal
    fly(mixed, [compiled_law(scenario) for _ in range(2)])
    fly(ideal, [compiled_law(scenario)])
    # A thousand commands pass through thrust and attitude and back, a few roundings each, of a
    # force of 24 N; what a second of flight makes of them stays far below a picometre.
    np.testing.assert_allclose(mixed.q[0], ideal.q[0], rtol=0, atol=1e-12)
    assert np.abs(mixed.q[1] - ideal.q[0]).max() > 1e-3


def test_what_worlds_cannot_become_is_said():
    worlds = ml.Worlds(ml.load("sim1"), count=2)
    with pytest.raises(ml.ScenarioError, match=r"Worlds\.reset"):
        worlds.reset(overrides={"sensors.angle_noise": np.array([0.0, 0.01])})
    long = {"sensors.period": 0.011, "sensors.delay": 2.0}  # one sample in 11 steps, for 2000
    with pytest.raises(ml.ScenarioError, match=r"sensors\.delay"):
        ml.Worlds(shortened(**long))
    assert ml.Worlds(shortened(**long | {"sensors.period": 0.01})).count == 1
