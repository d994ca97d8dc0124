"""What forces the vehicles shall exert in each state of a flight.

With the load in the air it is the scenario's law that flies, compiled as in simulations, after a
reference that fits the state; before and after that each vehicle follows a smooth path by itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.flight.estimate.state import Estimate, Quality
from multilift.flight.supervisor import Order, State
from multilift.models.spatial import FlyingLaw
from multilift.models.spatial.scenario import SpatialScenario

Array = NDArray[np.float64]

#: How high vehicles rise before they go anywhere else, m, and how fast they move alone, m/s.
_CLEAR = 0.5
_SPEED = 0.35

#: Least time of a path, s, and what is waited at its end.
_LEAST_TIME = 2.0
_SETTLE = 1.0

#: How far below their places at taut cables the vehicles form up, m.
_SLACK = 0.06

#: How long lifting and setting down take, s, and how far below the floor the load is set, m.
_LIFT_TIME = 5.0
_BELOW = 0.06

#: Coming down: how far outwards, m, before, s, going down, m/s.
_APART = 0.55
_APART_TIME = 3.0
_DOWN = 0.3

#: Of a vehicle alone: 1/s^2 and 1/s, horizontal and vertical; and its greatest lean.
_STIFFNESS = np.array([3.0, 3.0, 4.0])
_DAMPING = np.array([3.2, 3.2, 3.6])
_MOST_LEAN = 0.35

#: The load is in the air when it is so far above where it stood, and down again below that, m.
_LIFTED = 0.04
_DOWN_AGAIN = 0.01

#: A cable that seems so much longer than it is shows that a body is not where it is seen.
_STRETCH = 1.08

#: States that cannot go on without seeing the load.
_NEED_LOAD = (State.PREFLIGHT, State.ARMED, State.FORM_UP, State.LIFT, State.FLY, State.PAUSE)


@dataclass(frozen=True)
class Wanted:
    """What the vehicles shall do now.

    Attributes:
        force: of each vehicle's rotors, world, shape (n, 3), N.
        yaw: of all, rad.
        swing: largest angle of a cable where they are taut, rad; 0 before.
        done: whether the state's plan has been flown.
        vehicle: where they shall be, shape (n, 3), m.
        payload: where the load shall be, shape (3,), m; None while it stands.
    """

    force: Array
    yaw: float
    swing: float
    done: bool
    vehicle: Array
    payload: Array | None


def smooth(part: float) -> tuple[float, float]:
    """A path from 0 to 1 that starts and ends at rest, and its derivative, of a part of its time.

    The polynomial of least jerk.
    """
    s = min(max(part, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2


def lead_time(flown: SpatialScenario, load: Array, vehicles: Array) -> float:
    """How long it takes from the order to take off until the scenario's own flight begins, s.

    Args:
        flown: the scenario.
        load: where its payload stands, shape (3,), m.
        vehicles: where they stand, shape (n, 3), m.
    """
    up = np.array([0.0, 0.0, _CLEAR])
    formed = load + flown.rest.offset[0] - np.array([0.0, 0.0, _SLACK])
    take_off, form_up = _time(np.array([up])), _time(formed - vehicles - up)
    return take_off + form_up + _LIFT_TIME + 3 * _SETTLE


def _time(way: Array) -> float:
    """How long vehicles take that go so far by themselves, s."""
    # The fastest point of the smooth path goes 15/8 of its mean.
    return max(_LEAST_TIME, float(np.linalg.norm(way, axis=1).max()) * 1.875 / _SPEED)


class Plan:
    """The plan of one flight.

    Attributes:
        law: the scenario's.
        carries: whether the load is in the air, as last seen.
    """

    def __init__(self, flown: SpatialScenario, rate: float) -> None:
        """Plans the flight of a scenario whose payload starts above the floor.

        Args:
            flown: the scenario.
            rate: at which `step` is called, Hz.
        """
        self._flown = self._changed(flown, {"controller.rate": rate})
        flown = self._flown
        self.law = FlyingLaw(flown)
        self._mass = np.broadcast_to(np.array(flown.values["plant"]["vehicle_mass"]), flown.count)
        self._weight = self._mass * float(flown.values["plant"]["gravity"])
        self._offset = flown.rest.offset[0]
        lengths = np.array(flown.values["plant"]["cable_length"], dtype=float)
        self._lengths = np.broadcast_to(lengths, flown.count).tolist()
        self._share = flown.rest.cable_force[0]
        self.carries = False
        self._doing: tuple[State, Order, bool] | None = None
        self._since = 0.0
        self._flown_for = 0.0
        self._carried = False
        self._places = np.zeros((flown.count, 3))
        self._ends = np.zeros((flown.count, 3))
        self._time = _LEAST_TIME
        self._floor: float | None = None
        self._pulled = 0.0

    def step(self, state: State, order: Order, seen: Estimate, now: float) -> Wanted:
        """The forces for now; called at the law's rate.

        Args:
            state: of the supervisor.
            order: to be carried out by set-points.
            seen: everything.
            now: s.
        """
        bodies = [seen.bodies[f"vehicle_{k + 1}"] for k in range(self._flown.count)]
        place = np.array([b.position for b in bodies])
        velocity = np.array([b.velocity for b in bodies])
        self._look(state, seen)
        by_law = self._flies_law(state, order, seen)
        if self._doing != (state, order, by_law):
            self._begin(state, order, by_law, seen, place, now)
        lasted = now - self._since
        if by_law:
            return self._by_law(state, order, seen, place, velocity, lasted)
        target, rate = self._path(order, lasted)
        force = self._alone(place, velocity, target, rate) + self._pulled * self._share
        done = order is Order.TRACK and lasted >= self._time + _SETTLE
        return Wanted(force, self._yaw, 0.0, done, target, None)

    def needs_load(self, state: State) -> bool:
        """Whether a state cannot go on without seeing the load."""
        return self.carries or state in _NEED_LOAD

    def is_load_sound(self, seen: Estimate) -> bool:
        """Whether the load is seen, and where its cables reach."""
        well = seen.bodies["payload"].standing.quality >= Quality.COASTING
        return well and self.reaches(seen)

    def reaches(self, seen: Estimate) -> bool:
        """Whether no cable seems longer than it is."""
        most = zip(seen.cables, self._lengths, strict=True)
        return not any(cable.distance > _STRETCH * length for cable, length in most)

    @property
    def _yaw(self) -> float:
        return float(self._flown.values["start"]["payload_yaw"])

    def _look(self, state: State, seen: Estimate) -> None:
        """Where the load is, and what it pulls; as last seen, where it is not."""
        load = seen.bodies["payload"]
        if not self.is_load_sound(seen):
            return
        if self._floor is None or state is State.ARMED:
            self._floor = load.position[2]
        height = load.position[2] - self._floor
        self.carries = height > (_DOWN_AGAIN if self.carries else _LIFTED)
        self._pulled = min(max(height / _LIFTED, 0.0), 1.0) if self.carries else 0.0

    def _flies_law(self, state: State, order: Order, seen: Estimate) -> bool:
        if order is Order.TRACK:
            return state in (State.LIFT, State.FLY) or (state is State.SET_DOWN and self.carries)
        return order is Order.STAY and self.carries and self.is_load_sound(seen)

    def _begin(
        self, state: State, order: Order, by_law: bool, seen: Estimate, place: Array, now: float
    ) -> None:
        """Takes the present as the start of what is to be done."""
        before, self._doing, self._since = self._doing, (state, order, by_law), now
        self._places, self._ends = place, place.copy()
        load = np.array(seen.bodies["payload"].position)
        if by_law:
            self._follow(state, load, before)
            return
        if order is Order.DESCEND:
            out = place - place.mean(axis=0)
            out[:, 2] = 0.0
            self._ends += _APART * out / np.maximum(np.linalg.norm(out, axis=1), 1e-6)[:, None]
            self._time = _APART_TIME
            return
        if state is State.TAKE_OFF:
            self._ends[:, 2] += _CLEAR
        elif state is State.FORM_UP:
            self._ends = load + self._offset - np.array([0.0, 0.0, _SLACK])
        elif state is State.SET_DOWN:
            self._ends[:, 2] -= _SLACK
        self._time = _time(self._ends - place)

    def _follow(self, state: State, load: Array, before: tuple[State, Order, bool] | None) -> None:
        """Gives the law the reference of a state."""
        flown = self._flown
        if state is State.LIFT:
            self.law.reset()
            goal = flown.values["start"]["payload_position"]
            self.law.follow(self._move(load, goal, _LIFT_TIME))
        elif state is State.FLY:
            resumed = before is not None and before[0] is State.PAUSE
            self._since -= self._flown_for if resumed else 0.0
            self._carried = False
            self.law.follow(flown)
        elif state is State.SET_DOWN:
            assert self._floor is not None  # it was lifted from there
            ground = [float(load[0]), float(load[1]), self._floor - _BELOW]
            self.law.follow(self._move(load, ground, _LIFT_TIME))
        else:
            self.law.follow(self._move(load, load.tolist(), _LEAST_TIME))

    def _move(self, start: Array, goal: list[float], duration: float) -> SpatialScenario:
        return self._changed(self._flown, {
            "start.payload_position": start.tolist(),
            "start.vehicle_position": (start + self._offset).tolist(),
            "goal.payload_position": goal,
            "reference.kind": "min_snap",
            "reference.start": 0.0,
            "reference.duration": duration,
        })  # fmt: skip

    @staticmethod
    def _changed(flown: SpatialScenario, values: dict[str, Any]) -> SpatialScenario:
        changed = flown.with_values(values)
        assert isinstance(changed, SpatialScenario)
        return changed

    def _by_law(
        self, state: State, order: Order, seen: Estimate, place: Array, velocity: Array,
        lasted: float,
    ) -> Wanted:  # fmt: skip
        load = seen.bodies["payload"]
        command = self.law.update(
            lasted, place, velocity, load.position, load.attitude, load.velocity, load.rate
        )
        if state is State.FLY:
            self._flown_for = lasted
            self._carried = self._carried or self.carries
        over = {
            State.LIFT: _LIFT_TIME + _SETTLE,
            State.FLY: float(self._flown.values["simulation"]["duration"]),
        }.get(state, np.inf)
        swing = float(command.swing.max()) if self.carries else 0.0
        target = self.law.target(lasted)
        # A reference may end with the load on the floor: then there is nothing left to fly.
        stands = state is State.FLY and self._carried and not self.carries
        done = order is Order.TRACK and (lasted >= over or stands)
        return Wanted(command.force, target.yaw, swing, done, target.vehicle, target.payload)

    def _path(self, order: Order, lasted: float) -> tuple[Array, Array]:
        """Places and velocities of vehicles that go by themselves."""
        part, rate = smooth(lasted / self._time)
        way = self._ends - self._places
        target, speed = self._places + part * way, rate / self._time * way
        if order is Order.DESCEND:
            target[:, 2] -= _DOWN * lasted
            speed[:, 2] -= _DOWN
        return target, speed

    def _alone(self, place: Array, velocity: Array, target: Array, rate: Array) -> Array:
        """Forces of vehicles that follow paths, leaning so far at most."""
        wanted = _STIFFNESS * (target - place) + _DAMPING * (rate - velocity)
        force = self._mass[:, None] * wanted
        force[:, 2] = np.maximum(force[:, 2] + self._weight, 0.3 * self._weight)
        across = np.linalg.norm(force[:, :2], axis=1)
        most = np.tan(_MOST_LEAN) * force[:, 2]
        force[:, :2] *= np.minimum(1.0, most / np.maximum(across, 1e-9))[:, None]
        return force
