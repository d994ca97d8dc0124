"""Spatial flights against a general multibody engine, MuJoCo: free bodies and tendons.

MuJoCo's limited tendons are soft: a cable is longer than its rest length by what goes with the
square of the limit's time constant, so that halving it twice shows what is left with none.
"""

import numpy as np
import pytest
from multilift import bench
from spatial_mujoco import bodies
from spatial_rows import GRAVITY, World, vectors

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (multilift[test])")

DURATION = 1.0  # s
RECORD = 0.01  # s


def world_of(n, *, slack=False):
    """A tilted, turning platform on n cables under vehicles of unlike masses."""
    rng = np.random.default_rng(n)
    angle = 2 * np.pi * np.arange(n) / n + 0.3
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    attachment = 0.5 * ring + [0, 0, 0.1]
    length = rng.uniform(0.9, 1.4, n)
    half = 0.05
    attitude = np.array([np.sqrt(1 - half**2), half, 0, 0])
    turn = np.array(
        [[1, 0, 0], [0, 1 - 2 * half**2, -2 * half * attitude[0]],
         [0, 2 * half * attitude[0], 1 - 2 * half**2]]
    )  # fmt: skip
    direction = 0.2 * ring + [0, 0, 1]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    tie = attachment @ turn.T
    velocity, rate = np.array([0.3, -0.2, 0.0]), np.array([0.2, -0.1, 0.8])
    part = np.where(np.arange(n) % 2 == 0, 0.97, 1.0) if slack else np.ones(n)
    plant = {
        "payload_mass": 1.5,
        "payload_inertia": [0.12, 0.15, 0.2],
        "payload_drag": 0.1,
        "vehicle_mass": rng.uniform(0.8, 1.6, n),
        "vehicle_drag": 0.2,
        "cable_length": length,
        "attachment": attachment,
    }
    return World(
        plant,
        vehicles=tie + (part * length)[:, None] * direction,
        attitude=tuple(attitude),
        velocity=tuple(velocity),
        rate=tuple(rate),
        # As their attachments, so that cables start unstretching.
        vehicle_velocity=velocity + np.cross(rate, attachment) @ turn.T,
    )


def force_of(world):
    """Springs and dampers that hold the vehicles where they started, and their weight and share."""
    mass = np.asarray(world.plant["vehicle_mass"])
    lift = (mass + world.plant["payload_mass"] / len(mass)) * GRAVITY
    start = world.vehicles.copy()

    def force(_, vehicle, velocity, __):
        return 3.0 * (start - vehicle) - 1.0 * velocity + np.outer(lift, [0, 0, 1])

    return force


def engine_flight(world, step, softness, force):
    """Positions of payload and vehicles, and the payload's x axis, every RECORD."""
    plant, n = world.plant, len(world.vehicles)
    model = mujoco.MjModel.from_xml_string(
        bench.mujoco_free_bodies(
            plant | {"gravity": GRAVITY}, step, softness, 'tolerance="1e-15" iterations="200"'
        )
    )
    data = mujoco.MjData(model)
    # A free joint's velocity is linear in W and angular in the body, as ours.
    data.qpos[:7] = [*world.payload, *world.attitude]
    data.qvel[:6] = [*world.velocity, *world.rate]
    for i in range(n):
        data.qpos[7 + 7 * i : 10 + 7 * i] = world.vehicles[i]
        data.qvel[6 + 6 * i : 9 + 6 * i] = world.vehicle_velocity[i]
    rows = []
    every = round(RECORD / step)
    for k in range(round(DURATION / step) + 1):
        position, velocity = bodies(data, n)
        if k % every == 0:
            mujoco.mj_forward(model, data)
            rows.append([*data.qpos[:3], *data.xmat[1].reshape(3, 3)[:, 0], *position.ravel()])
        # Held over a step, drag included, as the law below does.
        drag = plant["vehicle_drag"]
        data.xfrc_applied[2:, :3] = force(0, position, velocity, None) - drag * velocity
        data.xfrc_applied[1, :3] = -plant["payload_drag"] * data.qvel[:3]
        mujoco.mj_step(model, data)
    return np.array(rows)


def our_flight(world, step, force):
    out = world.fly(DURATION, step, force, record_steps=round(RECORD / step))
    assert out["status"] == "finished"
    columns = out["columns"]
    w, x, y, z = (columns[f"payload_q{k}"] for k in "wxyz")
    ahead = np.stack([1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1)
    bodies = [vectors(columns, f"vehicle{i + 1}") for i in range(len(world.vehicles))]
    rows = np.hstack([vectors(columns, "payload"), ahead, *bodies])
    return rows[: round(DURATION / RECORD) + 1], out


@pytest.mark.parametrize("n", [2, 3, 6])
def test_free_bodies_on_stiff_tendons_approach_taut_cables(n):
    world = world_of(n)
    force = force_of(world)
    step = 5e-4
    ours, out = our_flight(world, step, force)
    assert out["metrics"]["min_tension"] > 0.0
    assert np.abs(ours[-1] - ours[0]).max() > 0.1  # it flies
    apart = [
        np.abs(engine_flight(world, step, softness, force) - ours).max()
        for softness in (0.04, 0.02, 0.01)
    ]
    # With the square of the time constant, down to the 1e-5 m of drag held over steps there.
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.2)
    assert apart[2] < 2e-5


@pytest.mark.parametrize("n", [2, 3, 6])
def test_cables_that_are_pulled_taut_agree_with_soft_ones(n):
    world = world_of(n, slack=True)
    force = force_of(world)
    step = 2.5e-4
    ours, out = our_flight(world, step, force)
    assert out["metrics"]["impacts"] >= 1
    assert out["metrics"]["slack_time"] > 0.01
    apart = [
        np.abs(engine_flight(world, step, softness, force) - ours).max()
        for softness in (0.02, 0.005)
    ]
    # Critically damped tendons lose what plastic impacts lose, but over a time of their own, during
    # which bodies move on at speeds of some 0.3 m/s: two time constants of it.
    assert apart[1] < 0.5 * apart[0]
    assert apart[1] < 0.3 * 0.01
