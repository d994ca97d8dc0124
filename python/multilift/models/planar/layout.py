"""Planar worlds as rows of numbers: checked like scenarios, laid out as the kernels read them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import _core, layout, pushes
from multilift.errors import ScenarioError
from multilift.models.planar import geometry
from multilift.models.planar.scenario import planar_only
from multilift.models.planar.tables import (
    ACTUATORS,
    GOAL,
    LAWS,
    PLANT_NUMBERS,
    PUSH_NUMBERS,
    SENSORS,
    START,
)
from multilift.overrides import Columns
from multilift.scenario import Scenario
from multilift.steps import Steps


def push_shapes(scenario: Scenario) -> list[tuple[str, str, list[float], list[float]]]:
    """Of each push what all worlds share: body, shape, sample times and values."""
    return [
        (p["body"], p["shape"], p["sample_times"] or [], p["sample_values"] or [])
        for p in scenario.values["push"]
    ]


def is_ideal(columns: Columns) -> bool:
    """Whether no world's actuators and sensors have any imperfection."""
    return bool(ideal_worlds(columns).all())


def ideal_worlds(columns: Columns) -> NDArray[np.bool_]:
    """Which worlds' actuators and sensors have no imperfection, so that none is simulated."""
    ideal = np.ones(columns.count, dtype=bool)
    for table in (ACTUATORS, SENSORS):
        for field in table.fields:
            ideal &= columns.get(table.name, field) == field.default
    return ideal


def check_worlds(columns: Columns) -> None:
    """What a planar scenario checks of itself, for every world at once.

    The step is not checked against each world's stiffest mode: a world that is too stiff for it
    diverges and says so.

    Raises:
        ScenarioError: for the first world that no scenario file may hold.
    """
    refuse_moved_paths(columns)
    with np.errstate(all="ignore"):  # what is not finite is caught by the comparisons
        bad = _bad_limits(columns) | layout.bad_timing(columns) | _bad_delays(columns)
        bad |= pushes.bad_worlds(columns) | _bad_torques(columns)
    layout.refuse_first(columns, bad)


def refuse_moved_paths(columns: Columns) -> None:
    """A path is worked out once for all worlds, from the scenario's own start and goal.

    Raises:
        ScenarioError: where worlds would need paths of their own.
    """
    scenario = columns.scenario
    if not planar_only(scenario, "this batch").moves_target():
        return
    for field in (*START.fields, *GOAL.fields[:1]):
        key = f"{'goal' if field in GOAL.fields else 'start'}.{field.name}"
        if columns.is_own(key):
            raise ScenarioError(
                "differs from world to world, but the reference's path is the same for all",
                where=scenario.where,
                key=key,
                advice='use reference.kind = "step", or a batch for each path',
            )


def _bad_limits(columns: Columns) -> NDArray[np.bool_]:
    get = columns.numbers
    limit = get("actuators.thrust_max")
    share = (get("plant.vehicle_mass") + 0.5 * get("plant.bar_mass")[:, None]) * get(
        "plant.gravity"
    )[:, None]
    bad = np.zeros(columns.count, dtype=bool)
    bad |= (get("actuators.thrust_min") >= limit) | (share.max(axis=1) > limit)
    bad |= get("actuators.tilt_max") > np.pi / 2 + 1e-12
    return bad


def _bad_delays(columns: Columns) -> NDArray[np.bool_]:
    control = np.round(
        1.0 / columns.numbers("controller.rate") / columns.numbers("simulation.step")
    )
    sample = layout.step_count(columns, "sensors.period")
    sample = np.where(sample > 0, sample, control)
    capacity = _core.planar_delay_capacity - 2
    bad = np.zeros(columns.count, dtype=bool)
    bad |= layout.step_count(columns, "actuators.command_delay") > capacity * control
    bad |= layout.step_count(columns, "sensors.delay") + control > capacity * sample
    return bad


def _bad_torques(columns: Columns) -> NDArray[np.bool_]:
    bad = np.zeros(columns.count, dtype=bool)
    for k, push in enumerate(columns.scenario.values["push"]):
        if push["body"] != "bar":
            bad |= columns.numbers(f"push[{k}].torque") != 0.0
    return bad


