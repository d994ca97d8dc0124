"""Random planar plants, states and loads, drawn from a box in which the equations are well posed.

A bar without inertia has no equation for its turning where both cables' lines pass through its
centre of mass, tan(theta1 - theta3) = tan(theta2 + theta3) = l0/(2 l3). The box keeps away from
there: l3 is at most a tenth of l0, and |theta1 - theta3| and |theta2 + theta3| stay below 1.2.
"""

from dataclasses import dataclass

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from multilift import _core

laws = settings(max_examples=200, deadline=None, database=None)


@dataclass(frozen=True)
class Plant:
    """The parameters of the plant under the names of the core's own table."""

    vehicle_mass: tuple
    cable_length: tuple
    bar_mass: float
    bar_length: float
    bar_half_thickness: float
    bar_inertia: float
    gravity: float
    vehicle_drag: tuple
    swing_damping: tuple

    @property
    def values(self):
        """Flat, in the order in which the core's table names them."""
        return np.hstack([getattr(self, name) for name, *_ in _core.planar_plant_fields()])

    @property
    def kappa(self):
        return 4 / self.bar_mass + sum(1 / m for m in self.vehicle_mass)


@dataclass(frozen=True)
class State:
    """The five free coordinates and their rates."""

    bar: tuple
    theta: tuple
    bar_velocity: tuple
    theta_dot: tuple

    def seven(self, plant):
        """Coordinates and rates q, q_dot, which satisfy the closure."""
        q, q_dot = _core.planar_seven(
            plant.values, self.bar, self.theta, self.bar_velocity, self.theta_dot
        )
        return np.array(q), np.array(q_dot)

    def moved(self, rate, h):
        """The state on the straight line through this one, h along (bar and angle) rates."""
        numbers = self.flat + h * np.asarray(rate)
        return State.from_flat(numbers)

    @property
    def flat(self):
        return np.hstack([self.bar, self.theta, self.bar_velocity, self.theta_dot])

    @staticmethod
    def from_flat(x):
        return State(*(tuple(part) for part in np.split(np.asarray(x), [2, 5, 7])))


def gravity_shares(plant):
    """What the paper's u leaves out of the thrusts: each vehicle's weight and half the bar's."""
    m1, m2 = np.array(plant.vehicle_mass) + plant.bar_mass / 2
    return plant.gravity * np.array([0, m1, 0, m2])


def _several(count, low, high):
    return st.tuples(*[st.floats(low, high)] * count)


@st.composite
def plants(draw, **fixed):
    """A plant; keyword arguments fix fields."""
    bar_length = draw(st.floats(0.5, 3.0))
    fields = {
        "vehicle_mass": draw(_several(2, 0.5, 5.0)),
        "cable_length": draw(_several(2, 0.5, 3.0)),
        "bar_mass": draw(st.floats(0.2, 5.0)),
        "bar_length": bar_length,
        "bar_half_thickness": bar_length * draw(st.floats(0.0, 0.1)),
        "bar_inertia": draw(st.just(0.0) | st.floats(0.001, 1.0)),
        "gravity": draw(st.sampled_from([0.0, 9.8]) | st.floats(0.0, 20.0)),
        "vehicle_drag": draw(_several(4, 0.0, 2.0)),
        "swing_damping": draw(_several(3, 0.0, 0.5)),
    }
    return Plant(**fields | fixed)


states = st.builds(
    State,
    bar=_several(2, -5.0, 5.0),
    theta=_several(3, -0.6, 0.6),
    bar_velocity=_several(2, -3.0, 3.0),
    theta_dot=_several(3, -3.0, 3.0),
)

# u1..u4, the vehicles' pushes (4), the bar's push (2), N, and its torque, N m
loads = _several(11, -10.0, 10.0).map(np.array)
