"""A scenario's feedback loop to first order about rest at the goal, whatever the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StateSpace:
    """A linear system z' = a z + b u, y = c z + d u.

    Attributes:
        a: shape (k, k), 1/s.
        b: shape (k, inputs).
        c: shape (outputs, k).
        d: shape (outputs, inputs).
    """

    a: Array
    b: Array
    c: Array
    d: Array

    @staticmethod
    def through(count: int) -> StateSpace:
        """What passes `count` signals on as they are."""
        return StateSpace(
            np.zeros((0, 0)), np.zeros((0, count)), np.zeros((count, 0)), np.eye(count)
        )

    def response(self, omega: Array) -> NDArray[np.complex128]:
        """C (i omega - a)^-1 b + d at each frequency, shape (frequencies, outputs, inputs)."""
        count = len(self.a)
        if count == 0:
            return np.broadcast_to(self.d.astype(complex), (len(omega), *self.d.shape))
        resolvent = 1j * omega[:, None, None] * np.eye(count) - self.a
        inputs = np.broadcast_to(self.b.astype(complex), (len(omega), *self.b.shape))
        return np.asarray(self.c @ np.linalg.solve(resolvent, inputs) + self.d)


@dataclass(frozen=True)
class Loop:
    """Plant, vehicles' answer and law about rest at the goal, to first order.

    The plant is x' = a x + b f for forces f of the vehicles beyond those at rest; the law commands
    feedback @ x, its estimates and integrals resting; `vehicles` is what becomes of a command;
    delays of sensing, link and hold come together in `delay`.

    Attributes:
        coordinates: name of each state, positions and angles first, then their rates.
        channels: name of each force.
        a: shape (states, states).
        b: shape (states, channels), per N.
        feedback: shape (channels, states), N per unit of each state.
        vehicles: from commanded to acting force.
        delay: from measured state to acting command, half of the control period's hold included, s.
        hold: half of the control period, s.
    """

    coordinates: tuple[str, ...]
    channels: tuple[str, ...]
    a: Array
    b: Array
    feedback: Array
    vehicles: StateSpace
    delay: float
    hold: float

    def ideal_matrix(self) -> Array:
        """The closed loop's state matrix where commands act at once and continuously."""
        return np.asarray(self.a + self.b @ self.feedback)

    def response(self, omega: Array) -> NDArray[np.complex128]:
        """The loop's transfer from command to command, negative feedback, at each frequency, rad/s.

        Shape (frequencies, channels, channels); with delay.
        """
        plant = StateSpace(
            self.a, self.b, -self.feedback, np.zeros((len(self.channels),) * 2)
        ).response(omega)
        late = np.exp(-1j * omega * self.delay)[:, None, None]
        return np.asarray(plant @ self.vehicles.response(omega) * late)

    def matrix(self, order: int = 6) -> Array:
        """The closed loop's state matrix with the vehicles' answer and the delay.

        Args:
            order: of the Padé approximation of the delay.
        """
        late = pade(self.delay, order, len(self.channels))
        act = self.vehicles
        n, k = len(self.a), len(act.a)
        fed, force = self.feedback, self.b @ act.d
        return np.block(
            [
                [self.a + force @ late.d @ fed, self.b @ act.c, force @ late.c],
                [act.b @ late.d @ fed, act.a, act.b @ late.c],
                [late.b @ fed, np.zeros((len(late.a), k)), late.a],
            ]
        ) if n else np.zeros((0, 0))  # fmt: skip


def pade(delay: float, order: int, channels: int) -> StateSpace:
    """A delay of several signals, by the diagonal Padé approximation.

    Args:
        delay: s; with 0 there is none.
        order: of numerator and denominator.
        channels: how many signals.
    """
    if delay <= 0.0 or order == 0:
        return StateSpace.through(channels)
    # sum c_k (+-s T)^k with c_k / c_(k-1) = (n - k + 1) / (k (2 n - k + 1)), in s T.
    c = [1.0]
    for k in range(1, order + 1):
        c.append(c[-1] * (order - k + 1) / (k * (2 * order - k + 1)))
    below = np.array(c) / c[-1]
    above = below * (-1.0) ** np.arange(order + 1)
    straight = (-1.0) ** order
    a = np.diag(np.ones(order - 1), 1)
    a[-1] = -below[:-1]
    b = np.zeros((order, 1))
    b[-1] = 1.0
    row = (above - straight * below)[:-1][None]
    each: Array = np.eye(channels)
    return StateSpace(
        np.asarray(np.kron(each, a / delay), np.float64),
        np.asarray(np.kron(each, b / delay), np.float64),
        np.asarray(np.kron(each, row), np.float64),
        straight * each,
    )
