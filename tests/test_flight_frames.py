"""Frames on the wire: against rotation matrices, and the cases that people check by hand."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from multilift.flight.link import frames

WORLD = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])  # ENU to NED
BODY = np.diag([1.0, -1, -1])  # FLU to FRD

VECTORS = st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3)


@st.composite
def quaternions(draw):
    q = np.array(draw(st.lists(st.floats(-1, 1), min_size=4, max_size=4)))
    assume(np.linalg.norm(q) > 0.1)
    return q / np.linalg.norm(q)


def matrix(q):
    """Rotation matrix from Rodrigues' formula."""
    w, v = q[0], np.asarray(q[1:])
    cross = np.cross(np.eye(3), -v).T
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


@given(VECTORS)
def test_vectors_change_axes_and_come_back(v):
    assert np.array_equal(frames.world(v), WORLD @ v)
    assert np.array_equal(frames.body(v), BODY @ v)
    assert np.array_equal(frames.world(frames.world(v)), v)
    assert np.array_equal(frames.body(frames.body(v)), v)


@given(quaternions())
def test_attitudes_change_both_frames(q):
    # One rotation between four products of unit numbers: round-off alone.
    there = frames.attitude(q)
    assert np.allclose(matrix(there), WORLD @ matrix(q) @ BODY, atol=1e-14)
    assert np.allclose(matrix(frames.attitude(there)), matrix(q), atol=1e-14)
    assert there[0] >= 0.0


@given(quaternions())
def test_euler_angles_rebuild_the_attitude(q):
    assume(abs(matrix(q)[2, 0]) < 0.999)  # nose up or down: roll and yaw are one angle
    roll, pitch, yaw = frames.euler(q)

    def about(axis, angle):
        return matrix([math.cos(angle / 2), *(math.sin(angle / 2) * np.eye(3)[axis])])

    # The arcsine loses digits as 1 / cos(pitch), here at most 22.
    assert np.allclose(about(2, yaw) @ about(1, pitch) @ about(0, roll), matrix(q), atol=1e-13)


@pytest.mark.parametrize(
    ("enu_yaw", "ned_yaw"), [(0, 90), (90, 0), (180, -90), (-90, 180), (45, 45)]
)
def test_level_headings(enu_yaw, ned_yaw):
    half = math.radians(enu_yaw) / 2
    roll, pitch, yaw = frames.euler(frames.attitude([math.cos(half), 0, 0, math.sin(half)]))
    assert (roll, pitch) == pytest.approx((0, 0), abs=1e-12)
    assert math.remainder(yaw - math.radians(ned_yaw), math.tau) == pytest.approx(0, abs=1e-12)


def test_leaning_east_with_the_nose_north_is_a_positive_roll():
    # Nose north (ENU yaw 90 degrees), then the thrust axis turned towards east.
    north = np.array([math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    lean = np.array([math.cos(0.1), 0, math.sin(0.1), 0])  # about north, ENU y
    w, v = lean[0], lean[1:]
    q = np.array([w * north[0] - v @ north[1:], *(w * north[1:] + north[0] * v
                                                  + np.cross(v, north[1:]))])  # fmt: skip
    assert matrix(q)[0, 2] > 0.0
    roll, pitch, yaw = frames.euler(frames.attitude(q))
    assert (roll, pitch, yaw) == pytest.approx((0.2, 0.0, 0.0), abs=1e-12)
