"""The planar plant's equations for optimal control: {eq}`eq-t6` to {eq}`eq-t10` once more.

Stated apart from the core, from ``docs/theory``, in the five free coordinates (y_p, z_p, theta1,
theta2, theta3), and implicitly: what is zero where accelerations fit, so that nothing is inverted.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from multilift import _core
from multilift.errors import ScenarioError
from multilift.limit.bounds import Limits
from multilift.limit.errors import casadi
from multilift.limit.move import Instant, Move, Vector, time_guess
from multilift.models.planar import geometry
from multilift.models.planar.run import PlanarRun
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.simulate import simulate

#: Ends nearer than this are one place, m and rad.
LEAST_MOVE = 1e-6
#: A tilt from which on it is no limit, rad.
LEVEL = np.pi / 2 - 1e-9


def equations(plant: dict[str, Any], q: Any, q_dot: Any, q_ddot: Any, u: Any) -> dict[str, Any]:
    """Residuals of the five equations of motion, and what goes with them.

    Args:
        plant: normalised ``[plant]`` table.
        q: y_p, z_p, theta1..3, m and rad.
        q_dot: their rates.
        q_ddot: their second rates.
        u: u1..u4, N.

    Returns:
        ``residual`` (5,), ``tension`` (2,), N, ``velocity`` of the vehicles, a list of two (2,),
        m/s.
    """
    ca = casadi()
    m = plant["vehicle_mass"]
    m3, g, l0, l3 = (plant[k] for k in ("bar_mass", "gravity", "bar_length", "bar_half_thickness"))
    centre, turn, turning = q_ddot[:2], q_dot[4], q_ddot[4]
    along = ca.vertcat(ca.cos(q[4]), ca.sin(q[4]))
    up = ca.vertcat(-ca.sin(q[4]), ca.cos(q[4]))
    pull = ca.DM([0.0, 0.0])
    moment = -plant["swing_damping"][2] * turn - plant["bar_inertia"] * turning
    residual, tension, velocity = [], [], []
    for i, side in enumerate((-1.0, 1.0)):
        length, theta, rate, rate_dot = (
            plant["cable_length"][i], q[2 + i], q_dot[2 + i], q_ddot[2 + i],
        )  # fmt: skip
        sine, cosine = ca.sin(theta), ca.cos(theta)
        d = ca.vertcat(side * sine, cosine)
        t = ca.vertcat(-side * cosine, sine)
        a = 0.5 * side * l0 * along + l3 * up
        a_perp = ca.vertcat(-a[1], a[0])
        velocity.append(q_dot[:2] + turn * a_perp - length * rate * t)
        acceleration = (
            centre + turning * a_perp - turn**2 * a - length * (rate_dot * t + rate**2 * d)
        )
        c = -plant["swing_damping"][i] * rate / length * t
        drag = ca.DM(plant["vehicle_drag"][i]) * velocity[i]
        n = u[2 * i : 2 * i + 2] + ca.DM([0.0, 0.5 * m3 * g]) - drag - c
        left = n - m[i] * acceleration
        tension.append(ca.dot(d, left))
        residual.append(ca.dot(t, left))
        on_bar = tension[i] * d + c
        pull = pull + on_bar
        moment = moment + a[0] * on_bar[1] - a[1] * on_bar[0]
    bar = pull - m3 * (centre + ca.DM([0.0, g]))
    return {
        "residual": ca.vertcat(bar, moment, *residual),
        "tension": ca.vertcat(*tension),
        "velocity": velocity,
    }


def move(scenario: PlanarScenario, limits: Limits) -> Move:
    """From a scenario's start to rest at its goal, within the limits.

    Args:
        scenario: its plant, start, goal and actuators' limits.
        limits: what else the move may not exceed; ``force`` given where the scenario limits none.

    Raises:
        ScenarioError: where start and goal are one, nothing can hang at rest at one of them, or
            the limits do not let the vehicles hold it there.
        MissingExtraError: without CasADi.
    """
    ca = casadi()
    plant, actuators = scenario.values["plant"], scenario.values["actuators"]
    shares = np.array([(m + 0.5 * plant["bar_mass"]) * plant["gravity"]
                       for m in plant["vehicle_mass"]])  # fmt: skip
    begin = np.array(
        _core.planar_free_coordinates(
            scenario.plant_values(), scenario.q_start.tolist(), scenario.q_dot_start.tolist()
        )
    )
    ends = [
        (begin[:5], _holding(plant, begin[:5])),
        _rest(scenario, "goal.vehicle_position", scenario.goal_vector()),
    ]
    if max(np.abs(ends[1][0] - begin[:5]).max(), np.abs(begin[5:]).max()) < LEAST_MOVE:
        raise ScenarioError(
            "is the start: there is no move to bound",
            where=scenario.where,
            key="goal.vehicle_position",
            value=scenario.goal_vector().tolist(),
            advice="give another goal, such as --set "
            "'goal.vehicle_position=[[1.0, 2.0], [2.5, 2.0]]'"
            + (", or --push 1 for the way back from a push" if scenario["push"] else ""),
        )
    swing, speed = limits.swing, limits.speed
    thrust_max, thrust_min = actuators["thrust_max"], actuators["thrust_min"]
    slope = np.tan(actuators["tilt_max"]) if actuators["tilt_max"] < LEVEL else np.inf

    def equations_with_limits(q: Any, q_dot: Any, q_ddot: Any, u: Any) -> Instant:
        found = equations(plant, q, q_dot, q_ddot, u)
        kept = [q[2:], found["tension"]]
        if np.isfinite(speed):
            kept += [ca.sumsqr(v) / speed**2 for v in found["velocity"]]
        for i in range(2):
            side, up = u[2 * i], u[2 * i + 1] + shares[i]
            if np.isfinite(thrust_max):
                kept.append((side**2 + up**2) / thrust_max**2)
            if thrust_min > 0:
                kept.append((side**2 + up**2) / thrust_min**2)
            if np.isfinite(slope):
                kept += [(slope * up - side) / shares[i], (slope * up + side) / shares[i]]
        return Instant(found["residual"], ca.vertcat(*kept), q[2:])

    bounds = [(-swing, swing, f"swing of theta{k + 1}") for k in range(3)]
    bounds += [(limits.tension, np.inf, f"tension of cable {i + 1}") for i in range(2)]
    if np.isfinite(speed):
        bounds += [(-np.inf, 1.0, f"speed of vehicle {i + 1}") for i in range(2)]
    for i in range(2):
        if np.isfinite(thrust_max):
            bounds.append((-np.inf, 1.0, f"greatest thrust of vehicle {i + 1}"))
        if thrust_min > 0:
            bounds.append((1.0, np.inf, f"least thrust of vehicle {i + 1}"))
        if np.isfinite(slope):
            bounds += [(0.0, np.inf, f"tilt of vehicle {i + 1}")] * 2
    force = np.tile(limits.force if limits.force else (np.inf, np.inf), 2)
    upwards = np.array([False, True, False, True])
    shares_of_u = np.array([0.0, shares[0], 0.0, shares[1]])
    # A rotor only pulls up its vehicle: without a limit of tilt, too.
    lower = np.where(upwards, np.maximum(-force, -shares_of_u), -force)
    scale = np.minimum(np.where(np.isfinite(force), force, np.inf),
                       np.minimum(thrust_max, np.repeat(shares, 2)))  # fmt: skip
    made = Move(
        equations=equations_with_limits,
        start=begin[:5],
        start_rate=begin[5:],
        goal=ends[1][0],
        input_start=ends[0][1],
        input_goal=ends[1][1],
        input_scale=scale,
        input_lower=lower,
        input_upper=force,
        lower=np.array([b[0] for b in bounds]),
        upper=np.array([b[1] for b in bounds]),
        limit_names=tuple(b[2] for b in bounds),
        time_guess=time_guess(plant, ends[1][0][:2] - ends[0][0][:2]),
    )
    made.check_rest(scenario.where)
    return made


def after_push(scenario: PlanarScenario, number: int) -> PlanarScenario:
    """The scenario from the moment at which a push is over, its vehicles having hovered.

    Args:
        scenario: with pushes, that starts at rest.
        number: of the push, counted from 1.

    Raises:
        ScenarioError: if there is no such push.
    """
    pushes = scenario.values["push"]
    if not 1 <= number <= len(pushes):
        raise ScenarioError(
            "is no push of this scenario", where=scenario.where, key="--push", value=number,
            permitted=f"1 to {len(pushes)}" if pushes else "none: it has no [[push]]",
        )  # fmt: skip
    push = {k: v for k, v in scenario.raw()["push"][number - 1].items() if k != "start"}
    run = simulate(
        scenario.with_values(
            {
                "actuators": {},
                "sensors": {},
                "push": [{**push, "start": 0.0}],
                "simulation.duration": pushes[number - 1]["duration"],
            }
        ),
        lambda _: (0.0, 0.0, 0.0, 0.0),
    )
    names = ("y1", "z1", "y2", "z2")
    angles = ("theta1", "theta2", "theta3")
    state = {
        "start.vehicle_position": np.reshape([run[k][-1] for k in names], (2, 2)),
        "start.angle": np.array([run[k][-1] for k in angles]),
        "start.vehicle_velocity": np.reshape([run[f"{k}_dot"][-1] for k in names], (2, 2)),
        "start.angle_rate": np.array([run[f"{k}_dot"][-1] for k in angles]),
    }
    return planar_only(scenario.with_values({**state, "push": []}), "--push")


def _rest(scenario: PlanarScenario, key: str, vehicles: Vector) -> tuple[Vector, Vector]:
    """Free coordinates (5,) and u (4,) at which all hangs at rest below vehicles, m, rad, N."""
    plant = scenario.plant_values()
    try:
        angles = geometry.rest_angles(plant, vehicles)
    except ValueError as error:
        raise ScenarioError(
            f"leaves no rest there: {error}", where=scenario.where, key=key,
            value=vehicles.tolist(), advice="let them stand as far apart as the bar is long",
        ) from None  # fmt: skip
    free = np.array(_core.planar_free_coordinates(plant, [*vehicles, *angles], [0.0] * 7)[:5])
    return free, _holding(scenario.values["plant"], free)


def _holding(plant: dict[str, Any], q: Vector) -> Vector:
    """The inputs u that hold q at rest, N, shape (4,)."""
    ca = casadi()
    u = ca.SX.sym("u", 4)
    zero = np.zeros(5)
    residual = equations(plant, ca.SX(q), ca.SX(zero), ca.SX(zero), u)["residual"]
    linear = ca.Function("linear", [u], [ca.jacobian(residual, u), residual])
    matrix, offset = (np.array(x) for x in linear(np.zeros(4)))
    return np.asarray(np.linalg.lstsq(matrix, -offset.ravel(), rcond=None)[0])


def arrival(run: PlanarRun, row: int) -> dict[str, float]:
    """See `multilift.models.Model.arrival`."""
    names = ("y1", "z1", "y2", "z2")
    place = np.array([run[name][row] for name in names]) - run.scenario.goal_vector()
    speed = np.array([run[f"{name}_dot"][row] for name in names])
    return {
        "position": float(np.hypot(place[::2], place[1::2]).max()),
        "speed": float(np.hypot(speed[::2], speed[1::2]).max()),
        "swing": float(np.degrees(max(abs(run[f"theta{k}"][row]) for k in (1, 2, 3)))),
    }
