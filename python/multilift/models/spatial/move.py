"""The spatial plant's equations for optimal control, on taut rigid cables and with ideal forces.

Stated apart from the core, from ``docs/theory-spatial``, in free coordinates, and implicitly: what
is zero where accelerations fit. Coordinates: the payload's position; its heading, pitch and roll
where it has an inertia; and of each cable the two angles of its direction, from the payload up to
the vehicle, (sin a, sin b cos a, cos b cos a).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from multilift.errors import ScenarioError
from multilift.limit.bounds import Limits
from multilift.limit.errors import casadi
from multilift.limit.move import Instant, Move, Vector, time_guess
from multilift.models.spatial.run import SpatialRun, rotation_matrices
from multilift.models.spatial.scenario import SpatialScenario

#: Ends nearer than this are one place, m and rad.
LEAST_MOVE = 1e-6
#: A tilt from which on it is no limit, rad.
LEVEL = np.pi / 2 - 1e-9
#: What a taut cable keeps of its tension at rest at least: the search may graze a limit, and a
#: cable that goes slack is another plant.
STILL_TAUT = 1e-3


def equations(plant: dict[str, Any], q: Any, q_dot: Any, q_ddot: Any, force: Any) -> dict[str, Any]:
    """Residuals of the equations of motion, and what goes with them.

    Args:
        plant: normalised ``[plant]`` table, of n vehicles.
        q: coordinates as above, m and rad, shape (3 + 3 + 2n,), or (3 + 2n,) of a point mass.
        q_dot: their rates.
        q_ddot: their second rates.
        force: of the vehicles' rotors, N, shape (3n,).

    Returns:
        ``residual`` as long as q, ``tension`` (n,), N, and lists of the vehicles' ``velocity``,
        m/s, and the cables' ``direction``, each (3,).
    """
    ca = casadi()
    n, g = plant["vehicles"], plant["gravity"]
    turned, omega, omega_dot, first = _attitude(plant, q, q_dot, q_ddot)
    residual, moments, tension, velocity, direction = [], [], [], [], []
    pull = ca.DM.zeros(3)
    for i in range(n):
        arm = ca.DM(plant["attachment"][i])
        k = first + 2 * i
        d, along_a, along_b, bend = _cable(ca, q[k : k + 2], q_dot[k : k + 2])
        d_dot = along_a * q_dot[k] + along_b * q_dot[k + 1]
        d_ddot = along_a * q_ddot[k] + along_b * q_ddot[k + 1] + bend
        length = plant["cable_length"][i]
        v = q_dot[:3] + turned @ ca.cross(omega, arm) + length * d_dot
        acceleration = (
            q_ddot[:3]
            + turned @ (ca.cross(omega_dot, arm) + ca.cross(omega, ca.cross(omega, arm)))
            + length * d_ddot
        )
        mass = plant["vehicle_mass"][i]
        left = (
            force[3 * i : 3 * i + 3]
            - ca.DM(plant["vehicle_drag"][i]) * v
            - mass * (acceleration + ca.DM([0.0, 0.0, g]))
        )
        tension.append(ca.dot(d, left))
        residual += [ca.dot(along_a, left), ca.dot(along_b, left)]
        pull = pull + tension[i] * d
        moments.append(tension[i] * ca.cross(arm, turned.T @ d))
        velocity.append(v)
        direction.append(d)
    speed = ca.sqrt(ca.sumsqr(q_dot[:3]) + 1e-12)
    drag = ca.DM(plant["payload_drag"]) * q_dot[:3]
    drag = drag + plant["payload_drag_quadratic"] * speed * q_dot[:3]
    payload = [pull - drag - plant["payload_mass"] * (q_ddot[:3] + ca.DM([0.0, 0.0, g]))]
    if first == 6:
        inertia = ca.DM(plant["payload_inertia"])
        spin = ca.DM(plant["payload_spin_damping"]) * omega
        moment = sum(moments) - spin - inertia * omega_dot - ca.cross(omega, inertia * omega)
        payload.append(moment / ca.DM(_effective_inertia(plant)))
    return {
        "residual": ca.vertcat(*payload, *residual),
        "tension": ca.vertcat(*tension),
        "velocity": velocity,
        "direction": direction,
    }


def _effective_inertia(plant: dict[str, Any]) -> Vector:
    """What turns with the payload about its axes, kg m^2: scales of three equations."""
    arms = np.array(plant["attachment"]) ** 2
    across = arms.sum(axis=1, keepdims=True) - arms
    masses = np.array(plant["vehicle_mass"])
    inertia: Vector = np.array(plant["payload_inertia"]) + masses @ across
    return inertia


def has_attitude(plant: dict[str, Any]) -> bool:
    """Whether the payload is a body that turns, no point mass."""
    return any(x > 0 for x in plant["payload_inertia"])


def _attitude(plant: dict[str, Any], q: Any, q_dot: Any, q_ddot: Any) -> tuple[Any, Any, Any, int]:
    """Turn to the world, rate and its rate in the payload's frame, and where cables begin in q."""
    ca = casadi()
    if not has_attitude(plant):
        return ca.DM.eye(3), ca.DM.zeros(3), ca.DM.zeros(3), 3
    (yaw, pitch, roll), (yr, pr, rr), (ya, pa, ra) = (
        (x[3], x[4], x[5]) for x in (q, q_dot, q_ddot)
    )
    sp, cp, sr, cr = ca.sin(pitch), ca.cos(pitch), ca.sin(roll), ca.cos(roll)
    sy, cy = ca.sin(yaw), ca.cos(yaw)
    turned = ca.vertcat(
        ca.horzcat(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        ca.horzcat(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        ca.horzcat(-sp, cp * sr, cp * cr),
    )
    omega = ca.vertcat(rr - yr * sp, pr * cr + yr * cp * sr, -pr * sr + yr * cp * cr)
    omega_dot = ca.vertcat(
        ra - ya * sp - yr * pr * cp,
        pa * cr - pr * rr * sr + ya * cp * sr - yr * pr * sp * sr + yr * rr * cp * cr,
        -pa * sr - pr * rr * cr + ya * cp * cr - yr * pr * sp * cr - yr * rr * cp * sr,
    )
    return turned, omega, omega_dot, 6


def _cable(ca: Any, angles: Any, rates: Any) -> tuple[Any, Any, Any, Any]:
    """A cable's direction, its derivatives along both angles, and what their rates bend it by."""
    a, b = angles[0], angles[1]
    sa, cosa, sb, cosb = ca.sin(a), ca.cos(a), ca.sin(b), ca.cos(b)
    d = ca.vertcat(sa, sb * cosa, cosb * cosa)
    bend = (
        -(rates[0] ** 2) * d
        + 2.0 * rates[0] * rates[1] * ca.vertcat(0.0, -cosb * sa, sb * sa)
        + rates[1] ** 2 * ca.vertcat(0.0, -sb * cosa, -cosb * cosa)
    )
    return (
        d,
        ca.vertcat(cosa, -sb * sa, -cosb * sa),
        ca.vertcat(0.0, cosb * cosa, -sb * cosa),
        bend,
    )


def move(scenario: SpatialScenario, limits: Limits) -> Move:
    """From a scenario's start to its goal, at rest at both, within the limits.

    Args:
        scenario: its plant, start, goal and limits of the forces.
        limits: what else the move may not exceed, with its ``force``.

    Raises:
        ScenarioError: where start and goal are one, the start is not at rest, or cables are
            elastic.
        LimitError: where the limits do not let the vehicles hold the load at rest.
        MissingExtraError: without CasADi.
    """
    ca = casadi()
    _check(scenario)
    plant, given = scenario.values["plant"], scenario.values["limits"]
    n = scenario.count
    holding = scenario.rest.cable_force[0]
    rest = holding / np.linalg.norm(holding, axis=1)[:, None]
    yaws = _headings(scenario)
    ends = [
        _coordinates(plant, place, yaw, rest)
        for place, yaw in zip(
            (scenario.payload_start[:3], np.array(scenario["goal.payload_position"])),
            yaws,
            strict=True,
        )
    ]
    if np.abs(ends[1] - ends[0]).max() < LEAST_MOVE:
        raise ScenarioError(
            "is the start: there is no move to bound", where=scenario.where,
            key="goal.payload_position", value=scenario["goal.payload_position"],
            advice="give another goal, such as --set 'goal.payload_position=[1.0, 0.0, 1.5]'",
        )  # fmt: skip
    weight = np.zeros((n, 3))
    weight[:, 2] = np.array(plant["vehicle_mass"]) * plant["gravity"]
    held = [(weight + holding @ _about_z(yaw).T).ravel() for yaw in yaws]
    least = np.maximum(limits.tension, STILL_TAUT * np.linalg.norm(holding, axis=1))
    chord = (2.0 * np.sin(0.5 * limits.swing)) ** 2
    most, fewest, tilt = (np.array(given[k]) for k in ("thrust_max", "thrust_min", "tilt_max"))
    size = held[0].reshape(n, 3)[:, 2]

    def equations_with_limits(q: Any, q_dot: Any, q_ddot: Any, force: Any) -> Instant:
        found = equations(plant, q, q_dot, q_ddot, force)
        heading = q[3] if has_attitude(plant) else yaws[1]
        ahead, across = ca.cos(heading), ca.sin(heading)
        swing = [
            d - ca.vertcat(ahead * r[0] - across * r[1], across * r[0] + ahead * r[1], r[2])
            for d, r in zip(found["direction"], rest, strict=True)
        ]
        kept = [found["tension"], *(ca.sumsqr(s) for s in swing)]
        if np.isfinite(limits.speed):
            kept += [ca.sumsqr(v) / limits.speed**2 for v in found["velocity"]]
        for i in range(n):
            f = force[3 * i : 3 * i + 3]
            if np.isfinite(most[i]):
                kept.append(ca.sumsqr(f) / most[i] ** 2)
            if fewest[i] > 0:
                kept.append(ca.sumsqr(f) / fewest[i] ** 2)
            if tilt[i] < LEVEL:
                level = ca.sumsqr(f[:2]) - (np.tan(tilt[i]) * f[2]) ** 2
                kept.append(level / size[i] ** 2)
        return Instant(found["residual"], ca.vertcat(*kept), ca.vertcat(*swing))

    bounds = [(x, np.inf, f"tension of cable {i + 1}") for i, x in enumerate(least)]
    bounds += [(-np.inf, chord, f"swing of cable {i + 1}") for i in range(n)]
    if np.isfinite(limits.speed):
        bounds += [(-np.inf, 1.0, f"speed of vehicle {i + 1}") for i in range(n)]
    for i in range(n):
        if np.isfinite(most[i]):
            bounds.append((-np.inf, 1.0, f"greatest thrust of vehicle {i + 1}"))
        if fewest[i] > 0:
            bounds.append((1.0, np.inf, f"least thrust of vehicle {i + 1}"))
        if tilt[i] < LEVEL:
            bounds.append((-np.inf, 0.0, f"tilt of vehicle {i + 1}"))
    force = np.tile(limits.force or (np.inf,) * 3, n)
    upwards = np.tile([False, False, True], n)
    made = Move(
        equations=equations_with_limits,
        start=ends[0],
        goal=ends[1],
        input_start=held[0],
        input_goal=held[1],
        input_scale=np.minimum(force, np.repeat(size, 3)),
        # A rotor only pulls up its vehicle: without a limit of tilt, too.
        input_lower=np.where(upwards, np.maximum(held[1] - force, 0.0), held[1] - force),
        input_upper=held[1] + force,
        lower=np.array([b[0] for b in bounds]),
        upper=np.array([b[1] for b in bounds]),
        limit_names=tuple(b[2] for b in bounds),
        time_guess=time_guess(plant, ends[1][:3] - ends[0][:3]),
    )
    made.check_rest(scenario.where)
    return made


def arrival(run: SpatialRun, row: int) -> dict[str, float]:
    """See `multilift.models.Model.arrival`."""
    scenario = run.scenario
    turn = _about_z(float(scenario["goal.payload_yaw"]))
    wanted = np.array(scenario["goal.payload_position"]) + scenario.rest.offset[0] @ turn.T
    places, speeds, directions = [], [], []
    attitude = rotation_matrices(run.attitude("payload")[row : row + 1])[0]
    payload = run.vector("payload")[row]
    for i in range(scenario.count):
        places.append(run.vector(f"vehicle{i + 1}")[row])
        speeds.append(run.vector(f"vehicle{i + 1}_v")[row])
        along = places[i] - payload - attitude @ np.array(scenario["plant.attachment"][i])
        directions.append(along / np.linalg.norm(along))
    rest = scenario.rest.cable_force[0] @ turn.T
    rest /= np.linalg.norm(rest, axis=1)[:, None]
    chord = np.linalg.norm(np.array(directions) - rest, axis=1).max()
    return {
        "position": float(np.linalg.norm(np.array(places) - wanted, axis=1).max()),
        "speed": float(np.linalg.norm(speeds, axis=1).max()),
        "swing": float(np.degrees(2.0 * np.arcsin(min(1.0, 0.5 * chord)))),
    }


def command_peaks(run: SpatialRun) -> tuple[float, ...]:
    """See `multilift.models.Model.command_peaks`."""
    plant, rest = run.scenario.values["plant"], run.scenario.rest.cable_force[0]
    yaw = run["target_yaw"]
    peaks = np.zeros(3)
    for i in range(run.scenario.count):
        held = np.einsum("tij,j->ti", np.array([_about_z(y) for y in yaw]), rest[i])
        held[:, 2] += plant["vehicle_mass"][i] * plant["gravity"]
        peaks = np.maximum(peaks, np.abs(run.vector(f"force{i + 1}") - held).max(axis=0))
    return tuple(float(x) for x in peaks)


def _check(scenario: SpatialScenario) -> None:
    if scenario["plant.cables"] != "rigid":
        raise ScenarioError(
            "stretches: a bound is of rigid cables", where=scenario.where, key="plant.cables",
            value=scenario["plant.cables"], advice="--set plant.cables=rigid",
        )  # fmt: skip
    at_rest = (
        scenario.payload_start[:3]
        + scenario.rest.offset[0] @ _about_z(float(scenario["start.payload_yaw"])).T
    )
    if np.abs(scenario.vehicle_start[:, :3] - at_rest).max() > 1e-3:
        raise ScenarioError(
            "is not where the formation rests: a bound begins at rest", where=scenario.where,
            key="start.vehicle_position", advice="leave it out",
        )  # fmt: skip
    if max(np.abs(scenario.payload_start[7:]).max(), np.abs(scenario.vehicle_start[:, 3:]).max()):
        raise ScenarioError(
            "moves: a bound begins at rest", where=scenario.where, key="start.payload_velocity",
            advice="leave the start's velocities and rates out",
        )  # fmt: skip


def _headings(scenario: SpatialScenario) -> tuple[float, float]:
    """The heading at the start, and at the goal by the shorter turn, rad."""
    begin, end = float(scenario["start.payload_yaw"]), float(scenario["goal.payload_yaw"])
    turn = (end - begin + np.pi) % (2.0 * np.pi) - np.pi
    return begin, begin + turn


def _coordinates(plant: dict[str, Any], place: Vector, yaw: float, rest: Vector) -> Vector:
    """Free coordinates of the load at rest, level, with cables along their rest directions."""
    angles = []
    for x, y, z in rest @ _about_z(yaw).T:
        angles += [np.arcsin(x), np.arctan2(y, z)]
    attitude = [yaw, 0.0, 0.0] if has_attitude(plant) else []
    return np.array([*place, *attitude, *angles])


def _about_z(yaw: float) -> Vector:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
