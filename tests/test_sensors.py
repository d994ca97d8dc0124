"""What a law is told: the truth, late, in samples, and blurred by reproducible noise."""

from itertools import combinations

import multilift as ml
import numpy as np
import pytest
from planar_runs import at_every_step, trajectory
from scipy.stats import kstest

STEP = 0.001  # s
NOISE = {  # standard deviation and the channels of [q, q_dot] that it blurs
    "position_noise": (0.02, range(0, 4)),
    "angle_noise": (0.01, range(4, 7)),
    "velocity_noise": (0.05, range(7, 11)),
    "angle_rate_noise": (0.03, range(11, 14)),
}


def observed(duration=1.0, rate=1000.0, seed=1, **sensors):
    """The run, and what its law was told at each control instant, shape (n, 14)."""
    told = []

    def law(m):
        told.append(np.concatenate([m.xi.ravel(), m.theta, m.xi_dot.ravel(), m.theta_dot]))
        return (np.sin(3.0 * m.t), 0.3, 0.0, -0.4)

    values = {f"sensors.{key}": value for key, value in sensors.items()}
    scenario = at_every_step(ml.load("sim1")).with_values(
        {"simulation.duration": duration, "simulation.seed": seed, "controller.rate": rate} | values
    )
    return ml.simulate(scenario, law), np.array(told)


def test_ideal_sensors_tell_the_truth():
    run, told = observed()
    np.testing.assert_array_equal(told, trajectory(run))


@pytest.mark.parametrize("delay", [0.001, 0.03])
def test_a_measurement_arrives_exactly_its_delay_later(delay):
    run, told = observed(delay=delay)
    late = round(delay / STEP)
    truth = trajectory(run)
    # Until the first sample has arrived the law is told the start.
    expected = np.vstack([np.tile(truth[0], (late, 1)), truth[: len(truth) - late]])
    np.testing.assert_array_equal(told, expected)


def test_samples_are_held_until_the_next_one():
    run, told = observed(period=0.008, delay=0.003)
    sampled = np.maximum(np.floor((np.arange(len(run.t)) - 3) / 8).astype(int) * 8, 0)
    np.testing.assert_array_equal(told, trajectory(run)[sampled])


def test_without_a_period_sampling_follows_the_control_instants():
    run, told = observed(rate=100.0, delay=0.004)
    # At each instant the newest sample that is 4 ms old is the previous instant's.
    truth = trajectory(run)[::10]
    np.testing.assert_array_equal(told, np.vstack([truth[0], truth[:-1]]))


@pytest.fixture(scope="module")
def noise():
    """Noise on every channel, in units of its standard deviation, shape (20001, 14)."""
    run, told = observed(duration=20.0, **{name: size for name, (size, _) in NOISE.items()})
    size = np.empty(14)
    for deviation, channels in NOISE.values():
        size[list(channels)] = deviation
    return (told - trajectory(run)) / size


def test_noise_is_standard_normal_on_every_channel(noise):
    for channel in noise.T:
        # The seed is fixed; 1e-4 is what 14 fair channels would fall below once in 700 seeds.
        assert kstest(channel, "norm").pvalue > 1e-4


def test_noise_is_white_and_its_channels_independent(noise):
    bound = 4.5 / np.sqrt(len(noise))  # standard errors of a correlation of 0
    for channel in noise.T:
        for lag in (1, 2, 10):
            assert abs(np.mean(channel[lag:] * channel[:-lag])) < bound
    for a, b in combinations(noise.T, 2):
        assert abs(np.mean(a * b)) < bound


def test_a_seed_gives_the_same_run_to_the_last_bit_and_another_seed_another_run():
    scenario = ml.load("exp1_1").with_values({"simulation.duration": 2.0})
    first, again = (ml.simulate(scenario) for _ in range(2))
    other = ml.simulate(scenario.with_values({"simulation.seed": 2}))
    for name in first.columns:
        np.testing.assert_array_equal(first[name], again[name])
    assert np.abs(trajectory(other) - trajectory(first)).max() > 1e-4


@pytest.mark.parametrize("name", NOISE)
def test_each_noise_keeps_its_draws_whichever_others_are_on(name):
    size, channels = NOISE[name]
    channels = list(channels)
    everything = {key: deviation for key, (deviation, _) in NOISE.items()}
    (run_all, all_on), (run_one, one_on) = observed(**everything), observed(**{name: size})
    blur = (one_on - trajectory(run_one))[:, channels]
    assert np.abs(blur).min() > 0
    np.testing.assert_allclose((all_on - trajectory(run_all))[:, channels], blur, atol=1e-12)
    silent = np.delete(np.arange(14), channels)
    np.testing.assert_array_equal(one_on[:, silent], trajectory(run_one)[:, silent])
