"""Gains of the law ``lqr``: a linear-quadratic regulator about the formation at rest.

The plant is that of point vehicles on taut rigid cables. With the payload's displacement dx, its
small rotation phi and every cable's tilt eta_i along two axes N_i across it as coordinates q,

    p_i = x + R r_i + l_i d_i,   d_i = d_i0 + N_i eta_i - d_i0 |eta_i|^2 / 2 + ...

and with A_i = dp_i/dq = [I, -[r_i]x, l_i N_i] the equations of motion to first order are

    M q'' + D q' + K q = sum A_i' u_i,   M = sum m_i A_i'A_i + diag(m_L I, J, 0)

for forces u_i beyond the holding ones. K is the second derivative of the potential in which the
holding forces are constant: T_i l_i |eta_i|^2 / 2 of each cable, and of the payload's rotation
phi' sum T_i ((d_i . r_i) I - (d_i r_i' + r_i d_i') / 2) phi / 2. Derived here by hand; the tests
compare its closed loop with the decay of simulated runs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift.errors import MissingExtraError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Weights:
    """What the regulator weighs, per square of each; errors of 1 / sqrt(weight) count alike.

    Attributes:
        q_position: payload's position along x, y, z, 1/m^2.
        q_velocity: payload's velocity, s^2/m^2.
        q_attitude: payload's attitude about x, y, z, 1/rad^2.
        q_rate: its angular rate, s^2/rad^2.
        q_swing: every cable's angle from its direction at rest, 1/rad^2.
        q_swing_rate: the rate of that, s^2/rad^2.
        r_force: every vehicle's force per its mass, s^4/m^2.
    """

    q_position: float | tuple[float, float, float] = 2.0
    q_velocity: float | tuple[float, float, float] = 1.0
    q_attitude: float | tuple[float, float, float] = 4.0
    q_rate: float | tuple[float, float, float] = 0.5
    q_swing: float = 4.0
    q_swing_rate: float = 0.5
    r_force: float = 0.25


@dataclass(frozen=True)
class Linearisation:
    """First-order equations z' = a z + b u about rest, z = (q, q').

    Attributes:
        a: shape (2 m, 2 m).
        b: shape (2 m, 3 n), per N.
        turns: unit vectors of the rotations that are coordinates, rows, shape (k, 3).
        place: q from errors (payload x 3, attitude 3, vehicles 3 n), shape (m, 6 + 3 n).
        count: m, 3 + k + 2 n.
    """

    a: Array
    b: Array
    turns: Array
    place: Array
    count: int


def linearisation(
    vehicle_mass: Array,
    cable_length: Array,
    attachment: Array,
    payload_mass: float,
    payload_inertia: Array,
    cable_force: Array,
    *,
    vehicle_drag: Array | float = 0.0,
    payload_drag: Array | float = 0.0,
    payload_spin_damping: Array | float = 0.0,
    least_lever: float = 1e-6,
) -> Linearisation:
    """The ideal plant to first order about its formation at rest, in the payload's level frame.

    Rotations that no cable resists or drives are no coordinates: about the line through the centre
    of mass and all attachments, or any where they coincide with it. Those with a small lever, such
    as a bar's about itself or a box's under its one cable, swing faster than quadrotors can turn;
    `least_lever` leaves them out too, to themselves.

    Args:
        vehicle_mass: shape (n,), kg.
        cable_length: shape (n,), m.
        attachment: r_i, payload's frame, shape (n, 3), m.
        payload_mass: kg.
        payload_inertia: principal moments, shape (3,), kg m^2; all 0 for a point mass.
        cable_force: what each cable asks of its vehicle at rest, shape (n, 3), N.
        vehicle_drag: of each vehicle, linear, shape (n, 3) or fewer dimensions, N s/m.
        payload_drag: linear, shape (3,) or a number, N s/m.
        payload_spin_damping: shape (3,) or a number, N m s.
        least_lever: attachments' distance from an axis, in the root mean square, down to which
            rotations about it are coordinates, m.

    Raises:
        ValueError: if a cable is slack at rest.
    """
    n = len(vehicle_mass)
    tension = np.linalg.norm(cable_force, axis=1)
    if not (tension > 0).all():
        raise ValueError("every cable must pull at rest")
    direction = cable_force / tension[:, None]
    # Rotations that move an attachment: the span of all r_i x e, which is all but their line.
    _, sizes, axes = np.linalg.svd(np.vstack([_cross(r) for r in attachment]))
    turns = axes[sizes > least_lever * np.sqrt(n)] if np.any(payload_inertia) else np.zeros((0, 3))
    k, m = len(turns), 3 + len(turns) + 2 * n
    drag = np.broadcast_to(vehicle_drag, (n, 3))

    mass, damping, stiffness = np.zeros((m, m)), np.zeros((m, m)), np.zeros((m, m))
    mass[:3, :3] = payload_mass * np.eye(3)
    damping[:3, :3] = np.diag(np.broadcast_to(payload_drag, 3))
    turning = slice(3, 3 + k)
    mass[turning, turning] = turns @ np.diag(payload_inertia) @ turns.T
    damping[turning, turning] = turns @ np.diag(np.broadcast_to(payload_spin_damping, 3)) @ turns.T
    place, drive = np.zeros((m, 6 + 3 * n)), np.zeros((m, 3 * n))
    place[:3, :3] = np.eye(3)
    place[turning, 3:6] = turns
    for i in range(n):
        d, r, length = direction[i], attachment[i], cable_length[i]
        across = np.linalg.svd(d[None])[2][1:].T
        tilt = slice(3 + k + 2 * i, 5 + k + 2 * i)
        moved = np.zeros((3, m))
        moved[:, :3] = np.eye(3)
        moved[:, turning] = -_cross(r) @ turns.T
        moved[:, tilt] = length * across
        mass += vehicle_mass[i] * moved.T @ moved
        damping += moved.T @ np.diag(drag[i]) @ moved
        stiffness[tilt, tilt] = tension[i] * length * np.eye(2)
        pull = tension[i] * ((d @ r) * np.eye(3) - (np.outer(d, r) + np.outer(r, d)) / 2)
        stiffness[turning, turning] += turns @ pull @ turns.T
        drive[:, 3 * i : 3 * i + 3] = moved.T
        # A tilt is what moves the vehicle relative to its attachment.
        place[tilt, :3] = -across.T / length
        place[tilt, 3:6] = across.T @ _cross(r) / length
        place[tilt, 6 + 3 * i : 9 + 3 * i] = across.T / length
    a, b = np.zeros((2 * m, 2 * m)), np.zeros((2 * m, 3 * n))
    a[:m, m:] = np.eye(m)
    a[m:] = np.linalg.solve(mass, np.hstack([-stiffness, -damping]))
    b[m:] = np.linalg.solve(mass, drive)
    return Linearisation(a, b, turns, place, m)


def feedback_matrix(plant: Linearisation, weights: Weights, masses: Array) -> Array:
    """The regulator's gain F in u = -F z of a plant, shape (3 n, 2 m).

    Args:
        plant: of `linearisation`.
        weights: what to weigh.
        masses: of the vehicles, shape (n,), kg.

    Raises:
        MissingExtraError: without SciPy.
        ValueError: if nothing stabilises the plant.
    """
    try:
        from scipy.linalg import solve_continuous_are  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("scipy", "reference", "the gains of a regulator") from None
    n = len(masses)
    w = weights

    def of(position: object, attitude: object, swing: float) -> Array:
        turning = plant.turns @ np.diag(np.broadcast_to(np.asarray(attitude, float), 3))
        blocks = np.zeros((plant.count, plant.count))
        blocks[:3, :3] = np.diag(np.broadcast_to(np.asarray(position, float), 3))
        end = 3 + len(plant.turns)
        blocks[3:end, 3:end] = turning @ plant.turns.T
        blocks[end:, end:] = swing * np.eye(2 * n)
        return blocks

    m = plant.count
    q = np.zeros((2 * m, 2 * m))
    q[:m, :m] = of(w.q_position, w.q_attitude, w.q_swing)
    q[m:, m:] = of(w.q_velocity, w.q_rate, w.q_swing_rate)
    r = w.r_force / np.repeat(masses, 3) ** 2
    try:
        riccati = solve_continuous_are(plant.a, plant.b, q, np.diag(r))
    except np.linalg.LinAlgError:
        raise ValueError("no feedback of the vehicles' forces stabilises this formation") from None
    return np.asarray((plant.b.T @ riccati) / r[:, None])


def lqr_gains(
    vehicle_mass: Array,
    cable_length: Array,
    attachment: Array,
    payload_mass: float,
    payload_inertia: Array,
    cable_force: Array,
    weights: Weights = Weights(),
    *,
    vehicle_drag: Array | float = 0.0,
    payload_drag: Array | float = 0.0,
    payload_spin_damping: Array | float = 0.0,
    least_lever: float = 1e-6,
) -> dict[str, Array]:
    """The gains of the compiled law ``lqr``, by its fields' names, for vehicles that act at once.

    Neither the link's delay nor the vehicles' turning nor the hold between control instants is in
    the model: keep `Weights.r_force` so large that the fastest mode is well slower than these.

    Args:
        vehicle_mass: shape (n,), kg.
        cable_length: shape (n,), m.
        attachment: shape (n, 3), m.
        payload_mass: kg.
        payload_inertia: shape (3,), kg m^2.
        cable_force: at rest, in the payload's level frame, shape (n, 3), N.
        weights: what the regulator weighs.
        vehicle_drag: as `linearisation` takes it, N s/m.
        payload_drag: likewise, N s/m.
        payload_spin_damping: likewise, N m s.
        least_lever: likewise, m. 0.2 suits quadrotors.

    Returns:
        ``vehicle_position`` and ``vehicle_velocity``, shape (n, n, 3, 3), and ``payload_position``,
        ``payload_velocity``, ``payload_attitude`` and ``payload_rate``, shape (n, 3, 3): force on
        vehicle i along the level frame's axes per error, to be subtracted.

    Raises:
        MissingExtraError: without SciPy.
        ValueError: if a cable is slack at rest, or nothing stabilises the plant.
    """
    n = len(vehicle_mass)
    plant = linearisation(
        vehicle_mass,
        cable_length,
        attachment,
        payload_mass,
        payload_inertia,
        cable_force,
        vehicle_drag=vehicle_drag,
        payload_drag=payload_drag,
        payload_spin_damping=payload_spin_damping,
        least_lever=least_lever,
    )
    feedback = feedback_matrix(plant, weights, vehicle_mass)
    gains: dict[str, Array] = {}
    for names, part in (
        (("payload_position", "payload_attitude", "vehicle_position"), feedback[:, : plant.count]),
        (("payload_velocity", "payload_rate", "vehicle_velocity"), feedback[:, plant.count :]),
    ):
        flat = part @ plant.place
        gains[names[0]] = flat[:, :3].reshape(n, 3, 3)
        gains[names[1]] = flat[:, 3:6].reshape(n, 3, 3)
        gains[names[2]] = flat[:, 6:].reshape(n, 3, n, 3).transpose(0, 2, 1, 3)
    return gains


def _cross(r: Array) -> Array:
    """The matrix of r x."""
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
