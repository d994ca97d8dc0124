"""How vehicles stand about a payload that hangs level at rest, and what its cables then pull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: What cables at rest may leave unbalanced, in payload weights (and times a metre): coordinates
#: rounded as people write them leave less, and the payload then hangs off level by about as many
#: radians.
BALANCE_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Rest:
    """Formations of many worlds at rest, in the payload's level frame.

    Attributes:
        offset: of each vehicle from the payload's centre of mass, shape (worlds, n, 3), m.
        cable_force: what each cable asks of its vehicle to hold, shape (worlds, n, 3), N.
        unbalanced: wrench that no tensions balance, per payload weight and metre, shape (worlds,).
        least_tension: of all cables, shape (worlds,), N.
    """

    offset: Array
    cable_force: Array
    unbalanced: Array
    least_tension: Array


def rest(
    payload_mass: Array,
    gravity: Array,
    attachment: Array,
    cable_length: Array,
    tilt: Array,
    azimuth: Array,
    stiffness: Array | None,
) -> Rest:
    """The rest that cables of given directions hold, with the least tensions in sum of squares.

    Args:
        payload_mass: shape (worlds,), kg.
        gravity: shape (worlds,), m/s^2.
        attachment: r_i, payload's frame, shape (worlds, n, 3), m.
        cable_length: rest lengths, shape (worlds, n), m.
        tilt: of the cables from the vertical, shape (worlds, n), rad.
        azimuth: to where they lean, NaN for outwards, shape (worlds, n), rad.
        stiffness: of elastic cables, shape (worlds, n), N/m; None for rigid ones.
    """
    azimuth = azimuths(attachment, azimuth)
    direction = np.stack(
        [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=-1
    )
    # What unit tensions do to the payload: forces and moments, shape (worlds, 6, n).
    wrench = np.concatenate([direction, np.cross(attachment, direction)], axis=-1)
    grasp = np.swapaxes(wrench, 1, 2)
    weight = payload_mass * gravity
    wanted = np.zeros((len(weight), 6))
    wanted[:, 2] = weight
    tension = np.einsum("wij,wj->wi", np.linalg.pinv(grasp), wanted)
    left = np.einsum("wij,wj->wi", grasp, tension) - wanted
    length = cable_length if stiffness is None else cable_length + tension / stiffness
    return Rest(
        attachment + length[..., None] * direction,
        tension[..., None] * direction,
        np.abs(left).max(axis=1) / np.where(weight > 0, weight, 1.0),
        tension.min(axis=1),
    )


def azimuths(attachment: Array, azimuth: Array) -> Array:
    """To where each cable leans: as given, outwards where NaN is; shape (worlds, n), rad."""
    n = azimuth.shape[1]
    outwards = np.arctan2(attachment[..., 1], attachment[..., 0])
    outwards = np.where(central(attachment), 2.0 * np.pi * np.arange(n) / n, outwards)
    return np.where(np.isnan(azimuth), outwards, azimuth)


def central(attachment: Array) -> NDArray[np.bool_]:
    """Which cables are tied above or below the payload's centre, shape (worlds, n)."""
    return np.asarray(np.hypot(attachment[..., 0], attachment[..., 1]) < 1e-9)
