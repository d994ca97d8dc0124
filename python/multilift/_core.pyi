"""
Compiled core of multilift. Use the multilift package; this module may change.
"""

from collections.abc import Callable, Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray


def build_info() -> dict:
    """Compiler, and the commit of the sources where they were a checkout."""

def instruction_sets() -> list:
    """Names of the batch kernels that this processor can run, widest first."""

def sincos(x: float) -> tuple:
    """Sine and cosine of x, rad."""

def philox(counter: Sequence[int], key: Sequence[int]) -> list[int]:
    """One block of Philox 4x32-10."""

def normal_pair(seed: int, stream: int, index: int) -> list[float]:
    """Two standard normal draws, a pure function of the arguments."""

def evaluate(name: str, x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], y: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], out: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    out = sqrt, sin, cos, exp, log or atan of x, or atan2(x, y), as this module computes it.
    """

def normals(seeds: Annotated[NDArray[numpy.uint64], dict(shape=(None,), order='C', device='cpu', writable=False)], stream: int, draws: Annotated[NDArray[numpy.uint64], dict(shape=(None,), order='C', device='cpu', writable=False)], out: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Fills out, shape (seeds, draws, 2), with the normal numbers of these draws.
    """

class PlannedWay2:
    """A planned way; empty where none keeps to the limits."""

    @property
    def end(self) -> float:
        """When it stands still, s; infinite behind a goal that moves."""

    @property
    def pieces(self) -> list[tuple[float, list[list[float]]]]:
        """Start, s, and coefficients of (t - start)^0 to ^9 of each coordinate."""

    def at(self, time: float) -> list[list[float]]:
        """Each coordinate with four derivatives."""

    @staticmethod
    def timed(start: Sequence[Sequence[float]], goal: Sequence[float], goal_velocity: Sequence[float], duration: float) -> PlannedWay2: ...

    @staticmethod
    def least_snap(start: Sequence[float], goal: Sequence[float], duration: float) -> PlannedWay2: ...

    @staticmethod
    def move(start: Sequence[Sequence[float]], goal: Sequence[float], goal_velocity: Sequence[float], limits: Sequence[float], remaining: float) -> PlannedWay2: ...

    @staticmethod
    def shaped(start: Sequence[float], goal: Sequence[float], limits: Sequence[float], impulses: Sequence[tuple[float, float]], pendulum: Sequence[float], load: bool) -> PlannedWay2: ...

    @staticmethod
    def antiswing(position: Sequence[float], velocity: Sequence[float], lean: Sequence[float], lean_rate: Sequence[float], goal: Sequence[float], goal_velocity: Sequence[float], limits: Sequence[float], ratio: float, pendulum: Sequence[float], load: bool) -> PlannedWay2: ...

class PlannedWay3:
    """A planned way; empty where none keeps to the limits."""

    @property
    def end(self) -> float:
        """When it stands still, s; infinite behind a goal that moves."""

    @property
    def pieces(self) -> list[tuple[float, list[list[float]]]]:
        """Start, s, and coefficients of (t - start)^0 to ^9 of each coordinate."""

    def at(self, time: float) -> list[list[float]]:
        """Each coordinate with four derivatives."""

    @staticmethod
    def timed(start: Sequence[Sequence[float]], goal: Sequence[float], goal_velocity: Sequence[float], duration: float) -> PlannedWay3: ...

    @staticmethod
    def least_snap(start: Sequence[float], goal: Sequence[float], duration: float) -> PlannedWay3: ...

    @staticmethod
    def move(start: Sequence[Sequence[float]], goal: Sequence[float], goal_velocity: Sequence[float], limits: Sequence[float], remaining: float) -> PlannedWay3: ...

    @staticmethod
    def shaped(start: Sequence[float], goal: Sequence[float], limits: Sequence[float], impulses: Sequence[tuple[float, float]], pendulum: Sequence[float], load: bool) -> PlannedWay3: ...

    @staticmethod
    def antiswing(position: Sequence[float], velocity: Sequence[float], lean: Sequence[float], lean_rate: Sequence[float], goal: Sequence[float], goal_velocity: Sequence[float], limits: Sequence[float], ratio: float, pendulum: Sequence[float], load: bool) -> PlannedWay3: ...

def plan_least_snap_duration(distance: float, limits: Sequence[float]) -> float:
    """The shortest time of such a move within limits, s."""

def shaper_impulses(kind: str, frequency: float, damping: float, tolerance: float) -> list[tuple[float, float]]:
    """Times, s, and weights of a shaper's impulses."""

