"""Worlds as rows of numbers: checked like scenarios, laid out as the compiled kernels read them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from multilift import _core, geometry, schema
from multilift.errors import ScenarioError
from multilift.overrides import Columns
from multilift.scenario import Scenario


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
    for table in (schema.ACTUATORS, schema.SENSORS):
        for field in table.fields:
            ideal &= columns.get(table.name, field) == field.default
    return ideal


def check_worlds(columns: Columns) -> None:
    """What `validation` checks of a scenario, for every world at once.

    The step is not checked against each world's stiffest mode: a world that is too stiff for it
    diverges and says so.

    Raises:
        ScenarioError: for the first world that no scenario file may hold.
    """
    with np.errstate(all="ignore"):  # what is not finite is caught by the comparisons
        bad = _bad_worlds(columns)
    if bad.any():
        refuse(columns, int(np.flatnonzero(bad)[0]))


def _bad_worlds(columns: Columns) -> NDArray[np.bool_]:
    get = columns.numbers
    step = get("simulation.step")
    limit = get("actuators.thrust_max")
    share = (get("plant.vehicle_mass") + 0.5 * get("plant.bar_mass")[:, None]) * get(
        "plant.gravity"
    )[:, None]
    bad = np.zeros(columns.count, dtype=bool)
    bad |= (get("actuators.thrust_min") >= limit) | (share.max(axis=1) > limit)
    bad |= get("actuators.tilt_max") > np.pi / 2 + 1e-12
    seed = get("simulation.seed")
    bad |= (seed != np.floor(seed)) | (seed >= 2**53)

    def steps(key: str) -> NDArray[np.float64]:
        nonlocal bad
        time = get(key)
        count = np.round(time / step)
        bad |= ~(np.abs(time / step - count) <= 1e-6 * np.maximum(1, count))
        bad |= (count == 0) & (time > 0)
        return count

    control = np.round(1.0 / get("controller.rate") / step)
    sample = steps("sensors.period")
    sample = np.where(sample > 0, sample, control)
    capacity = _core.planar_delay_capacity - 2
    bad |= steps("actuators.command_delay") > capacity * control
    bad |= steps("sensors.delay") + control > capacity * sample
    for k, push in enumerate(columns.scenario.values["push"]):
        start, duration = get(f"push[{k}].start"), get(f"push[{k}].duration")
        bad |= duration < (1 - 1e-6) * step
        if push["shape"] == "pulse":
            for time in (start, duration):
                bad |= np.abs(time / step - np.round(time / step)) >= 1e-6 * np.maximum(
                    1.0, time / step
                )
        if push["body"] != "bar":
            bad |= get(f"push[{k}].torque") != 0.0
    return bad


def refuse(columns: Columns, world: int) -> None:
    """Raises the error that a world would raise alone.

    Raises:
        ScenarioError: naming the world and what is wrong with it.
    """
    try:
        columns.world(world)
    except ScenarioError as error:
        raise ScenarioError(
            f"world {world} cannot be: {error}", where=columns.scenario.where, key=error.key
        ) from None
    raise AssertionError(f"world {world} is refused in a batch but not alone")


def rows(
    columns: Columns, worlds: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.uint64]]:
    """The worlds' numbers as the kernel reads them, one row a world, and their seeds.

    Raises:
        ScenarioError: for a start or a goal that no bar can take, naming the world.
    """
    scenario, n = columns.scenario, len(worlds)

    def block(table: str, fields: tuple[schema.Field, ...]) -> NDArray[np.float64]:
        parts = []
        for field in fields:
            values = columns.get(table, field)
            values = (
                values[worlds] if len(values) > 1 else np.broadcast_to(values, (n, *field.shape))
            )
            parts.append(values.reshape(n, -1))
        return np.concatenate(parts, axis=1)

    plant_fields = schema.PLANT.fields[1:]
    plant = block("plant", plant_fields)
    assumed = np.concatenate(
        [
            block("controller.assumed" if _assumes(columns, f.name) else "plant", (f,))
            for f in plant_fields
        ],
        axis=1,
    )
    goal = block("goal", schema.GOAL.fields[:1])
    pushes = []
    numbers = ("force", "torque", "start", "duration", "frequency")
    for k in range(len(scenario.values["push"])):
        by_name = {f.name: f for f in schema.PUSH.fields}
        pushes.append(block(f"push[{k}]", tuple(by_name[name] for name in numbers)))
    table = np.concatenate(
        [
            plant,
            assumed,
            block("controller", schema.gain_fields(scenario.law)),
            block("actuators", schema.ACTUATORS.fields),
            block("sensors", schema.SENSORS.fields),
            _starts(columns, plant, worlds, block),
            goal,
            *pushes,
        ],
        axis=1,
    )
    seed = next(f for f in schema.SIMULATION.fields if f.name == "seed")
    seeds = np.broadcast_to(columns.get("simulation", seed), (columns.count,))[worlds]
    return np.ascontiguousarray(table), np.ascontiguousarray(seeds.astype(np.uint64))


def _assumes(columns: Columns, name: str) -> bool:
    """Whether the law is told something of its own about a plant's number."""
    return columns.is_own(f"controller.assumed.{name}") or columns.scenario.assumes(name)


def _starts(
    columns: Columns,
    plant: NDArray[np.float64],
    worlds: NDArray[np.intp],
    block: Callable[[str, tuple[schema.Field, ...]], NDArray[np.float64]],
) -> NDArray[np.float64]:
    position, angle, velocity, rate = (block("start", (f,)) for f in schema.START.fields)
    goal = block("goal", schema.GOAL.fields[:1])
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
        world = int(worlds[np.flatnonzero(bad)[0]])
        refuse(columns, world)
    return table[:, :10]


def _plant_names() -> list[str]:
    return [
        f"{f.name}[{k}]"
        for f in schema.PLANT.fields[1:]
        for k in range(int(np.prod(f.shape, dtype=int)))
    ]
