"""Spatial scenarios for tests: a level plate on n cables, changed at will."""

import numpy as np
from multilift.scenario import Scenario

FEEDBACK = {
    "law": "energy_coupled",
    "rate": 100.0,
    "k_p": [4.5, 4.5, 6.2],
    "k_d": [6.2, 6.2, 8.0],
    "gamma": 0.5,
    "k_lambda": 0.15,
}


def tables(n=3):
    """The tables of a plate that n ideal vehicles carry a metre ahead."""
    angle = 2 * np.pi * np.arange(n) / n
    attachment = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), np.full(n, 0.05)], axis=1)
    return {
        "name": "plate",
        "plant": {
            "model": "spatial",
            "vehicles": n,
            "payload_mass": 1.2,
            "payload_inertia": [0.08, 0.08, 0.15],
            "attachment": attachment.tolist(),
            "cable_length": 1.2,
            "vehicle_mass": 1.486,
            "vehicle_drag": 0.1,
        },
        "formation": {"tilt": 0.2},
        "start": {"payload_position": [0.0, 0.0, 1.0]},
        "goal": {"payload_position": [1.0, 0.0, 1.5]},
        "controller": dict(FEEDBACK),
        "simulation": {"duration": 4.0},
    }


def plate(n=3, changes=None):
    """The same as a scenario, with some dotted keys changed."""
    raw = tables(n)
    for key, value in (changes or {}).items():
        table, _, name = key.partition(".")
        if name:
            raw.setdefault(table, {})[name] = value
        else:
            raw[table] = value
    return Scenario(raw)
