"""How a cable is drawn: straight while it pulls, else the catenary of its length."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def sagging(foot: Array, top: Array, length: float, pieces: int = 16) -> Array:
    """Points along a cable at rest between two places, from foot to top, shape (pieces + 1, 3).

    The catenary whose arc is `length` long; straight where the ends are at least so far apart.

    Args:
        foot: its lower end, shape (3,), m.
        top: its upper end, shape (3,), m.
        length: m.
        pieces: of the line.
    """
    apart = top - foot
    part = np.linspace(0.0, 1.0, pieces + 1)[:, None]
    if length <= float(np.linalg.norm(apart)) * (1.0 + 1e-6):
        return np.asarray(foot + part * apart)
    # Ends above each other leave no plane to hang in; a hair's breadth apart they hang in one.
    across = max(math.hypot(apart[0], apart[1]), 1e-3 * length)
    heading = apart[:2] if math.hypot(apart[0], apart[1]) > 1e-9 else np.array([1.0, 0.0])
    heading = heading / math.hypot(heading[0], heading[1])
    a = across / (2.0 * _ratio(math.sqrt(max(length**2 - apart[2] ** 2, across**2)) / across))
    lowest = 0.5 * across - a * math.asinh(apart[2] / (2.0 * a * math.sinh(across / (2.0 * a))))
    # Evenly in arc length, which keeps the bend round: arc from the lowest point is a sinh(x/a).
    first, last = math.sinh(-lowest / a), math.sinh((across - lowest) / a)
    x = lowest + a * np.arcsinh(first + part[:, 0] * (last - first))
    z = a * (np.cosh((x - lowest) / a) - math.cosh(lowest / a))
    flat = (x / across * math.hypot(apart[0], apart[1]))[:, None] * heading
    return np.column_stack([foot[:2] + flat, foot[2] + z])


def hanging(top: Array, length: float, floor: float | None) -> Array:
    """A cable that is cut at the payload, from its lower end to the vehicle, shape (k, 3).

    What would be below the floor lies on it.
    """
    end = top - np.array([0.0, 0.0, length])
    if floor is None or end[2] >= floor:
        return np.array([end, top])
    corner = np.array([top[0], top[1], min(floor, top[2])])
    lying = corner + np.array([length - (top[2] - corner[2]), 0.0, 0.0])
    return np.array([lying, corner, top])


def _ratio(wanted: float) -> float:
    """The u > 0 with sinh(u) / u = wanted > 1."""
    u = (
        math.sqrt(6.0 * (wanted - 1.0))
        if wanted < 3.0
        else math.log(2.0 * wanted) + math.log(math.log(2.0 * wanted))
    )
    u = max(u, 1e-6)
    for _ in range(20):
        value, slope = math.sinh(u) - wanted * u, math.cosh(u) - wanted
        step = value / slope
        u = max(u - step, 0.5 * u)
        if abs(step) < 1e-13 * u:
            break
    return u
