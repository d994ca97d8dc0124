"""The vector environment keeps Gymnasium's promises and flies the worlds it says."""

import subprocess
import sys

import multilift as ml
import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="gymnasium is not installed")

from gymnasium.vector import AutoresetMode  # noqa: E402
from multilift.gym import TwinLiftVectorEnv, Weights  # noqa: E402

DRAWS = {"plant.bar_mass": (0.6, 1.0), "start.vehicle_position[0][0]": (0.7, 0.9)}


def scenario(duration=0.2, **values):
    return ml.load("sim1").with_values(
        {"simulation.duration": duration, "controller.rate": 50.0, **values}
    )


def environments(count=5, duration=0.2, **options):
    return TwinLiftVectorEnv(scenario(duration), count, draws=DRAWS, **options)


def test_spaces_and_returns_are_as_gymnasium_wants_them():
    env = environments()
    assert isinstance(env, gymnasium.vector.VectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert env.action_space.shape == (5, 4)
    assert env.observation_space.shape == (5, 14)
    assert env.action_space == gymnasium.vector.utils.batch_space(env.single_action_space, 5)
    assert env.observation_space.dtype == np.float64
    observations, infos = env.reset(seed=3)
    assert observations in env.observation_space
    assert isinstance(infos, dict)
    env.action_space.seed(0)
    for _ in range(30):
        observations, rewards, terminated, truncated, infos = env.step(env.action_space.sample())
        assert observations in env.observation_space
        assert rewards.shape == terminated.shape == truncated.shape == (5,)
        assert rewards.dtype == np.float64
        assert terminated.dtype == truncated.dtype == np.bool_
        assert np.isfinite(rewards).all()
        assert not (terminated & truncated).any()
        assert infos["status"].shape == (5,)
    env.close()
    assert env.closed


def rollout(env, seed, steps=25):
    rng = np.random.default_rng(0)
    seen = [env.reset(seed=seed)[0]]
    for _ in range(steps):
        seen.append(env.step(rng.normal(0, 2, (env.num_envs, 4)))[0])
    return np.array(seen)


def test_a_seed_decides_every_draw():
    reference = rollout(environments(), 7)
    np.testing.assert_array_equal(rollout(environments(), 7), reference)
    env = environments()
    rollout(env, 1)
    np.testing.assert_array_equal(rollout(env, 7), reference)
    assert not np.array_equal(rollout(environments(), 8)[0], reference[0])
    assert len(np.unique(reference[0], axis=0)) == 5
    # Later episodes draw anew; environment k does not depend on how many there are.
    assert not np.array_equal(reference[11], reference[0])
    np.testing.assert_array_equal(environments(2).reset(seed=7)[0], reference[0, :2])
    first = env.reset(seed=7)[0]
    assert not np.array_equal(env.reset()[0], first)


def test_observations_are_arrays_of_their_own():
    env = environments()
    before = env.reset(seed=0)[0]
    copy = before.copy()
    env.step(np.ones((5, 4)))
    np.testing.assert_array_equal(before, copy)


def test_an_episode_is_truncated_at_the_duration_and_begins_anew_at_the_next_step():
    env = TwinLiftVectorEnv(scenario(), 3)  # 10 steps, every episode the same
    start, _ = env.reset(seed=0)
    u = np.full((3, 4), 0.5)
    episodes = []
    for _ in range(2):
        episode = []
        for k in range(10):
            observations, rewards, terminated, truncated, _ = env.step(u)
            assert not terminated.any()
            assert truncated.tolist() == [k == 9] * 3
            assert (rewards < 0).all()
            episode.append(observations)
        episodes.append(episode)
        observations, rewards, terminated, truncated, infos = env.step(u)
        np.testing.assert_array_equal(observations, start)
        np.testing.assert_array_equal(rewards, 0.0)
        assert not (terminated | truncated).any()
        assert set(infos["status"]) == {"running"}
    np.testing.assert_array_equal(*episodes)


def test_failing_terminates_its_own_environment_only():
    env = TwinLiftVectorEnv(scenario(5.0), 4, force_limit=100.0, weights=Weights(failure=7.0))
    env.reset(seed=0)
    u = np.zeros((4, 4))
    u[2, [1, 3]] = -60.0  # pushed down faster than the load falls
    _, rewards, terminated, truncated, infos = env.step(u)
    assert terminated.tolist() == [False, False, True, False]
    assert not truncated.any()
    assert infos["status"][2] == "slack"
    assert rewards[2] == -7.0
    assert (rewards[[0, 1, 3]] > -7.0).all()
    _, rewards, terminated, _, infos = env.step(u)
    assert rewards[2] == 0.0
    assert not terminated.any()
    assert infos["status"][2] == "running"
    assert env.worlds.t.tolist() == [0.04, 0.04, 0.0, 0.04]


@pytest.mark.parametrize("force", [1e9, np.nan])
def test_a_diverged_world_shows_finite_numbers(force):
    env = TwinLiftVectorEnv(scenario(), 2, force_limit=np.inf)
    env.reset(seed=0)
    u = np.zeros((2, 4))
    u[1] = force
    observations, rewards, terminated, _, _ = env.step(u)
    assert terminated.tolist() == [False, True]
    assert np.isfinite(observations).all() and np.isfinite(rewards).all()
    assert observations in env.observation_space


def test_the_reward_is_the_documented_one():
    weights = Weights(position=2.0, velocity=0.3, angle=4.0, angle_rate=0.5, force=0.06)
    env = TwinLiftVectorEnv(scenario(), 1, weights=weights, force_limit=[1.0, 2.0, 3.0, 4.0])
    env.reset(seed=0)
    observations, rewards, *_ = env.step(np.full((1, 4), 100.0))
    x = observations[0]
    cost = (
        2.0 * x[:4] @ x[:4] + 0.3 * x[4:8] @ x[4:8] + 4.0 * x[8:11] @ x[8:11]
        + 0.5 * x[11:] @ x[11:] + 0.06 * (1 + 4 + 9 + 16)
    )  # fmt: skip
    np.testing.assert_allclose(rewards, -0.02 * cost, rtol=1e-14)


def test_the_default_bounds_keep_the_thrust_within_half_of_hovering():
    box = TwinLiftVectorEnv(scenario()).single_action_space
    np.testing.assert_allclose(box.high, 0.5 * (2.0 + 0.4) * 9.8)
    np.testing.assert_allclose(box.low, -box.high)


def test_a_policy_flies_as_the_same_law_in_simulate():
    s = scenario(0.5)
    goal = s.goal_vector()
    run = ml.simulate(s, lambda m: -6.0 * (m.xi.ravel() - goal) - 7.0 * m.xi_dot.ravel())
    env = TwinLiftVectorEnv(s, 2, force_limit=np.inf)
    x, _ = env.reset()
    while env.worlds.running.any():
        x, *_ = env.step(-6.0 * x[:, :4] - 7.0 * x[:, 4:8])
    np.testing.assert_array_equal(x[1, 8], run["theta1"][-1])


def flown(observe, seed, episodes=1):
    """Observations and rewards of testbed environments under forces drawn once and for all."""
    testbed = ml.load("exp1_1").with_values({"simulation.duration": 0.2})
    env = TwinLiftVectorEnv(testbed, 3, draws={"plant.bar_mass": (0.3, 0.4)}, observe=observe)
    rng = np.random.default_rng(0)
    seen, rewards = [env.reset(seed=seed)[0]], []
    for _ in range(20 * episodes + episodes - 1):
        observation, reward, *_ = env.step(rng.normal(0, 2, (3, 4)))
        seen.append(observation)
        rewards.append(reward)
    return env, np.array(seen), np.array(rewards)


def test_observations_are_the_truth_or_what_is_measured():
    env, truth, rewards = flown("truth", 1)
    worlds = env.worlds
    np.testing.assert_array_equal(truth[-1][:, 8:11], worlds.q[:, 4:])
    told, measured, same_rewards = flown("measured", 1)
    np.testing.assert_array_equal(told.worlds.q, worlds.q)
    np.testing.assert_array_equal(measured[-1][:, 8:11], worlds.measured_q[:, 4:])
    np.testing.assert_array_equal(measured[-1][:, :4], worlds.measured_q[:, :4] - worlds.goal)
    np.testing.assert_array_equal(measured[-1][:, 11:], worlds.measured_q_dot[:, 4:])
    assert not (measured == truth).any(axis=2)[1:].all()
    # The same flights cost the same, whatever is seen of them.
    np.testing.assert_array_equal(same_rewards, rewards)
    with pytest.raises(ml.ScenarioError, match="observe"):
        TwinLiftVectorEnv(scenario(), 2, observe="guessed")


def test_noise_follows_the_seed_and_differs_between_environments_and_episodes():
    _, first, _ = flown("measured", 3, episodes=2)
    _, again, _ = flown("measured", 3, episodes=2)
    _, other, _ = flown("measured", 4, episodes=2)
    np.testing.assert_array_equal(again, first)
    # A step after the start what was measured there arrives: a load at rest, and noise.
    begun = np.vstack([x[k, :, 8] for x in (first, other) for k in (1, 22)])
    assert len(np.unique(begun)) == begun.size
    assert np.abs(begun).max() < np.radians(0.5)  # five times the noise's deviation
    ideal = TwinLiftVectorEnv(scenario(), 2, observe="measured")
    x, _ = ideal.reset(seed=0)
    np.testing.assert_array_equal(x[:, 8:11], ideal.worlds.q[:, 4:])


def test_a_mask_resets_some():
    env = environments()
    env.reset(seed=0)
    env.step(np.ones((5, 4)))
    mask = np.arange(5) < 2
    env.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(env.worlds.t > 0, ~mask)


def test_stepping_before_reset_and_impossible_draws_are_refused():
    with pytest.raises(gymnasium.error.ResetNeeded):
        environments().step(np.zeros((5, 4)))
    env = environments()
    env.reset()
    with pytest.raises(ml.ControllerError, match="shape"):
        env.step(np.zeros((4, 4)))
    with pytest.raises(ml.ScenarioError, match="no range"):
        TwinLiftVectorEnv(scenario(), 2, draws={"plant.bar_mass": (1.0, 0.5)})
    with pytest.raises(ml.ScenarioError, match="out of range"):
        TwinLiftVectorEnv(scenario(), 2, draws={"plant.bar_mass": (-1.0, 0.5)})
    with pytest.raises(ml.ScenarioError, match="impossible"):
        TwinLiftVectorEnv(scenario(), 2, draws={"start.vehicle_position[1][0]": (2.6, 9.0)})
    with pytest.raises(ml.ScenarioError, match="not a known key"):
        TwinLiftVectorEnv(scenario(), 2, draws={"plant.bar_mas": (0.4, 0.5)})


def test_gymnasiums_wrappers_fit():
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(environments())
    env = gymnasium.wrappers.vector.ClipReward(env, -1.0, 0.0)
    env.reset(seed=0)
    for _ in range(10):
        *_, infos = env.step(np.zeros((5, 4)))
    np.testing.assert_array_equal(infos["episode"]["l"], 10)


def test_without_gymnasium_the_extra_is_named():
    code = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "import multilift\n"
        "try:\n    import multilift.gym\n"
        "except multilift.MissingExtraError as error:\n    print(error)\n"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert "multilift[gym]" in answer.stdout
