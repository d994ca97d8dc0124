"""The swing that is left where the vehicles hold their places: what a shaper is made for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift import _core
from multilift.planning import Mode


def of_held_vehicles(plant: list[float], goal: NDArray[np.float64]) -> Mode:
    """Frequency and damping of the load's swing below held vehicles, from the linearised plant.

    Five coordinates less the vehicles' four leave one mode. Which forces hold the vehicles does not
    matter: they project it out of the plant's own linearisation.

    Args:
        plant: the plant's numbers in the core's order.
        goal: the vehicles' positions (y, z), shape (2, 2), m; the load hangs level there.
    """
    q = [*np.ravel(goal).tolist(), 0.0, 0.0, 0.0]
    x = np.array(_core.planar_free_coordinates(plant, q, [0.0] * 7))
    rates = np.array(_core.planar_jacobian(plant, x.tolist(), [0.0] * 4))[5:]
    vehicles = np.empty((4, 5))
    for k in range(5):
        # The vehicles' velocities are linear in the rates of the free coordinates.
        unit = np.eye(5)[k].tolist()
        _, q_dot = _core.planar_seven(plant, x[0:2].tolist(), x[2:5].tolist(), unit[0:2], unit[2:5])
        vehicles[:, k] = q_dot[:4]
    free = np.linalg.svd(vehicles)[2][-1]
    by_force = rates[:, 10:]
    held = np.eye(5) - by_force @ np.linalg.solve(vehicles @ by_force, vehicles)
    stiffness = -float(free @ held @ rates[:, :5] @ free)
    damping = -float(free @ held @ rates[:, 5:10] @ free)
    frequency = float(np.sqrt(stiffness))
    return Mode(frequency, damping / (2.0 * frequency))
