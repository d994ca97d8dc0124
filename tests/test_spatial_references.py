"""The payload's way to its goal: ends, smoothness, limits, shape."""

import numpy as np
import pytest
from multilift.models.spatial import references
from spatial_scenarios import plate

pytest.importorskip("scipy")


def path(changes):
    """A scenario's path as a function of time and derivative order, and its end."""
    scenario = plate(changes=changes)
    pieces, end = references.pieces(scenario.values, "here")
    starts = np.array([start for start, _ in pieces])

    def at(time, order=0):
        k = np.searchsorted(starts, time, side="right") - 1
        rows = np.array(pieces[max(k, 0)][1])
        local = min(time, end) - starts[max(k, 0)]
        return np.array(
            [np.polynomial.Polynomial(row).deriv(order)(local) if order else
             np.polynomial.Polynomial(row)(local) for row in rows]
        )  # fmt: skip

    return at, starts, end


MIN_SNAP = {"reference.kind": "min_snap", "reference.duration": 5.0, "reference.start": 1.0}
JERK = {
    "reference.kind": "jerk_limited",
    "reference.speed_max": 0.5,
    "reference.acceleration_max": 0.4,
    "reference.jerk_max": 1.5,
}
WAYPOINTS = {
    "reference.kind": "waypoints",
    "reference.times": [2.0, 4.0, 7.0],
    "reference.points": [0.5, 1.0, 1.2, 0.5, 1.5, 0.5, 1.4, 0.2, 1.0, 0.0, 1.5, 0.0],
}
EIGHT = {
    "reference.kind": "figure_eight",
    "reference.duration": 12.0,
    "goal.payload_position": [0.0, 0.0, 1.0],
}
CIRCLE = {**EIGHT, "reference.kind": "circle", "reference.radius": 2.0, "reference.start": 0.5}


@pytest.mark.parametrize("changes", [MIN_SNAP, JERK, WAYPOINTS, EIGHT, CIRCLE])
def test_a_path_leads_from_start_to_goal_and_rests_at_both(changes):
    at, _, end = path(changes)
    scenario = plate(changes=changes)
    offset = np.array(scenario["start.payload_position"]) - scenario["goal.payload_position"]
    # Splines of degree 7 are solved for to about 1e-9 m.
    assert at(0.0)[:3] == pytest.approx(offset, abs=1e-8)
    assert np.abs(at(end)).max() < 1e-8
    for time in (0.0, end - 1e-9):
        assert np.abs(at(time, 1)).max() < 1e-6
        assert np.abs(at(time, 2)).max() < 1e-4


@pytest.mark.parametrize(
    ("changes", "orders"),
    [(MIN_SNAP, 4), (JERK, 3), (WAYPOINTS, 4), (EIGHT, 4), (CIRCLE, 4)],
)
def test_pieces_join_without_jumps(changes, orders):
    at, starts, _ = path(changes)
    for start in starts[1:]:
        for order in range(orders):
            before, after = at(start - 1e-9, order), at(start + 1e-9, order)
            scale = max(np.abs(at(start, order)).max(), 1.0)
            assert before == pytest.approx(after, abs=1e-6 * scale)


def test_a_jerk_limited_move_keeps_its_limits_and_reaches_one():
    at, _, end = path(JERK)
    times = np.linspace(0.0, end, 4001)
    for order, limit in ((1, 0.5), (2, 0.4), (3, 1.5)):
        sizes = np.array([np.linalg.norm(at(t, order)[:3]) for t in times])
        assert sizes.max() <= limit * (1 + 1e-9)
        assert sizes.max() >= limit * (1 - 1e-3)  # the grid misses the very peak


def test_waypoints_are_passed_in_time():
    at, _, _ = path(WAYPOINTS)
    goal = np.array([1.0, 0.0, 1.5, 0.0])
    points = np.array(WAYPOINTS["reference.points"]).reshape(-1, 4)
    for time, point in zip(WAYPOINTS["reference.times"], points, strict=True):
        assert at(time) == pytest.approx(point - goal, abs=1e-8)


def test_a_circle_is_round():
    at, _, end = path(CIRCLE)
    # Between samples 0.05 s apart the spline leaves the circle by less than a micrometre.
    radius = [np.linalg.norm(at(t)[:2] - [-2.0, 0.0]) for t in np.linspace(0.0, end, 997)]
    assert radius == pytest.approx(np.full(997, 2.0), abs=1e-6)
