"""What tests of whole planar runs share: simple laws, scenarios without control, state arrays."""

from dataclasses import asdict

import numpy as np
from hypothesis import Phase, settings
from multilift.scenario import Scenario
from planar_random import laws

COORDINATES = ("y1", "z1", "y2", "z2", "theta1", "theta2", "theta3")
SHIPPED = ("sim1", "sim2", "exp1_1", "exp1_2", "exp2")
COMPILED = ("energy_coupled", "pd")

# Dotted keys that tell everything apart that sim1 and sim2 have alike, the goals mismatched.
UNLIKE = {
    "plant.vehicle_mass": [1.6, 2.4],
    "plant.cable_length": [1.5, 1.9],
    "plant.bar_inertia": 0.2,
    "plant.vehicle_drag": [[0.1, 0.3], [0.2, 0.4]],
    "plant.swing_damping": [0.02, 0.05, 0.08],
    "start.vehicle_position": [[0.0, 2.0], [2.0, 2.5]],
    "goal.vehicle_position": [[0.5, 2.6], [2.7, 2.9]],
    "goal.allow_mismatch": True,
}


# Properties of random runs. A failing case is reported as drawn: to shrink it would take minutes.
whole_runs = settings(laws, max_examples=40, phases=[Phase.explicit, Phase.generate])


def no_force(_):
    """The law that leaves each vehicle its gravity share and nothing else."""
    return (0.0, 0.0, 0.0, 0.0)


def constant(u):
    """The law that always answers u."""
    return lambda _: u


def cross(a, b):
    """Moment about x of b at a, over the last axis."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def coordinates(run):
    """The seven coordinates at each row, shape (n, 7)."""
    return np.stack([run[name] for name in COORDINATES], axis=1)


def rates(run):
    """Their rates at each row, shape (n, 7)."""
    return np.stack([run[f"{name}_dot"] for name in COORDINATES], axis=1)


def trajectory(run):
    """Coordinates and rates at each row, shape (n, 14)."""
    return np.hstack([coordinates(run), rates(run)])


def commands(run):
    """u1..u4 at each row, shape (n, 4)."""
    return np.stack([run[f"u{k}"] for k in range(1, 5)], axis=1)


def released(plant, q, q_dot, duration, step=0.001, **tables):
    """A scenario for a law of the test's own: a plant let go at seven coordinates and rates.

    A row is kept and the law stepped at each integration step. The goal and the gains play no
    part. `tables` adds to the scenario's tables.
    """
    (l1, l2), l0 = plant["cable_length"], plant["bar_length"]
    raw = {
        "plant": plant,
        "start": {
            "vehicle_position": np.reshape(q[:4], (2, 2)).tolist(),
            "angle": list(q[4:]),
            "vehicle_velocity": np.reshape(q_dot[:4], (2, 2)).tolist(),
            "angle_rate": list(q_dot[4:]),
        },
        "goal": {"vehicle_position": [[0.0, l1], [l0, l2]]},
        "controller": {"law": "pd", "rate": 1 / step, "k_p": 1.0, "k_d": 1.0, "gamma": 1.0},
        "simulation": {"duration": duration, "step": step, "record_period": step},
    }
    for name, table in tables.items():
        raw[name] = raw.get(name, {}) | table if isinstance(table, dict) else table
    return Scenario(raw)


def released_from(plant, state, duration, step=0.001, **tables):
    """The same from a random plant and state of planar_random.py."""
    table = asdict(plant) | {"vehicle_drag": np.reshape(plant.vehicle_drag, (2, 2)).tolist()}
    table = {key: list(x) if isinstance(x, tuple) else x for key, x in table.items()}
    return released(table, *state.seven(plant), duration, step, **tables)


def at_every_step(scenario):
    """The scenario with a row for each integration step."""
    return scenario.with_values({"simulation.record_period": scenario["simulation.step"]})
