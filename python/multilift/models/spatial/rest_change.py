"""How the formation at rest changes with the numbers that it follows from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift.models.spatial import formation
from multilift.models.spatial.formation import Rest

Array = NDArray[np.float64]
Hanging = tuple[Array, Array, Array, Array, Array, Array, Array | None]


def rest_change(given: Hanging, change: Hanging) -> Rest | None:
    """The derivative of `formation.rest` along a direction.

    Args:
        given: what `formation.rest` takes, of one world.
        change: the same, of the direction; what it says of an azimuth that is not given is ignored.

    Returns:
        Derivatives of offset and cable force in their places, the others empty. None where cables
        come to hold what none of them held, for then their tensions jump.
    """
    mass, g, (at,), (length,), (tilt,), azimuth, stiffness = given
    d_mass, d_g, (d_at,), (d_length,), (d_tilt,), (d_azimuth,), d_stiffness = change
    radius = np.where(formation.central(at), np.inf, np.hypot(at[:, 0], at[:, 1]))
    outwards = (at[:, 0] * d_at[:, 1] - at[:, 1] * d_at[:, 0]) / radius**2
    d_azimuth = np.where(np.isnan(azimuth[0]), outwards, d_azimuth)
    (angle,) = formation.azimuths(given[2], azimuth)
    zero, one = np.zeros_like(angle), np.ones_like(angle)
    out = np.stack([np.cos(angle), np.sin(angle), zero], axis=1)
    aside = np.stack([-np.sin(angle), np.cos(angle), zero], axis=1)
    up = np.stack([zero, zero, one], axis=1)
    s, c = np.sin(tilt)[:, None], np.cos(tilt)[:, None]
    direction = s * out + c * up
    d_direction = d_tilt[:, None] * (c * out - s * up) + d_azimuth[:, None] * s * aside

    grasp = np.concatenate([direction, np.cross(at, direction)], axis=1).T
    moments = np.cross(d_at, direction) + np.cross(at, d_direction)
    d_grasp = np.concatenate([d_direction, moments], axis=1).T
    inverse = np.linalg.pinv(grasp)
    unheld, loose = np.eye(6) - grasp @ inverse, np.eye(len(tilt)) - inverse @ grasp
    if np.abs(unheld @ d_grasp @ loose).max() > 1e-9 * np.abs(d_grasp).max(initial=0.0):
        return None
    # The derivative of a pseudoinverse of constant rank (Golub and Pereyra 1973).
    d_inverse = (
        -inverse @ d_grasp @ inverse
        + inverse @ inverse.T @ d_grasp.T @ unheld
        + loose @ d_grasp.T @ inverse.T @ inverse
    )
    weight, d_weight = mass * g, d_mass * g + mass * d_g
    tension = inverse[:, 2] * weight
    d_tension = d_inverse[:, 2] * weight + inverse[:, 2] * d_weight
    if stiffness is not None and d_stiffness is not None:
        length = length + tension / stiffness[0]
        d_length = d_length + (d_tension - tension / stiffness[0] * d_stiffness[0]) / stiffness[0]
    d_offset = d_at + d_length[:, None] * direction + length[:, None] * d_direction
    d_force = d_tension[:, None] * direction + tension[:, None] * d_direction
    return Rest(d_offset[None], d_force[None], np.zeros(1), np.zeros(1))
