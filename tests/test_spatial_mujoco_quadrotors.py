"""Flights of quadrotors against MuJoCo: rigid bodies with four rotors that push where they stand.

MuJoCo's rotors get the thrusts that ours have on the way; what they do to bodies, and bodies and
cables to each other, is MuJoCo's. Its tendons are soft as in test_spatial_mujoco.py.
"""

from functools import cache

import numpy as np
import pytest
from spatial_flights import CRAFT, GRAVITY, fly, start, team
from spatial_mujoco import bodies, engine
from spatial_rows import vectors

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (multilift[test])")

DURATION = 1.0  # s
RECORD = 0.01  # s
DRAG = {"payload_drag": 0.1, "vehicle_drag": 0.2}
ROTOR_DRAG = 8e-5  # kg


def craft_of(crew):
    """The numbers that `fly` gives to vehicles, for the engine too."""
    lift = 2.0 * (crew.mass * GRAVITY + crew.cable_force[:, 2])
    return {
        **CRAFT,
        "inertia": np.outer(crew.mass, [0.0101, 0.0131, 0.0175]),
        "thrust_coefficient": lift / 4 / CRAFT["rotor_speed_max"] ** 2,
        "rotor_drag": ROTOR_DRAG,
    }


@cache
def our_flight(n, slack, step):
    """Team, start, craft, and the run with every step recorded."""
    rng = np.random.default_rng(n)
    crew = team(n, rng)
    crew.plant.update(DRAG)
    payload, vehicles = start(crew, rng)
    if slack:
        # Every other vehicle starts nearer to its attachment by 3 % of its cable.
        for i in range(0, n, 2):
            along = vehicles[i, :3] - payload[:3]
            vehicles[i, :3] -= 0.03 * crew.length[i] * along / np.linalg.norm(along)
    craft = craft_of(crew)
    run = fly(crew, "geometric", {}, (payload, vehicles), seconds=DURATION, step=step,
              control_steps=round(0.01 / step), craft=craft, record_steps=1)  # fmt: skip
    assert run["status"] == "finished"
    return crew, (payload, vehicles), craft, run


def quaternions(columns, n):
    return np.stack(
        [[columns[f"vehicle{i + 1}_q{k}"] for k in "wxyz"] for i in range(n)]
    )  # (n, 4, rows)


def upright(q):
    """The body's z axis in W of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)


def engine_flight(n, slack, step, softness):
    """Positions of payload and vehicles, and the vehicles' z axes, every RECORD."""
    crew, (payload, vehicles), craft, run = our_flight(n, slack, step)
    model, data = engine(mujoco, crew.numbers, step, softness, craft)
    columns = run["columns"]
    speeds = np.stack(
        [[columns[f"vehicle{i + 1}_rotor{k}"] for k in (1, 2, 3, 4)] for i in range(n)]
    )
    data.qpos[:7], data.qvel[:6] = payload[:7], payload[7:]
    attitude = quaternions(columns, n)[:, :, 0]
    data.qpos[7:] = np.hstack([vehicles[:, :3], attitude]).ravel()
    data.qvel[6:] = np.hstack([vehicles[:, 3:], np.zeros((n, 3))]).ravel()
    rows = []
    every = round(RECORD / step)
    for k in range(round(DURATION / step) + 1):
        places, velocity = bodies(data, n)
        axes = upright(data.qpos[7:].reshape(n, 7)[:, 3:])
        if k % every == 0:
            rows.append(np.concatenate([data.qpos[:3], places.ravel(), axes.ravel()]))
        if k == round(DURATION / step):
            break
        # Thrusts in the middle of the step; drag held over it, as it is at its start.
        turning = 0.5 * (speeds[:, :, k] + speeds[:, :, k + 1])
        data.ctrl[:] = (craft["thrust_coefficient"][:, None] * turning**2).ravel()
        across = velocity - np.sum(velocity * axes, axis=1)[:, None] * axes
        rotors = ROTOR_DRAG * speeds[:, :, k].sum(axis=1)[:, None] * across
        data.xfrc_applied[2:, :3] = -DRAG["vehicle_drag"] * velocity - rotors
        data.xfrc_applied[1, :3] = -DRAG["payload_drag"] * data.qvel[:3]
        mujoco.mj_step(model, data)
    return np.array(rows)


def our_rows(n, slack, step):
    columns = our_flight(n, slack, step)[3]["columns"]
    places = [vectors(columns, f"vehicle{i + 1}") for i in range(n)]
    axes = list(upright(np.moveaxis(quaternions(columns, n), 1, 2)))
    every = round(RECORD / step)
    return np.hstack([vectors(columns, "payload"), *places, *axes])[::every][
        : round(DURATION / RECORD) + 1
    ]


@pytest.mark.parametrize("n", [2, 3, 6])
def test_quadrotors_on_stiff_tendons_approach_taut_cables(n):
    step = 5e-4
    ours = our_rows(n, False, step)
    assert our_flight(n, False, step)[3]["metrics"]["min_tension"] > 0.0
    assert np.abs(ours[-1] - ours[0]).max() > 0.1  # it flies
    found = [engine_flight(n, False, step, softness) for softness in (0.04, 0.02, 0.01)]
    apart = [np.abs(rows - ours)[:, : 3 + 3 * n].max() for rows in found]
    # With the square of the time constant where that is faster than all that cables swing, which a
    # bar's turning about itself is not quite; down to the 1e-5 m of drag held over steps there.
    assert 2.5 < apart[0] / apart[1] < 5.0
    assert apart[2] < 1e-4


@pytest.mark.parametrize("n", [2, 3])
def test_attitudes_are_the_engine_s_but_for_thrusts_that_it_holds_over_a_step(n):
    apart = []
    for step in (1e-3, 5e-4):
        rows = engine_flight(n, False, step, 0.02) - our_rows(n, False, step)
        apart.append(np.abs(rows[:, 3 + 3 * n :]).max())
    # Cables are tied to the centres of mass, so that attitudes feel the rotors alone: a thrust that
    # is even over a step of h costs h^2.
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.02)
    assert apart[1] < 1e-5


@pytest.mark.parametrize("n", [2, 3, 6])
def test_quadrotors_that_pull_their_cables_taut_agree_with_soft_ones(n):
    step = 2.5e-4
    ours = our_rows(n, True, step)
    metrics = our_flight(n, True, step)[3]["metrics"]
    assert metrics["impacts"] >= 1
    assert metrics["slack_time"] > 0.01
    apart = [
        np.abs(engine_flight(n, True, step, softness) - ours)[:, : 3 + 3 * n].max()
        for softness in (0.02, 0.005)
    ]
    # As for ideal vehicles: speeds of some 0.3 m/s over two time constants.
    assert apart[1] < 0.5 * apart[0]
    assert apart[1] < 0.3 * 0.01