def shaper_residual(impulses: Sequence[tuple[float, float]], frequency: float, damping: float) -> float:
    """What is left of a mode's swing, as a part of that of one impulse."""

def planar_plant_fields() -> list:
    """Fields of the planar plant's parameters."""

def planar_motion(plant: Sequence[float], q: Sequence[float], q_dot: Sequence[float], loads: Sequence[float]) -> dict:
    """
    Accelerations and tensions by the fast formulation, at seven coordinates that satisfy the closure. loads: u1..u4, vehicle pushes (4), bar push (2), N, bar torque, N m.
    """

def planar_redundant_motion(plant: Sequence[float], q: Sequence[float], q_dot: Sequence[float], loads: Sequence[float]) -> dict:
    """The same by equations (7)-(16) with the closure's multipliers."""

def planar_mass_matrix(plant: Sequence[float], q: Sequence[float]) -> list[list[float]]:
    """M(q) of (15)."""

def planar_closure(plant: Sequence[float], q: Sequence[float]) -> list[float]:
    """c(q), m."""

def planar_rest_angles(plant: Sequence[float], vehicle_position: Sequence[float]) -> list[float] | None:
    """
    Angles, rad, at which the load hangs at rest below vehicles at (y1, z1, y2, z2), m; None where there is no rest with all angles inside +-pi/2.
    """

def planar_seven(plant: Sequence[float], bar: Sequence[float], theta: Sequence[float], bar_velocity: Sequence[float], theta_dot: Sequence[float]) -> tuple:
    """q and q_dot from the five free coordinates and their rates."""

def planar_free_coordinates(plant: Sequence[float], q: Sequence[float], q_dot: Sequence[float]) -> list[float]:
    """
    [bar y, bar z, theta1..3 and their rates] from the seven coordinates and their rates.
    """

def planar_starts(plants: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], vehicle_positions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], angles: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], vehicle_velocities: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], angle_rates: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu')]:
    """
    For each row: the ten free coordinates, and how far the start misses the closure (m) and its rate (m/s). NaN angles mean at rest; a row of NaN, that there is none.
    """

def planar_jacobian(plant: Sequence[float], free_coordinates: Sequence[float], u: Sequence[float]) -> list[list[float]]:
    """
    Exact derivatives, 10 x 14, of the rates of the free coordinates along themselves and u.
    """

def planar_energies(plant: Sequence[float], k_lambda: float, k_p: Sequence[float], k_d: Sequence[float], gamma: Sequence[float], goal: Sequence[float], d_hat: Sequence[float], q: Sequence[float], q_dot: Sequence[float], loads: Sequence[float]) -> dict:
    """Energies (18), (46), (49), J, and the powers that change (49), W."""

def planar_laws() -> dict:
    """{name: (title, gain fields)} of every compiled planar law."""

def planar_law_nanoseconds(law: str, gains: Sequence[float], assumed_plant: Sequence[float], goal: Sequence[float], period: float, repetitions: int) -> float:
    """Mean time of one step of a compiled law, ns, for benchmarks."""

def planar_law_jacobian(law: str, gains: Sequence[float], assumed_plant: Sequence[float], goal: Sequence[float], period: float, q: Sequence[float], q_dot: Sequence[float]) -> list[list[float]]:
    """
    Row k: derivatives of u_k along the seven coordinates and their rates (dual numbers).
    """

class PlanarLaw:
    """A compiled planar control law, stepped by hand."""

    def __init__(self, name: str, gains: Sequence[float], assumed_plant: Sequence[float], goal: Sequence[float], period: float) -> None: ...

    def step(self, q: Sequence[float], q_dot: Sequence[float], saturated: tuple[bool, bool] = (False, False)) -> list[float]:
        """
        u1..u4, N, from measured coordinates and rates; advances the law by one period.
        """

    @property
    def d_hat(self) -> list[float]:
        """Drag estimates d_hat_y1, d_hat_z1, d_hat_y2, d_hat_z2, N s/m."""

def planar_actuator_fields() -> list: ...

def planar_sensor_fields() -> list: ...

def planar_describe() -> dict:
    """{'columns' | 'metrics' | 'audit': [(name, unit, meaning), ...]}."""

planar_delay_capacity: int = 256

class PlanarPush:
    """An outside force on a body as a function of time."""

    def __init__(self, body: str, force: Sequence[float], torque: float, shape: str, start: float, duration: float, frequency: float, sample_times: Sequence[float], sample_values: Sequence[float]) -> None: ...

