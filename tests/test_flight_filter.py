"""The filter as a filter: unbiased, of the order it claims, as sure as it says."""

import itertools
import math
import random

import numpy as np
import pytest
from flight_scenes import RATE
from multilift.flight.estimate.chain import Chain
from multilift.flight.estimate.config import Tuning
from multilift.flight.estimate.filter import PoseFilter
from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Pose


def followed(position, seconds=4.0, attitude=lambda t: (1.0, 0.0, 0.0, 0.0), tuning=None):
    """A filter that was shown a path; times are not evenly spaced, as after lost frames."""
    tuning = tuning or Tuning()
    pose_filter = None
    for k in range(round(seconds * RATE)):
        if k % 7 == 3:
            continue
        t = k / RATE
        pose = Pose(position(t), attitude(t))
        if pose_filter is None:
            pose_filter = PoseFilter(tuning, t, pose)
        else:
            pose_filter.take(t, pose)
    return pose_filter


def test_constant_acceleration_is_followed_without_error():
    p, v, a = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.1, -0.2]), np.array([0.2, -0.4, 0.1])
    pose_filter = followed(lambda t: tuple(p + v * t + a * t * t / 2))
    t = pose_filter.time
    position, velocity, acceleration = pose_filter.motion(0.0)
    # what the first guess of zero leaves has decayed over some hundred frames
    assert position == pytest.approx(tuple(p + v * t + a * t * t / 2), abs=1e-7)
    assert velocity == pytest.approx(tuple(v + a * t), abs=1e-6)
    assert acceleration == pytest.approx(tuple(a), abs=1e-4)


def test_constant_angular_acceleration_is_followed_without_error():
    axis, rate, acceleration = (0.6, 0.0, 0.8), 0.4, 0.3
    pose_filter = followed(
        lambda t: (0.0, 0.0, 0.0),
        attitude=lambda t: rotations.from_vector(
            tuple((rate * t + acceleration * t * t / 2) * a for a in axis)
        ),
    )
    assert pose_filter.turning(0.0)[1] == pytest.approx(
        tuple((rate + acceleration * pose_filter.time) * a for a in axis), abs=1e-4
    )


def test_the_error_is_proportional_to_the_jerk():
    def velocity_error(jerk):
        pose_filter = followed(lambda t: (jerk * t**3 / 6, 0.0, 0.0))
        t = pose_filter.time
        return pose_filter.motion(0.0)[1][0] - jerk * t * t / 2

    once, twice = velocity_error(1.0), velocity_error(2.0)
    assert twice == pytest.approx(2 * once, rel=1e-3)


def test_extrapolation_is_of_third_order():
    pose_filter = followed(lambda t: (math.sin(t), 0.0, 0.0), tuning=Tuning(position_noise=1e-7))
    t = pose_filter.time
    errors = [abs(pose_filter.motion(h)[0][0] - math.sin(t + h)) for h in (0.4, 0.2, 0.1)]
    orders = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    # the next term of the series is h / 4 of it, 0.14 in the order at these steps
    assert orders == pytest.approx([3.0, 3.0], abs=0.2)


def test_it_is_as_sure_as_it_says():
    """Under the noise that it assumes, squared errors over variances average to one."""
    tuning, dt, rng = Tuning(), 1 / RATE, np.random.default_rng(5)
    h = dt * dt / 2
    step = np.array([[1, dt, h], [0, 1, dt], [0, 0, 1]])
    noise = tuning.jerk**2 * np.array(
        [
            [dt**5 / 20, dt**4 / 8, dt**3 / 6],
            [dt**4 / 8, dt**3 / 3, dt**2 / 2],
            [dt**3 / 6, dt**2 / 2, dt],
        ]
    )
    root = np.linalg.cholesky(noise)
    squares = []
    for _ in range(200):
        x = np.zeros((3, 3))
        pose_filter = None
        for k in range(80):
            seen = tuple(x[0] + rng.normal(0.0, tuning.position_noise, 3))
            if pose_filter is None:
                pose_filter = PoseFilter(tuning, 0.0, Pose(seen))
            else:
                pose_filter.take(k * dt, Pose(seen))
            if k < 79:
                x = step @ x + root @ rng.normal(size=(3, 3))
        position, velocity, _ = pose_filter.motion(0.0)
        sigmas = pose_filter.sigmas(0.0)
        squares.append(
            [
                np.mean((np.array(position) - x[0]) ** 2) / sigmas[0] ** 2,
                np.mean((np.array(velocity) - x[1]) ** 2) / sigmas[1] ** 2,
            ]
        )
    # 600 squares of unit normals: their mean has a deviation of sqrt(2 / 600); four of them
    assert np.mean(squares, axis=0) == pytest.approx([1.0, 1.0], abs=4 * math.sqrt(2 / 600))


def test_the_covariance_is_that_of_the_matrices():
    rng = random.Random(3)
    chain = Chain.unknown(1e-3, 2.0, 5.0)
    matrix = np.diag([1e-6, 4.0, 25.0])
    for _ in range(200):
        dt, jerk, noise = rng.uniform(0.001, 0.1), rng.uniform(1, 10), rng.uniform(1e-4, 1e-2)
        f = np.array([[1, dt, dt * dt / 2], [0, 1, dt], [0, 0, 1]])
        g = np.array([[dt**5 / 20, dt**4 / 8, dt**3 / 6], [0, dt**3 / 3, dt**2 / 2], [0, 0, dt]])
        matrix = f @ matrix @ f.T + jerk**2 * (g + np.triu(g, 1).T)
        gain = matrix[:, 0] / (matrix[0, 0] + noise**2)
        matrix = matrix - np.outer(gain, matrix[0])
        chain = chain.after(dt, jerk)
        assert chain.gains(noise) == pytest.approx(gain, rel=1e-9)
        chain = chain.measured(noise)
        entries = (chain.vv, chain.vr, chain.va, chain.rr, chain.ra, chain.aa)
        assert entries == pytest.approx(matrix[np.triu_indices(3)], rel=1e-6)
