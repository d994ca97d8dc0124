"""An adaptive reference of high order that rollouts are checked against.

It shares the control law with a rollout and nothing else: the redundant equations (7)-(16) in the
seven coordinates instead of the fast formulation, and Dormand and Prince's method of order 8(5,3)
with error control instead of fixed Runge-Kutta steps, started afresh wherever the forces jump.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from multilift import _core, controllers
from multilift.errors import MissingExtraError, MultiliftError, ScenarioError
from multilift.models.planar import laws
from multilift.models.planar.geometry import Vector
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.scenario import Scenario

#: Where in the seven loads beside u a push acts: vehicles (y, z) first, then the bar.
_PLACES = {"vehicle_1": 0, "vehicle_2": 2, "bar": 4}
_TORQUE = 6

#: Times closer than this are one, s.
_SAME_TIME = 1e-12


@dataclass(frozen=True)
class ReferenceRun:
    """What the reference found at the control instants.

    Attributes:
        t: the control instants, shape (n,), s.
        q: coordinates y1, z1, y2, z2 (m), theta1..3 (rad), shape (n, 7).
        q_dot: their rates, shape (n, 7).
        u: commands given at each instant and held until the next, shape (n, 4), N. They become
            thrust with the masses that the law assumes.
        d_hat: drag estimates those commands used, shape (n, 4), N s/m; NaN under a Python law.
        closure_drift: largest distance by which q misses the bar's geometry, m. Nothing pulls q
            back there, so it measures what the integration lost.
    """

    t: Vector
    q: Vector
    q_dot: Vector
    u: Vector
    d_hat: Vector
    closure_drift: float


def solve(
    scenario: Scenario, controller: Any = None, *, rtol: float = 1e-12, atol: float = 1e-12
) -> ReferenceRun:
    """Integrates a scenario to its last control instant under error control.

    The cables are taken as taut throughout: a run that ends early has no counterpart here.

    Args:
        scenario: what to integrate; ideal actuators and sensors only.
        controller: as for :func:`multilift.simulate`.
        rtol: permitted local error, relative to each coordinate and rate.
        atol: the same, absolute, m, rad and per second.

    Raises:
        MissingExtraError: without SciPy (``multilift[reference]``).
        ScenarioError: if the scenario is not planar, or actuators or sensors are not ideal.
        ControllerError: for a law that cannot be found or stepped.
        MultiliftError: where the equations are singular or the error cannot be kept small.
    """
    try:
        from scipy.integrate import DOP853  # noqa: PLC0415 - an optional package
    except ImportError:
        raise MissingExtraError("scipy", "reference", "the adaptive reference") from None
    scenario = planar_only(scenario, "the adaptive reference")
    if not scenario.is_ideal():
        raise ScenarioError(
            "cannot be integrated by the reference: actuators or sensors are not ideal",
            where=scenario.where,
            advice="leave out [actuators] and [sensors]",
        )
    if scenario.moves_target():
        raise ScenarioError(
            "is not what the adaptive reference knows: its target rests",
            where=scenario.where,
            key="reference.kind",
            value=scenario["reference.kind"],
            permitted="step",
        )
    step_law, scenario = _stepper(controller, scenario)
    plant, pushes = scenario.plant_values(), scenario.values["push"]
    surplus = _shares(scenario.controller.assumed) - _shares(scenario["plant"])
    corners = _corners(pushes)
    period = scenario.control_period()
    count = int(scenario["simulation.duration"] / period + 1e-6) + 1

    t = np.arange(count, dtype=np.float64) * period
    x, u, d_hat = np.empty((count, 14)), np.empty((count, 4)), np.empty((count, 4))
    x[0] = _start(scenario)
    for k in range(count):
        u[k], d_hat[k] = step_law(t[k], x[k])
        if k + 1 == count:
            break
        inside = corners[(corners > t[k] + _SAME_TIME) & (corners < t[k + 1] - _SAME_TIME)]
        x[k + 1] = x[k]
        for begin, end in pairwise([t[k], *inside, t[k + 1]]):
            rate = _rate(plant, u[k] + surplus, _acting(pushes, 0.5 * (begin + end)))
            solver = DOP853(
                rate, begin, x[k + 1], end, first_step=end - begin, rtol=rtol, atol=atol
            )
            x[k + 1] = _finish(solver)
    drift = [math.hypot(*_core.planar_closure(plant, q)) for q in x[:, :7].tolist()]
    return ReferenceRun(t, x[:, :7], x[:, 7:], u, d_hat, max(drift))


def _shares(plant: dict[str, Any]) -> Vector:
    """(m_i + m3/2) g along z of both vehicles, in the places of u1..u4, N."""
    mass = np.array(plant["vehicle_mass"]) + 0.5 * plant["bar_mass"]
    return np.kron(mass * plant["gravity"], [0.0, 1.0])


def _rate(
    plant: list[float], u: Vector, acting: list[dict[str, Any]]
) -> Callable[[float, Vector], Vector]:
    """The rate of x = [q, q_dot] while u is held and these pushes act."""

    def rate(t: float, x: Vector) -> Vector:
        loads = [*u.tolist(), *_push_loads(acting, t).tolist()]
        motion = _core.planar_redundant_motion(plant, x[:7].tolist(), x[7:].tolist(), loads)
        if not motion["regular"]:
            raise MultiliftError(
                f"the reference met a singular state at t = {t:g} s: both cables point at the "
                "bar's centre of mass\n  what to do: give the bar inertia"
            )
        return np.concatenate([x[7:], motion["q_ddot"]])

    return rate


def _finish(solver: Any) -> Vector:
    """The state at the end of a solver's interval."""
    while solver.status == "running":
        message = solver.step()
    if solver.status == "failed":
        raise MultiliftError(
            f"the reference cannot go on at t = {solver.t:g} s: {message}\n"
            "  what to do: raise rtol or atol"
        )
    final: Vector = solver.y
    return final


