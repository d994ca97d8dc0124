"""The numbers of a planar run that it can be differentiated along."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import isa, keys
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.gradient import COUNTED, REFUSED, no_number, push_refusal, refusal
from multilift.models.planar import layout
from multilift.models.planar.scenario import PlanarScenario
from multilift.models.planar.tables import (
    ACTUATORS,
    GOAL,
    LAWS,
    PLANT_NUMBERS,
    PUSH_NUMBERS,
    SENSORS,
    START,
)

#: Metrics without a derivative: they count integration steps, so that they stand still and jump.
WITHOUT_DERIVATIVE = (
    "swing_settling_time", "position_settling_time", "combined_settling", "rest_settling_time",
)  # fmt: skip

#: Keys that cannot be differentiated along, with the reason.
_REFUSED = {
    **REFUSED,
    "sensors.period": COUNTED,
    "sensors.delay": COUNTED,
    "actuators.command_delay": COUNTED,
}


def differentiate(scenario: PlanarScenario, along: Sequence[str]) -> dict[str, Any]:
    """See `multilift.models.Model.differentiate`."""
    if scenario.moves_target():
        raise ScenarioError(
            "is worked out before the run in plain numbers, without derivatives",
            where=scenario.where,
            key="reference.kind",
            value=scenario["reference.kind"],
            permitted="step",
        )
    values, sources = numbers(scenario)
    tangents = np.array([tangent(scenario, key, sources) for key in along])
    simulation = scenario.values["simulation"]
    step = simulation["step"]
    testbed = any(key.startswith(("actuators.", "sensors.")) for key in along)
    result: dict[str, Any] = isa.kernel().gradient(
        law=scenario.law,
        values=values,
        tangents=tangents.reshape(len(along), len(values)),
        pushes=layout.push_shapes(scenario),
        at_rest=scenario.values["start"]["angle"] is None,
        step=step,
        steps=round(simulation["duration"] / step),
        control_steps=round(scenario.control_period() / step),
        ideal=scenario.is_ideal() and not testbed,
        seed=simulation["seed"],
    )
    return result


def numbers(scenario: PlanarScenario) -> tuple[NDArray[np.float64], list[frozenset[str]]]:
    """The run's numbers as the core reads them, and the keys that each of them follows."""
    tables = scenario.values
    values: list[float] = []
    sources: list[frozenset[str]] = []

    def add(table: str, fields: Iterable[Field], also: str = "") -> None:
        for field in fields:
            value = _table(tables, table)[field.name]
            given = np.broadcast_to(0.0 if value is None else value, field.dims)
            values.extend(float(x) for x in given.ravel())
            follows = also and not scenario.assumes(field.name)
            for place in np.ndindex(*field.dims):
                index = "".join(f"[{k}]" for k in place)
                names = {f"{table}.{field.name}{index}"}
                sources.append(
                    frozenset(names | ({f"{also}.{field.name}{index}"} if follows else set()))
                )

    add("plant", PLANT_NUMBERS)
    add("controller.assumed", PLANT_NUMBERS, also="plant")
    add("controller", LAWS[scenario.law].gains)
    add("actuators", ACTUATORS.fields)
    add("sensors", SENSORS.fields)
    add("start", START.fields)
    add("goal", GOAL.fields[:1])
    for k in range(len(tables["push"])):
        add(f"push[{k}]", PUSH_NUMBERS)
    return np.array(values), sources


def _table(tables: dict[str, Any], name: str) -> dict[str, Any]:
    push = re.fullmatch(r"push\[(\d+)\]", name)
    if push:
        return dict(tables["push"][int(push[1])])
    node: Any = tables
    for part in name.split("."):
        node = node[part]
    return dict(node)


def tangent(
    scenario: PlanarScenario, key: str, sources: Sequence[frozenset[str]]
) -> NDArray[np.float64]:
    """How the run's numbers change with a key."""

    def belongs(source: str) -> bool:
        return source == key or source.startswith(key + "[")

    result = np.array([float(any(map(belongs, names))) for names in sources])
    base, _ = keys.split_index(key)
    if reason := _REFUSED.get(base, "") or _refusal(scenario, base):
        raise refusal(scenario, key, reason)
    if not result.any():
        raise no_number(
            scenario, key,
            "plant, start, goal, controller, controller.assumed, actuators, sensors and push[K]",
        )  # fmt: skip
    return result


def _refusal(scenario: PlanarScenario, key: str) -> str:
    """Why this scenario cannot be differentiated along a key, or ""."""
    if key == "start.angle" and scenario.values["start"]["angle"] is None:
        return "the load starts at rest, so that its angles follow; give start.angle to free them"
    noise = key.startswith("sensors.") and key.endswith("_noise")
    if noise and scenario.values["sensors"].get(key.removeprefix("sensors.")) == 0.0:
        return "without noise nothing is drawn that could grow; give it a value above 0"
    lags = ("actuators.thrust_time_constant", "actuators.attitude_time_constant")
    if key in lags and scenario[key] == 0.0:
        return "a lag below one step changes nothing; give it a value above 0"
    return push_refusal(scenario, key)
