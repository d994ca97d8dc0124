"""Flights of quadrotors with their rotors' speeds at every step, for other engines to repeat."""

from functools import cache

import numpy as np
from spatial_flights import CRAFT, GRAVITY, fly, start, team
from spatial_rows import vectors

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


def our_rows(n, slack, step):
    columns = our_flight(n, slack, step)[3]["columns"]
    places = [vectors(columns, f"vehicle{i + 1}") for i in range(n)]
    axes = list(upright(np.moveaxis(quaternions(columns, n), 1, 2)))
    every = round(RECORD / step)
    return np.hstack([vectors(columns, "payload"), *places, *axes])[::every][
        : round(DURATION / RECORD) + 1
    ]


def rotor_speeds(columns, n):
    """At every step, rad/s, shape (n, 4, steps + 1)."""
    return np.stack([[columns[f"vehicle{i + 1}_rotor{k}"] for k in (1, 2, 3, 4)] for i in range(n)])
