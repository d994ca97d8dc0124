"""What a law of one's own is told of the planar plant, and how the core calls it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift.controllers import PythonLaw
from multilift.models.planar.scenario import PlanarScenario


@dataclass(frozen=True)
class Measurement:
    """What a law is told at a control instant: world y-z plane, z up, SI, radians.

    Attributes:
        t: time, s.
        xi: positions (y, z) of vehicles 1 and 2, shape (2, 2), m.
        xi_dot: their velocities, shape (2, 2), m/s.
        theta: angles theta1, theta2, theta3, shape (3,), rad.
        theta_dot: their rates, shape (3,), rad/s.
        goal: where the vehicles shall come to rest, shape (2, 2), m.
        saturated: whether each vehicle's last command hit a limit of thrust or tilt.
    """

    t: float
    xi: NDArray[np.float64]
    xi_dot: NDArray[np.float64]
    theta: NDArray[np.float64]
    theta_dot: NDArray[np.float64]
    goal: NDArray[np.float64]
    saturated: tuple[bool, bool]


Law = Callable[[Measurement], Sequence[float]]


def callback(law: PythonLaw, scenario: PlanarScenario) -> Callable[..., list[float]]:
    """A fresh law behind the signature that the core calls.

    Raises:
        ControllerError: if the law cannot be constructed; and, from the callback, if it raises or
            answers anything but four finite numbers, with the time.
    """
    answer = law.begin(scenario, 4, "four finite forces u1, u2, u3, u4 in N")
    goal = scenario.goal_vector().reshape(2, 2)
    goal.setflags(write=False)  # one array for all steps: a law may not move it

    def step(
        t: float, q: Sequence[float], q_dot: Sequence[float], saturated: Sequence[bool]
    ) -> list[float]:
        positions, rates = np.array(q), np.array(q_dot)
        measured = Measurement(
            t,
            positions[:4].reshape(2, 2),
            rates[:4].reshape(2, 2),
            positions[4:],
            rates[4:],
            goal,
            (bool(saturated[0]), bool(saturated[1])),
        )
        return answer(t, measured)

    return step