def _start(scenario: PlanarScenario) -> Vector:
    """[q, q_dot] at the start, moved onto the closure that a scenario may miss by a little."""
    plant = scenario.plant_values()
    free = _core.planar_free_coordinates(
        plant, scenario.q_start.tolist(), scenario.q_dot_start.tolist()
    )
    return np.concatenate(_core.planar_seven(plant, free[0:2], free[2:5], free[5:7], free[7:10]))


def _stepper(
    controller: Any, given: Scenario
) -> tuple[Callable[[float, Vector], tuple[Vector, Vector]], PlanarScenario]:
    """The law as a function of t and [q, q_dot] that gives u and the estimates behind it."""
    law, resolved = controllers.resolve(controller, given)
    scenario = planar_only(resolved, "the adaptive reference")
    if isinstance(law, controllers.PythonLaw):
        callback = laws.callback(law, scenario)

        def step_python(t: float, x: Vector) -> tuple[Vector, Vector]:
            u = callback(t, x[:7].tolist(), x[7:].tolist(), (False, False))
            return np.array(u), np.full(4, np.nan)

        return step_python, scenario
    compiled = _core.PlanarLaw(
        law.name,
        scenario.gain_values(),
        scenario.assumed_values(),
        scenario.goal_vector().tolist(),
        scenario.control_period(),
    )

    def step_compiled(_: float, x: Vector) -> tuple[Vector, Vector]:
        d_hat = np.array(compiled.d_hat)
        return np.array(compiled.step(x[:7].tolist(), x[7:].tolist())), d_hat

    return step_compiled, scenario


def _span(push: dict[str, Any]) -> tuple[float, float]:
    """From when to when a push acts, s; one given by samples ends with the last of them."""
    first, last = 0.0, push["duration"]
    if push["shape"] == "samples":
        first = max(first, push["sample_times"][0])
        last = min(last, push["sample_times"][-1])
    return push["start"] + first, push["start"] + last


def _acting(pushes: list[dict[str, Any]], t: float) -> list[dict[str, Any]]:
    return [push for push in pushes if _span(push)[0] <= t < _span(push)[1]]


def _corners(pushes: list[dict[str, Any]]) -> Vector:
    """Every time at which some push is not smooth, ascending, s."""
    times: list[float] = []
    for push in pushes:
        times += [*_span(push), *(push["start"] + t for t in push["sample_times"] or [])]
    distinct = np.unique(times)
    far_apart = np.diff(distinct, prepend=-np.inf) > _SAME_TIME
    return distinct[far_apart]


def _height(push: dict[str, Any], t: float) -> float:
    """The profile of a push at a time t within its span."""
    since = t - push["start"]
    match push["shape"]:
        case "pulse":
            return 1.0
        case "half_sine":
            return float(np.sin(np.pi * since / push["duration"]))
        case "sine":
            return float(np.sin(2 * np.pi * push["frequency"] * since))
        case _:
            return float(np.interp(since, push["sample_times"], push["sample_values"]))


def _push_loads(acting: list[dict[str, Any]], t: float) -> Vector:
    """Forces on vehicles 1 and 2 and the bar (y, z each), N, and the bar's torque, N m."""
    loads = np.zeros(7)
    for push in acting:
        place = _PLACES[push["body"]]
        height = _height(push, t)
        loads[place : place + 2] += height * np.array(push["force"])
        loads[_TORQUE] += height * push["torque"]
    return loads
