"""What flights in space cost: n vehicles, a load, and cables that can go slack."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from typing import cast

import numpy as np

from multilift import isa
from multilift.bench import engine
from multilift.bench.free_bodies import free_bodies_start, mujoco_free_bodies
from multilift.bench.ours import many_worlds, one_world
from multilift.bench.rows import Row, ratio, timed
from multilift.models.spatial.scenario import SpatialScenario
from multilift.scenario import Scenario, load
from multilift.simulate import simulate

GOAL_ONE = 15  # times MuJoCo's speed, one world
GOAL_BATCH = 100  # times MuJoCo's speed, many worlds, the widest instruction set
GOAL_QUADROTORS = 25  # the same with quadrotors and motion capture
ROTORTM = 2.5  # times real time, its simulator of two quadrotors with a bar

#: scipy's RK45 at its own tolerances, over 10 ms at a time, steps RotorTM's simulator: m.
_ROTORTM_TOLERANCE = 1e-6


def ring(n: int) -> Scenario:
    """A platform whose weight and radius grow with the n ideal vehicles that carry it a metre on.

    The law is stepped at 1 kHz, as the plant is; of n = 2 the platform is a bar.
    """
    angle = 2 * np.pi * np.arange(n) / n
    radius, mass = 0.25 * n, 0.6 * n
    attachment = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle + 0.05], 1)
    moment = 0.25 * mass * radius**2
    return Scenario(
        {
            "name": f"ring of {n}",
            "plant": {
                "model": "spatial", "vehicles": n, "payload_mass": mass,
                "payload_inertia": [moment, moment, 2 * moment],
                "attachment": attachment.tolist(), "cable_length": 1.2, "vehicle_mass": 1.486,
                "vehicle_drag": 0.1,
            },
            "formation": {"tilt": 0.2},
            "start": {"payload_position": [0.0, 0.0, 1.0]},
            "goal": {"payload_position": [1.0, 0.3, 1.5]},
            "controller": {
                "law": "energy_coupled", "rate": 1000.0, "k_p": [4.5, 4.5, 6.2],
                "k_d": [6.2, 6.2, 8.0], "gamma": 0.5, "k_lambda": 0.15,
            },
            "simulation": {"duration": 15.0, "step": 0.001, "record_period": 15.0},
        }
    )  # fmt: skip


def rotortm_bar() -> Scenario:
    """The bar that RotorTM ships for two quadrotors, a metre on under Lee's law at 100 Hz.

    Masses, inertias, attachments, cables, thrusts are its configuration's. It has neither rotor lag
    nor a torque ratio: these are typical of the size.
    """
    per_rpm = 60 / (2 * np.pi)  # rpm of a rad/s
    return Scenario(
        {
            "name": "RotorTM's bar",
            "plant": {
                "model": "spatial", "vehicles": 2, "payload_mass": 0.104,
                "payload_inertia": [0.004053, 1.3225e-5, 0.004053],
                "attachment": [[0.0, -0.19, 0.0097], [0.0, 0.19, 0.0097]],
                "cable_length": 0.5, "vehicle_mass": 0.25, "gravity": 9.81,
            },
            "vehicle": {
                "kind": "quadrotor", "inertia": [0.000601, 0.000589, 0.001076],
                "arm_length": 0.1075, "frame_angle": "45 deg",
                "thrust_coefficient": 3.9408732e-9 * per_rpm**2,
                "rotor_speed_max": 16400 / per_rpm, "torque_ratio": 0.01,
                "rotor_time_constant": "20 ms", "rotor_drag": 0.0,
            },
            "start": {"payload_position": [0.0, 0.0, 1.0]},
            "goal": {"payload_position": [1.0, 0.0, 1.0]},
            "reference": {"kind": "min_snap", "duration": 3.0},
            "controller": {"law": "geometric", "rate": 100.0},
            "simulation": {"duration": 5.0, "step": 0.001, "record_period": 5.0},
        }
    )  # fmt: skip


def measures(worlds: int) -> dict[str, Callable[[], float] | None]:
    """What to measure in turns: ns a step by key, of batches ns a step of a world.

    Args:
        worlds: in each batch.
    """
    bar, widest = cast("SpatialScenario", ring(2)), isa.available()[0]
    plant = bar.values["plant"]
    force = bar.rest.cable_force[0] + np.outer(plant["vehicle_mass"], [0, 0, plant["gravity"]])
    xml = mujoco_free_bodies(plant, bar["simulation.step"])
    start = free_bodies_start(plant, bar.rest.offset[0], force)
    craft = load("exp1_1_quadrotors").with_values(
        {"simulation.duration": 4.0, "simulation.record_period": 4.0}
    )
    return {
        "space_one": one_world(bar),
        "space_mujoco": engine.one_world(xml, start),
        "space_mujoco_rollout": engine.many_worlds(xml, start),
        **{f"space_{name}": many_worlds(bar, worlds, name) for name in isa.available()},
        "space_quadrotors": many_worlds(craft, worlds, widest),
        "rotortm_bar": one_world(rotortm_bar()),
    }


def rows(found: Mapping[str, Sequence[float]]) -> list[Row]:
    """The rows of what `measures` found."""
    single, theirs = found["space_mujoco"], found["space_mujoco_rollout"]
    widest = isa.available()[0]
    result = [
        timed("space_one", "in space, a bar on two cables that can go slack, RK4, with all of the "
              "above", found["space_one"], "simulate(), ideal vehicles"),
    ]  # fmt: skip
    if single:
        result += [
            timed("space_mujoco", "MuJoCo: the same as free bodies on tendons, 18 dof, RK4", single,
                  "under constant forces: no control, metrics or audit"),
            ratio("space_one_ratio", "ratio", single, found["space_one"], f"goal: {GOAL_ONE}"),
            timed("space_mujoco_rollout", "mujoco.rollout of it on one thread", theirs,
                  "a step of one world"),
        ]  # fmt: skip
    for name in isa.available():
        key, goal = f"space_{name}", f"goal: {GOAL_BATCH}" if name == widest else ""
        result.append(timed(key, f"in space, batch on one thread, {name}", found[key],
                            "a step of one world"))  # fmt: skip
        if theirs:
            result.append(ratio(f"{key}_ratio", f"ratio to mujoco.rollout, {name}", theirs,
                                found[key], goal))  # fmt: skip
    key = "space_quadrotors"
    result.append(timed(key, f"quadrotors, motion capture and link, batch, {widest}", found[key],
                        "exp1_1_quadrotors; a step of one world"))  # fmt: skip
    if theirs:
        result.append(ratio(f"{key}_ratio", "ratio to mujoco.rollout of ideal vehicles", theirs,
                            found[key], f"goal: {GOAL_QUADROTORS}"))  # fmt: skip
    return [*result, *_rotortm(found["rotortm_bar"])]


def _rotortm(times: Sequence[float]) -> list[Row]:
    """How much faster than the clock RotorTM's configuration runs here, and how exactly."""
    bar = rotortm_bar()
    nanoseconds_each = 1e9 * bar["simulation.step"]
    speed = [nanoseconds_each / t for t in times]
    error = _step_error(bar)
    return [
        Row("rotortm_speed", "RotorTM's two quadrotors with a bar, with law, attitude loops, audit",
            statistics.median(speed), max(speed), "x real time",
            f"simulate(); RotorTM in Python, the plant alone: about {ROTORTM}"),
        Row("rotortm_error", "largest error of a position in that flight, from finer steps",
            error, error, "m", f"RotorTM's integrator tolerates {_ROTORTM_TOLERANCE} every 10 ms"),
    ]  # fmt: skip


def _step_error(scenario: Scenario, finer: int = 4) -> float:
    """Largest difference of a coordinate, m, from the same flight with a finer step."""
    step = scenario["simulation.step"]
    coarse, fine = (
        simulate(scenario.with_values({"simulation.step": h, "simulation.record_period": 0.01}))
        for h in (step, step / finer)
    )
    names = [f"{body}_{axis}" for body in ("payload", "vehicle1", "vehicle2") for axis in "xyz"]
    return float(max(np.abs(coarse[k] - fine[k]).max() for k in names))