def rows(
    columns: Columns, worlds: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.uint64]]:
    """The worlds' numbers as the kernel reads them, one row a world, and their seeds.

    Raises:
        ScenarioError: for a start or a goal that no bar can take, naming the world.
    """
    scenario = columns.scenario
    plant = layout.block(columns, worlds, "plant", PLANT_NUMBERS)
    parts = [plant]
    for field in PLANT_NUMBERS:
        source = "controller.assumed" if _assumes(columns, field.name) else "plant"
        parts.append(layout.block(columns, worlds, source, (field,)))
    parts += [
        layout.block(columns, worlds, "controller", LAWS[scenario.law].gains),
        layout.block(columns, worlds, "actuators", ACTUATORS.fields),
        layout.block(columns, worlds, "sensors", SENSORS.fields),
        _starts(columns, plant, worlds),
        layout.block(columns, worlds, "goal", GOAL.fields[:1]),
    ]
    for k in range(len(scenario.values["push"])):
        parts.append(layout.block(columns, worlds, f"push[{k}]", PUSH_NUMBERS))
    table = np.ascontiguousarray(np.concatenate(parts, axis=1))
    return table, layout.seeds(columns, worlds)


def _assumes(columns: Columns, name: str) -> bool:
    """Whether the law is told something of its own about a plant's number."""
    return columns.is_own(f"controller.assumed.{name}") or columns.scenario.gives(
        f"controller.assumed.{name}"
    )


def _starts(
    columns: Columns,
    plant: NDArray[np.float64],
    worlds: NDArray[np.intp],
) -> NDArray[np.float64]:
    position, angle, velocity, rate = (
        layout.block(columns, worlds, "start", (f,)) for f in START.fields
    )
    goal = layout.block(columns, worlds, "goal", GOAL.fields[:1])
    table = np.asarray(
        _core.planar_starts(
            np.ascontiguousarray(plant), np.ascontiguousarray(position),
            np.ascontiguousarray(angle), np.nan_to_num(velocity), np.nan_to_num(rate),
        )
    )  # fmt: skip
    tolerance = geometry.CLOSURE_TOLERANCE
    bad = ~(np.abs(table[:, 10:]).max(axis=1) <= tolerance)
    bad |= ~(np.abs(table[:, 2:5]).max(axis=1) < np.pi / 2)
    if not columns.scenario.values["goal"]["allow_mismatch"]:
        length = dict(zip(_plant_names(), plant.T, strict=True))
        along = goal[:, 2] - goal[:, 0] - length["bar_length[0]"]
        up = (goal[:, 1] - length["cable_length[0]"]) - (goal[:, 3] - length["cable_length[1]"])
        bad |= np.maximum(np.abs(along), np.abs(up)) > tolerance
    if bad.any():
        layout.refuse(columns, int(worlds[np.flatnonzero(bad)[0]]))
    return table[:, :10]


def _plant_names() -> list[str]:
    return [f"{f.name}[{k}]" for f in PLANT_NUMBERS for k in range(int(np.prod(f.dims, dtype=int)))]


def run_worlds(
    kernel: ModuleType,
    columns: Columns,
    worlds: NDArray[np.intp],
    steps: Steps,
    results: Mapping[str, NDArray[Any] | None],
    *,
    threads: int,
    progress: Callable[[int], None] | None,
) -> None:
    """See `multilift.models.Model.run_worlds`."""
    table, seeds = rows(columns, worlds)
    scenario = planar_only(columns.scenario, "this batch")
    pieces, path_end = scenario.path
    kernel.run(
        law=columns.scenario.law,
        rows=table,
        seeds=seeds,
        pushes=push_shapes(columns.scenario),
        step=steps.step,
        steps=steps.steps,
        control_steps=steps.control_steps,
        record_steps=steps.record_steps,
        ideal=bool(ideal_worlds(columns)[worlds[0]]),
        **results,
        threads=threads,
        progress=progress,
        pieces=pieces,
        path_end=path_end,
        view=scenario.view(),
    )