class PlanarSetup:
    """A run, less its control law."""

    def __init__(self, plant: Sequence[float], assumed_plant: Sequence[float], q: Sequence[float], q_dot: Sequence[float], goal: Sequence[float], pushes: Sequence[PlanarPush], step: float, steps: int, control_steps: int, record_steps: int, actuators: Sequence[float], sensors: Sequence[float], ideal: bool, seed: int, pieces: Sequence[tuple[float, Sequence[Sequence[float]]]], path_end: float, view: Sequence[float]) -> None: ...

def planar_rollout(setup: PlanarSetup, law: str, gains: Sequence[float]) -> dict:
    """Runs a compiled law. Releases the GIL."""

def planar_rollout_python(setup: PlanarSetup, law: Callable) -> dict:
    """
    Runs a law written in Python, law(t, q, q_dot, saturated) -> (u1, u2, u3, u4).
    """

class SpatialFrame:
    """What the spatial worlds of one batch share."""

    def __init__(self, *, n: int, law: str, quadrotors: bool, rigid: bool, ground: bool, motion_capture: bool, rotors_running: bool, autopilot_steps: int, pieces: Sequence[tuple[float, Sequence[Sequence[float]]]], path_end: float, pushes: Sequence[tuple[int, str, Sequence[float], Sequence[float]]], happenings: Sequence[tuple[str, int, int, int]], step: float, steps: int, control_steps: int, record_steps: int) -> None: ...

def spatial_run(frame: SpatialFrame, row: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], seed: int, law: object | None = None) -> dict:
    """
    One run: samples, metrics, audit, status, end time. `law` is a Python callable in place of the compiled one.
    """

def spatial_recorded(frame: SpatialFrame, row: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], flown: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], complete: bool) -> dict:
    """A measured flight told as a run: samples, metrics, audit."""

def spatial_fields() -> dict:
    """
    Tables of fields: (name, unit, range, shape, defaults, meaning) each; "n" in a shape is the number of vehicles.
    """

def spatial_laws() -> dict:
    """Of each compiled law its title and the table of its gains."""

def spatial_describe(n: int, quadrotors: bool) -> dict:
    """Columns, metrics and audit entries: (name, unit, meaning) each."""

class SpatialLaw:
    """A compiled spatial law, stepped by whoever flies it."""

    def __init__(self, frame: SpatialFrame, row: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def step(self, time: float, told: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], saturated: Sequence[bool], out: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu')]) -> None:
        """
        One control period. told: vehicles (3n) | velocities (3n) | payload (13). out: forces (3n) | before limits (3n) | swing (n) | whether cut (n).
        """

    def target(self, time: float, out: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu')]) -> None:
        """
        out: vehicles (3n) | velocities (3n) | payload, velocity, acceleration (9) | yaw, its rate.
        """

    def follow(self, frame: SpatialFrame, row: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None:
        """Flies to the targets of another row."""

    def set_points(self, force: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], yaw: float, hover_force: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], hover_thrust: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], out: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu')]) -> None:
        """out: attitudes (4n) | normalised thrusts (n)."""

    @property
    def hover_force(self) -> list[float]:
        """Weight of each vehicle and its share of the load, N."""

    @property
    def drag_estimate(self) -> list[list[float]]:
        """N s/m, of each vehicle."""

class SpatialWorld:
    """A spatial world, stepped from outside."""

    def step_forces(self, force: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], yaw: float | None, steps: int) -> None:
        """Forces (3n), N, held for integration steps."""

    def step_set_points(self, wanted: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], steps: int) -> None:
        """Of each vehicle an attitude (4) and a thrust."""

    def step_motors(self, part: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], steps: int) -> None:
        """Of each vehicle four parts of the greatest rotor speed."""

    def fail(self, what: str, vehicle: int, rotor: int) -> None:
        """Something breaks."""

    def show(self, numbers: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu')], flags: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C', device='cpu')]) -> None:
        """Fills the arrays with the present state."""

    def incidents(self, first: int) -> list[tuple[float, str, int]]:
        """Time, what and whose, from the given one on."""

    @property
    def status(self) -> str: ...

def spatial_world(frame: SpatialFrame, row: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], seed: int) -> SpatialWorld:
    """A world at its start."""

def spatial_gradient(frame: SpatialFrame, row: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], seed: int, tangents: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> dict:
    """
    A run's final state, metrics and audit, and row by row their derivatives along each row of tangents. Releases the GIL.
    """

def planar_operations(law: str, row: Sequence[float], step: float, steps: int, control_steps: int) -> dict:
    """
    Operations of one run, by kind: add, multiply, divide, root, and other ones on numbers.
    """
