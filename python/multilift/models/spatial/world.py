"""One spatial world, stepped from outside: by forces, by attitudes and thrusts, or by motors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import _core
from multilift.errors import ControllerError, ScenarioError
from multilift.models.spatial import rows
from multilift.models.spatial.scenario import SpatialScenario, spatial_only
from multilift.scenario import Scenario

Array = NDArray[np.float64]

#: Where PX4's and ArduPilot's quad-X motors 1 to 4 stand among the rotors here:
#: ``commands[:, AUTOPILOT_MOTORS]`` puts theirs in the order of `SpatialWorld.step_motors`.
AUTOPILOT_MOTORS = (2, 1, 3, 0)

#: Rotors of a vehicle.
ROTORS = 4


@dataclass(frozen=True, slots=True)
class Incident:
    """Something that happened in a world.

    Attributes:
        t: when it was known, to one integration step, s.
        what: "slack", "taut", "touch_down", "lift_off", "cable_cut", "rotor_stopped",
            "vehicle_lost", "collision" or "diverged".
        vehicle: whose, counted from 0; -1 for the payload or nobody's.
    """

    t: float
    what: str
    vehicle: int


class SpatialWorld:
    """The plant of a spatial scenario under your own commands.

    ::

        world = SpatialWorld(scenario)
        while world.status == "running" and world.t < 10.0:
            command = law.update(world.t, world.vehicle, world.vehicle_velocity, ...)
            world.step_forces(command.asked, steps=world.control_steps)

    Everything is that of ``simulate``: cables that go slack and taut, ground, wind, pushes, what
    breaks, motion capture, limits and link. Given a run's commands, a world goes through its states
    to the last bit. ``simulation.duration`` ends nothing here; a collision or divergence does, and
    the world stays as it was then.

    How the vehicles are driven may change from step to step.

    - `step_forces` as a run's law does, through the scenario's ``limits`` and ``link``; quadrotors'
      own control, PX4's cascade, turns the forces into rotor speeds.
    - `step_set_points` has quadrotors' own control follow attitudes and thrusts.
    - `step_motors` drives the rotors, for autopilots outside.

    The arrays are views that each step overwrites: copy what you want to keep. World axes x east,
    y north, z up; body axes x forward, y left, z up; quaternions scalar first, body to world.

    Attributes:
        scenario: whose world it is.
        count: number of vehicles n.
        period: of an integration step, s.
        control_steps: integration steps between two commands of the scenario's law.
        payload: its centre of mass, shape (3,), m.
        payload_attitude: shape (4,).
        payload_velocity: shape (3,), m/s.
        payload_rate: in its frame, shape (3,), rad/s.
        payload_contact: the ground's force on it, shape (3,), N.
        vehicle: positions, shape (n, 3), m.
        vehicle_velocity: shape (n, 3), m/s.
        vehicle_attitude: shape (n, 4); level for ideal vehicles.
        vehicle_rate: body axes, shape (n, 3), rad/s.
        rotor_speed: shape (n, 4), rad/s; counted counterclockwise from the front left (X frame) or
            the front (+), the first turning clockwise, seen from above.
        specific_force: what accelerometers at the vehicles' centres of mass feel, body axes, shape
            (n, 3), m/s^2: (0, 0, g) at rest. Impulses of cables that are pulled taut pass between
            two instants and show in the velocities alone.
        thrust: force of each vehicle's rotors as it acts, world, shape (n, 3), N.
        contact: the ground's force on each vehicle, shape (n, 3), N.
        tension: of the cables under what drives the vehicles now, shape (n,), N.
        length: from each vehicle to its attachment, shape (n,), m.
        wind: shape (3,), m/s.
        taut: whether each cable pulls, shape (n,).
        standing: whether each vehicle touches the ground, shape (n,).
        saturated: whether each vehicle's last command hit a limit, shape (n,).
        measured_vehicle: positions as the scenario's motion capture tells them now; the truth
            where it is ideal, shape (n, 3), m.
        measured_vehicle_velocity: likewise, shape (n, 3), m/s.
        measured_payload: likewise position, attitude, velocity, rate, shape (13,).
    """

    payload: Array
    payload_attitude: Array
    payload_velocity: Array
    payload_rate: Array
    payload_contact: Array
    vehicle: Array
    vehicle_velocity: Array
    vehicle_attitude: Array
    vehicle_rate: Array
    rotor_speed: Array
    specific_force: Array
    thrust: Array
    contact: Array
    tension: Array
    length: Array
    wind: Array
    measured_vehicle: Array
    measured_vehicle_velocity: Array
    measured_payload: Array
    taut: NDArray[np.bool_]
    standing: NDArray[np.bool_]
    saturated: NDArray[np.bool_]

    def __init__(self, scenario: Scenario) -> None:
        """Puts the world at its start.

        Raises:
            ScenarioError: for a scenario that is not spatial.
        """
        self.scenario: SpatialScenario = spatial_only(scenario, "SpatialWorld")
        self.count = n = self.scenario.count
        self.period = float(self.scenario["simulation.step"])
        self.control_steps = round(self.scenario.control_period() / self.period)
        self._turning = self.scenario["vehicle.kind"] == "quadrotor"
        shapes = _shapes(n)
        self._numbers = np.zeros(sum(int(np.prod(shape)) for shape in shapes.values()))
        self._flags = np.zeros(3 * n, dtype=bool)
        seen = self._numbers.view()
        seen.flags.writeable = False
        at = 0
        for name, shape in shapes.items():
            size = int(np.prod(shape))
            setattr(self, name, seen[at : at + size].reshape(shape))
            at += size
        flags = self._flags.view()
        flags.flags.writeable = False
        self.taut, self.standing, self.saturated = flags.reshape(3, n)
        self.reset()

    _t: Array
    _energy: Array
    _impacts: Array
    _clearance: Array

    def reset(self) -> None:
        """Puts the world back to its start."""
        frame, row, seed = rows.problem(self.scenario)
        self._core = _core.spatial_world(_core.SpatialFrame(**frame), row, seed)
        self._told: list[Incident] = []
        self._core.show(self._numbers, self._flags)

    @property
    def t(self) -> float:
        """Time since the start, s."""
        return float(self._t[0])

    @property
    def status(self) -> str:
        """One of "running", "collision", "diverged"."""
        return str(self._core.status)

    @property
    def incidents(self) -> list[Incident]:
        """What happened so far, in order."""
        self._told += [Incident(*told) for told in self._core.incidents(len(self._told))]
        return list(self._told)

    @property
    def energy(self) -> float:
        """Mechanical energy of payload and vehicles, from z = 0, J."""
        return float(self._energy[0])

    @property
    def impacts(self) -> tuple[int, float, float]:
        """How often cables were pulled taut, energy lost in it, J, and hardest impulse, N s."""
        count, lost, hardest = self._impacts.tolist()
        return int(count), lost, hardest

    @property
    def clearance(self) -> tuple[float, float]:
        """Least distance between two vehicles, and of a vehicle from another's cable, m."""
        vehicles, cables = self._clearance.tolist()
        return vehicles, cables

    def step_forces(
        self, force: ArrayLike, *, yaw: float | None = None, steps: int | None = None
    ) -> None:
        """Commands forces, gravity included, as a law answers them.

        Args:
            force: of each vehicle, shape (n, 3), world, N.
            yaw: heading of quadrotors, rad; left out: the reference's.
            steps: integration steps for which they are held; left out: one control period.

        Raises:
            ControllerError: for numbers of another shape or not finite, or no step.
        """
        given = self._checked("forces", force, (self.count, 3))
        if yaw is not None and not np.isfinite(yaw):
            raise ControllerError(f"yaw is {yaw}\n  permitted: finite, rad")
        self._core.step_forces(given, yaw, self._steps(steps))
        self._core.show(self._numbers, self._flags)

    def step_set_points(
        self, attitude: ArrayLike, thrust: ArrayLike, *, steps: int | None = None
    ) -> None:
        """Has quadrotors' own control follow attitudes and thrusts, without limits and link.

        Args:
            attitude: unit quaternions, shape (n, 4).
            thrust: normalised, 0 to 1, shape (n,), as `FlyingLaw.set_points` gives them.
            steps: as of `step_forces`.

        Raises:
            ControllerError: as of `step_forces`, and for ideal vehicles.
        """
        n = self.count
        self._check_turning("step_set_points")
        wanted = np.empty((n, 5))
        wanted[:, :4] = self._checked("attitudes", attitude, (n, 4)).reshape(n, 4)
        wanted[:, 4] = self._checked("thrusts", thrust, (n,))
        length = np.linalg.norm(wanted[:, :4], axis=1)
        if np.abs(length - 1.0).max() > _UNIT_TOLERANCE:
            raise ControllerError(
                f"attitudes have the lengths {length.tolist()}\n  permitted: unit quaternions"
            )
        self._core.step_set_points(wanted.ravel(), self._steps(steps))
        self._core.show(self._numbers, self._flags)

    def step_motors(self, command: ArrayLike, *, steps: int | None = None) -> None:
        """Drives the rotors of quadrotors.

        Args:
            command: of each rotor the part of its greatest speed, cut to 0 to 1, shape (n, 4), in
                the order of ``rotor_speed``; 0 stops it, which ``vehicle.rotor_speed_min`` does
                not prevent. An autopilot's, in its own order: ``command[:, AUTOPILOT_MOTORS]``.
            steps: as of `step_forces`.

        Raises:
            ControllerError: as of `step_forces`, and for ideal vehicles.
        """
        self._check_turning("step_motors")
        given = self._checked("motor commands", command, (self.count, ROTORS))
        self._core.step_motors(given, self._steps(steps))
        self._core.show(self._numbers, self._flags)

    def fail(self, what: str, vehicle: int, rotor: int = 0) -> None:
        """Breaks something from now on, as an ``[[event]]`` of the scenario does.

        Args:
            what: "cable_cut", "rotor_stopped" or "vehicle_lost".
            vehicle: whose, counted from 0.
            rotor: which, counted from 0.

        Raises:
            ScenarioError: for anything else.
        """
        kinds = ("cable_cut", "vehicle_lost", "rotor_stopped")[: 3 if self._turning else 2]
        for name, value, permitted in (
            ("what", what, kinds), ("vehicle", vehicle, range(self.count)),
            ("rotor", rotor, range(ROTORS)),
        ):  # fmt: skip
            if value not in permitted:
                raise ScenarioError(
                    "cannot break", where="SpatialWorld.fail", key=name, value=value,
                    permitted=", ".join(map(str, permitted)),
                )  # fmt: skip
        self._core.fail(what, vehicle, rotor)

    def _check_turning(self, what: str) -> None:
        if not self._turning:
            raise ControllerError(
                f"{what}: the vehicles are ideal and take forces only\n"
                '  what to do: vehicle.kind = "quadrotor", or vehicle.type, in the scenario'
            )

    @staticmethod
    def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
        given = np.ascontiguousarray(value, dtype=float)
        if given.shape != shape:
            raise ControllerError(f"{name} have the shape {given.shape}\n  permitted: {shape}")
        if not np.isfinite(given).all():
            raise ControllerError(f"{name} are {given.tolist()}\n  permitted: finite numbers")
        return given.ravel()

    def _steps(self, steps: int | None) -> int:
        if steps is None:
            return self.control_steps
        if steps < 1:
            raise ControllerError(f"steps is {steps}\n  permitted: 1 or more")
        return steps


#: How far a commanded quaternion's length may be from 1.
_UNIT_TOLERANCE = 1e-3


def _shapes(n: int) -> dict[str, tuple[int, ...]]:
    """What the core shows, in its order."""
    return {
        "_t": (1,),
        "payload": (3,),
        "payload_attitude": (4,),
        "payload_velocity": (3,),
        "payload_rate": (3,),
        "payload_contact": (3,),
        "vehicle": (n, 3),
        "vehicle_velocity": (n, 3),
        "vehicle_attitude": (n, 4),
        "vehicle_rate": (n, 3),
        "rotor_speed": (n, ROTORS),
        "specific_force": (n, 3),
        "thrust": (n, 3),
        "contact": (n, 3),
        "tension": (n,),
        "length": (n,),
        "wind": (3,),
        "_energy": (1,),
        "_impacts": (3,),
        "_clearance": (2,),
        "measured_vehicle": (n, 3),
        "measured_vehicle_velocity": (n, 3),
        "measured_payload": (13,),
    }
