"""What a scenario's tables must satisfy together, beyond the range of each key.

Every function raises ScenarioError with file, key, value, permitted range and what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from multilift import _core, geometry, schema
from multilift.errors import ScenarioError

SCHEMA_VERSION = 1

#: Bounds of a single run: days of computing, and gigabytes of rows.
MOST_STEPS = 1e10
MOST_ROWS = 1e7

_TEXTS = ("name", "title", "source", "description")


def normalise(raw: dict[str, Any], where: str) -> dict[str, Any]:
    """Every table complete with defaults, each value in SI; unknown keys refused."""
    known = ("schema", *_TEXTS, *schema.TABLES, "controller", "push")
    for key, value in raw.items():
        if key not in known:
            raise schema.unknown_key(where, key, value, known)
    version = raw.get("schema", SCHEMA_VERSION)
    if version != SCHEMA_VERSION or isinstance(version, bool):
        raise ScenarioError(
            "is not a version this multilift reads",
            where=where,
            key="schema",
            value=raw["schema"],
            permitted=str(SCHEMA_VERSION),
        )
    values: dict[str, Any] = {}
    for key in _TEXTS:
        text = schema.Field(key, "", "text").normalise(raw.get(key, ""), where, key)
        values[key] = text.strip()
    values["name"] = values["name"] or "scenario"
    values["title"] = values["title"] or values["name"]
    for key, table in schema.TABLES.items():
        values[key] = table.normalise(raw.get(key, {}), where)
    values["controller"] = _normalise_controller(raw.get("controller", {}), values["plant"], where)
    values["push"] = _normalise_pushes(raw.get("push", []), where)
    return values


def _normalise_controller(given: Any, plant: dict[str, Any], where: str) -> dict[str, Any]:
    if not isinstance(given, Mapping) or "law" not in given:
        raise ScenarioError(
            "is missing",
            where=where,
            key="controller.law",
            permitted=", ".join(schema.LAW_TITLES),
            advice="add [controller] with law and its gains",
        )
    law = schema.CONTROLLER_COMMON[0].normalise(given["law"], where, "controller.law")
    given = dict(given)
    assumed = given.pop("assumed", {})
    values = schema.controller_table(law).normalise(given, where)
    if not isinstance(assumed, Mapping):
        assumed = {"": assumed}
    values["assumed"] = schema.PLANT.normalise(
        {**plant, **assumed}, where, prefix="controller.assumed"
    )
    return values


def _normalise_pushes(given: Any, where: str) -> list[dict[str, Any]]:
    if not isinstance(given, list):
        raise ScenarioError(
            "is not a list of tables", where=where, key="push", advice="write [[push]]"
        )
    pushes = []
    for k, entry in enumerate(given):
        key = f"push[{k}]"
        push = schema.PUSH.normalise(entry, where, prefix=key)
        if push["torque"] and push["body"] != "bar":
            raise ScenarioError(
                "acts on a point mass", where=where, key=f"{key}.torque", value=push["torque"],
                advice="torques act on the bar only",
            )  # fmt: skip
        if push["shape"] == "sine" and push["frequency"] is None:
            raise ScenarioError(
                "is missing", where=where, key=f"{key}.frequency", permitted="> 0 Hz",
                advice="shape 'sine' needs it",
            )  # fmt: skip
        times, heights = push["sample_times"] or [], push["sample_values"] or []
        if push["shape"] == "samples" and (
            len(times) < 2 or len(times) != len(heights) or (np.diff(times) <= 0).any()
        ):
            raise ScenarioError(
                "does not make a profile",
                where=where,
                key=f"{key}.sample_times",
                value=times,
                permitted="two or more ascending times, as many as sample_values",
            )
        pushes.append(push)
    return pushes


def check_limits(values: dict[str, Any], where: str) -> None:
    """Actuator limits that contradict each other or cannot hold the load."""
    limits = values["actuators"]
    if limits["thrust_min"] >= limits["thrust_max"]:
        raise ScenarioError(
            "is not below thrust_max",
            where=where,
            key="actuators.thrust_min",
            value=limits["thrust_min"],
            permitted=f"< {limits['thrust_max']:g} N",
        )
    if limits["tilt_max"] > np.pi / 2 + 1e-12:
        raise ScenarioError(
            "is more than a quarter turn",
            where=where,
            key="actuators.tilt_max",
            value=limits["tilt_max"],
            permitted="0 < tilt_max <= pi/2 rad",
        )
    share = [
        (m + 0.5 * values["plant"]["bar_mass"]) * values["plant"]["gravity"]
        for m in values["plant"]["vehicle_mass"]
    ]
    if max(share) > limits["thrust_max"]:
        raise ScenarioError(
            "cannot hold a vehicle and its half of the bar",
            where=where,
            key="actuators.thrust_max",
            value=limits["thrust_max"],
            permitted=f">= {max(share):.6g} N",
        )


def check_goal(values: dict[str, Any], where: str) -> None:
    """Goals that break (17) unless asked for, or that no cables reach."""
    goal = np.array(values["goal"]["vehicle_position"])
    along, up = geometry.goal_mismatch(values["plant"], goal)
    if max(abs(along), abs(up)) > 1e-6 and not values["goal"]["allow_mismatch"]:
        raise ScenarioError(
            f"breaks (17): y2 - y1 misses the bar's length by {along:.6g} m, the cables' lower "
            f"ends differ by {up:.6g} m in height",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
            permitted="y2 - y1 = plant.bar_length and z1 - l1 = z2 - l2",
            advice="mend the goal, or set goal.allow_mismatch = true to fly it anyway",
        )
    problem = geometry.linkage_problem(values["plant"], goal)
    if problem:
        raise ScenarioError(
            f"is impossible: {problem}",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
        )


def check_pushes(values: dict[str, Any], where: str) -> None:
    """Pushes that the fixed step would miss or smear."""
    step = float(values["simulation"]["step"])
    for k, push in enumerate(values["push"]):
        on_grid = all(
            abs(x / step - round(x / step)) < 1e-6 * max(1.0, x / step)
            for x in (push["start"], push["duration"])
        )
        if push["duration"] < (1 - 1e-6) * step or (push["shape"] == "pulse" and not on_grid):
            raise ScenarioError(
                "does not fit the integration step",
                where=where,
                key=f"push[{k}].duration",
                value=push["duration"],
                permitted=f"at least one step, {step:g} s; for a pulse, start and duration "
                "multiples of it",
                advice="round them, or give the same impulse over a longer time",
            )


def check_timing(values: dict[str, Any], where: str) -> None:
    """Times that are no whole number of integration steps, delays that are too long; the seed."""
    step = float(values["simulation"]["step"])

    def multiple(key: str, time: float, zero_allowed: bool) -> int:
        ratio = time / step
        if not ratio <= MOST_STEPS:
            raise ScenarioError(
                f"takes {ratio:.3g} integration steps",
                where=where,
                key=key,
                value=time,
                permitted=f"at most {MOST_STEPS:.0g} steps of {step:g} s",
                advice="change it or simulation.step",
            )
        count: int = round(ratio)
        if (count == 0 and not (zero_allowed and time == 0.0)) or abs(ratio - count) > 1e-6 * max(
            1, count
        ):
            raise ScenarioError(
                f"is {ratio:.6g} integration steps, not a whole number",
                where=where,
                key=key,
                value=time,
                permitted=f"multiples of simulation.step = {step:g} s"
                + (", or 0" if zero_allowed else ""),
                advice="change it or simulation.step",
            )
        return count

    steps = multiple("simulation.duration", values["simulation"]["duration"], False)
    record = multiple("simulation.record_period", values["simulation"]["record_period"], False)
    if steps / record > MOST_ROWS:
        raise ScenarioError(
            f"keeps {steps / record:.3g} rows",
            where=where,
            key="simulation.record_period",
            value=values["simulation"]["record_period"],
            permitted=f"at most {MOST_ROWS:.0g} rows",
        )
    control = multiple("1 / controller.rate", 1.0 / values["controller"]["rate"], False)
    delay = multiple("actuators.command_delay", values["actuators"]["command_delay"], True)
    sample = multiple("sensors.period", values["sensors"]["period"], True) or control
    lag = multiple("sensors.delay", values["sensors"]["delay"], True)
    capacity = _core.planar_delay_capacity - 2
    # Commands arrive at every step, measurements are fetched at control instants only.
    for key, steps, wait, every in (
        ("actuators.command_delay", delay, 0, control),
        ("sensors.delay", lag, control, sample),
    ):
        if steps + wait > capacity * every:
            raise ScenarioError(
                "keeps too many values under way",
                where=where,
                key=key,
                value=steps * step,
                permitted=f"at most {(capacity * every - wait) * step:g} s at these rates",
            )
    seed = values["simulation"]["seed"]
    if seed != int(seed) or seed >= 2**53:
        raise ScenarioError(
            "is not a whole number below 2^53", where=where, key="simulation.seed", value=seed
        )
    values["simulation"]["seed"] = int(seed)
