"""The compiled law that simulates, stepped by whoever flies it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import _core
from multilift.errors import ControllerError, ScenarioError
from multilift.models.spatial import rows
from multilift.models.spatial.scenario import SpatialScenario, spatial_only
from multilift.scenario import Scenario

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Command:
    """What a law answers at a control instant; world axes x east, y north, z up.

    Attributes:
        force: that the rotors of each vehicle shall exert, gravity included, within the scenario's
            ``limits``: what is sent to the vehicles, shape (n, 3), N.
        asked: the same before the limits, shape (n, 3), N.
        swing: how far each cable, as measured, has turned from its direction at rest, shape (n,),
            rad.
        limited: whose force the limits changed, shape (n,).
    """

    force: Array
    asked: Array
    swing: Array
    limited: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Target:
    """Where everything shall be at one instant; world axes.

    Attributes:
        vehicle: shape (n, 3), m.
        vehicle_velocity: shape (n, 3), m/s.
        payload: its centre of mass, shape (3,), m.
        payload_velocity: shape (3,), m/s.
        payload_acceleration: shape (3,), m/s^2.
        yaw: heading of the payload and of the vehicles, rad.
        yaw_rate: rad/s.
    """

    vehicle: Array
    vehicle_velocity: Array
    payload: Array
    payload_velocity: Array
    payload_acceleration: Array
    yaw: float
    yaw_rate: float


class FlyingLaw:
    """A scenario's law outside of a simulation, with all that it learns on the way.

    ::

        law = FlyingLaw(scenario)
        while flying:  # every law.period
            command = law.update(t, vehicle, vehicle_velocity, payload, attitude, velocity, rate)
            attitudes, thrusts = law.set_points(command.force, law.target(t).yaw)

    It is the law of ``simulate``, built from the same numbers: told what a run's law is told, it
    gives that one's forces to the last bit. Each update moves adaptation and integral on by one
    control period, whenever it comes.

    Attributes:
        scenario: whose law it is.
        count: number of vehicles n.
        period: between two updates, s; of ``controller.rate``.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Makes the law at its start.

        Raises:
            ScenarioError: for a scenario that is not spatial.
        """
        self.scenario: SpatialScenario = spatial_only(scenario, "FlyingLaw")
        self.count = n = self.scenario.count
        self.period = scenario.control_period()
        self._told = np.zeros(6 * n + 13)
        self._places = (
            ("vehicle", self._told[: 3 * n].reshape(n, 3)),
            ("vehicle_velocity", self._told[3 * n : 6 * n].reshape(n, 3)),
            ("payload", self._told[6 * n : 6 * n + 3]),
            ("payload_attitude", self._told[6 * n + 3 : 6 * n + 7]),
            ("payload_velocity", self._told[6 * n + 7 : 6 * n + 10]),
            ("payload_rate", self._told[6 * n + 10 :]),
        )
        self._free = [False] * n
        self._hover_thrust = np.array(self.scenario["autopilot.hover_thrust"])
        self._has_curve = self.scenario["vehicle.kind"] == "quadrotor"
        self.reset()

    def reset(self) -> None:
        """Forgets what the law has learnt, and whom it followed."""
        frame, row, _ = rows.problem(self.scenario)
        self._core = _core.SpatialLaw(_core.SpatialFrame(**frame), row)
        self._hover_force = np.array(self._core.hover_force)

    def update(
        self,
        t: float,
        vehicle: ArrayLike,
        vehicle_velocity: ArrayLike,
        payload: ArrayLike,
        payload_attitude: ArrayLike,
        payload_velocity: ArrayLike,
        payload_rate: ArrayLike,
        saturated: Iterable[bool] | None = None,
    ) -> Command:
        """One control period of the law.

        Args:
            t: time since the scenario's start, s; says where the targets are.
            vehicle: measured positions, shape (n, 3), m.
            vehicle_velocity: shape (n, 3), m/s.
            payload: of its centre of mass, shape (3,), m.
            payload_attitude: to the world, unit quaternion, scalar first, shape (4,). Any for a
                point mass.
            payload_velocity: shape (3,), m/s.
            payload_rate: in the payload's frame, shape (3,), rad/s.
            saturated: which vehicles could not follow their last command; integral action rests
                there. Forces that the limits cut are added without being told.

        Raises:
            ControllerError: for numbers that are not finite, of another shape, or an attitude that
                is no unit quaternion; the law is then as it was.
        """
        values = (
            vehicle, vehicle_velocity, payload, payload_attitude, payload_velocity, payload_rate,
        )  # fmt: skip
        for (name, place), value in zip(self._places, values, strict=True):
            given = np.asarray(value, dtype=float)
            if given.shape != place.shape:
                raise ControllerError(
                    f"{name} measured has the shape {given.shape}\n  permitted: {place.shape}"
                )
            place[...] = given
        w, x, y, z = self._told[6 * self.count + 3 : 6 * self.count + 7].tolist()
        # A sum is finite only if all its parts are; measured positions do not overflow.
        if not np.isfinite(self._told.sum() + t):
            raise self._not_finite(t)
        if not abs(w * w + x * x + y * y + z * z - 1.0) < _UNIT_TOLERANCE:
            raise ControllerError(
                f"payload_attitude measured is {[w, x, y, z]}\n"
                "  permitted: a unit quaternion, scalar first"
            )
        n = self.count
        full = self._free if saturated is None else [bool(is_so) for is_so in saturated]
        if len(full) != n:
            raise ControllerError(f"saturated has {len(full)} entries\n  permitted: {n}")
        out = np.empty(8 * n)
        self._core.step(t, self._told, full, out)
        return Command(
            out[: 3 * n].reshape(n, 3),
            out[3 * n : 6 * n].reshape(n, 3),
            out[6 * n : 7 * n],
            out[7 * n :] > 0.0,
        )

    def _not_finite(self, t: float) -> ControllerError:
        named = next((name for name, place in self._places if not np.isfinite(place).all()), "t")
        return ControllerError(
            f"{named} measured is not finite at t = {t:g} s\n"
            "  what to do: update the law only with what was measured"
        )

    def target(self, t: float) -> Target:
        """Where everything shall be at a time since the start, s; leaves the law as it is."""
        n = self.count
        out = np.empty(6 * n + 11)
        self._core.target(t, out)
        payload = out[6 * n :]
        return Target(
            out[: 3 * n].reshape(n, 3),
            out[3 * n : 6 * n].reshape(n, 3),
            payload[:3],
            payload[3:6],
            payload[6:9],
            float(payload[9]),
            float(payload[10]),
        )

    def follow(self, scenario: Scenario) -> None:
        """From here on the targets of another scenario: its goal, reference and formation.

        The law's gains, limits and what it assumes and has learnt stay. Times that ``update`` is
        given are then since that scenario's start.

        Raises:
            ScenarioError: for one that is not spatial, or of another number of vehicles.
        """
        other = spatial_only(scenario, "FlyingLaw.follow")
        if other.count != self.count:
            raise ScenarioError(
                "is another team's", where=other.where, key="plant.vehicles", value=other.count,
                permitted=str(self.count),
            )  # fmt: skip
        frame, row, _ = rows.problem(other)
        self._core.follow(_core.SpatialFrame(**frame), row)

    @property
    def drag_estimate(self) -> Array:
        """What the law has learnt of each vehicle's drag, shape (n, 3), N s/m; 0 if it does not."""
        return np.array(self._core.drag_estimate)

    @property
    def hover_force(self) -> Array:
        """Weight of each vehicle and of its share of the load, as assumed, shape (n,), N."""
        return self._hover_force.copy()

    def set_points(
        self,
        force: ArrayLike,
        yaw: float,
        *,
        hover_thrust: ArrayLike | None = None,
        hover_force: ArrayLike | None = None,
    ) -> tuple[Array, Array]:
        """What flight stacks take for these forces.

        Attitudes turn body axes x forward, y left, z up (FLU) into the world's x east, y north, z
        up (ENU), with the shortest tilt away from the heading. MAVLink wants them between FRD and
        NED: turn them where the message is made.

        Args:
            force: of each vehicle, shape (n, 3), N.
            yaw: of their heading, rad.
            hover_thrust: normalised thrust that lifts ``hover_force``, shape (n,), 0 to 1; left
                out: ``autopilot.hover_thrust``, and where that is 0 the rotors' thrust curve.
            hover_force: shape (n,), N; left out: the vehicles and their shares of the load.

        Returns:
            Unit quaternions, scalar first, shape (n, 4), and normalised thrusts, shape (n,).

        Raises:
            ControllerError: for forces of another shape or not finite, and for ideal vehicles
                without hover thrust.
        """
        n = self.count
        thrust = self._of_each("hover_thrust", hover_thrust, self._hover_thrust)
        weight = self._of_each("hover_force", hover_force, self._hover_force)
        if not (self._has_curve or thrust.min() > 0.0):
            raise ControllerError(
                "ideal vehicles have no thrust curve\n"
                "  what to do: give hover_thrust, or autopilot.hover_thrust in the scenario"
            )
        given = np.ascontiguousarray(force, dtype=float)
        if given.shape != (n, 3) or not np.isfinite(given).all():
            raise ControllerError(
                f"forces are {given.tolist()}\n  permitted: finite, shape ({n}, 3), N"
            )
        out = np.empty(5 * n)
        self._core.set_points(given.ravel(), yaw, weight, thrust, out)
        return out[: 4 * n].reshape(n, 4), out[4 * n :]

    def _of_each(self, name: str, value: ArrayLike | None, otherwise: Array) -> Array:
        if value is None:
            return otherwise
        given = np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=float), (self.count,)))
        if not (np.isfinite(given).all() and given.min() > 0.0):
            raise ControllerError(f"{name} is {given.tolist()}\n  permitted: > 0")
        return given


#: How far the square of a measured quaternion's length may be from 1.
_UNIT_TOLERANCE = 1e-3
