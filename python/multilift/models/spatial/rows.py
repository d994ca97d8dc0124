"""Spatial worlds as rows of numbers, in the order of bindings/spatial_problem.hpp."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import layout
from multilift.fields import Field
from multilift.models.spatial import formation, references, tables
from multilift.models.spatial.formation import Rest
from multilift.overrides import Columns
from multilift.scenario import Scenario
from multilift.steps import Steps

Array = NDArray[np.float64]
Worlds = NDArray[np.intp]

#: Tables whose numbers all default to perfection, so that none is simulated where all do.
_IDEAL_TABLES = {"motion_capture": tables.MOTION_CAPTURE.fields}


class Block:
    """Numbers of some worlds, table by table, each with its dimensions."""

    def __init__(self, columns: Columns, worlds: Worlds) -> None:
        self.columns, self.worlds = columns, worlds
        self.tables = columns.scenario.model.tables_of(columns.scenario.values)

    def flat(self, table: str, fields: Iterable[Field]) -> Array:
        """Fields in order, one row a world."""
        of = self.tables[table.split("[", maxsplit=1)[0]]
        return layout.block(self.columns, self.worlds, table, [of.field(f.name) for f in fields])

    def numbers(self, table: str, name: str) -> Array:
        """One field, shape (worlds, *shape)."""
        field = self.tables[table].field(name)
        return self.flat(table, (field,)).reshape(len(self.worlds), *field.dims)


def hanging(block: Block) -> tuple[Array, Array, Array, Array, Array, Array, Array | None]:
    """What `formation.rest` takes, of some worlds."""
    elastic = block.columns.scenario["plant.cables"] == "elastic"
    return (
        block.numbers("plant", "payload_mass"),
        block.numbers("plant", "gravity"),
        block.numbers("plant", "attachment"),
        block.numbers("plant", "cable_length"),
        block.numbers("formation", "tilt"),
        block.numbers("formation", "azimuth"),
        block.numbers("plant", "cable_stiffness") if elastic else None,
    )


def rest_of(block: Block) -> Rest:
    """The formations of some worlds at rest."""
    return formation.rest(*hanging(block))


def starts(block: Block, rest: Rest) -> tuple[Array, Array]:
    """Payloads' 13 numbers and vehicles' positions and velocities, shape (worlds, n, 6)."""
    count, n = len(block.worlds), rest.offset.shape[1]
    position, yaw = (block.numbers("start", f"payload_{key}") for key in ("position", "yaw"))
    velocity, rate = (block.numbers("start", f"payload_{key}") for key in ("velocity", "rate"))
    payload = np.zeros((count, 13))
    payload[:, 0:3] = position
    payload[:, 3], payload[:, 6] = np.cos(yaw / 2), np.sin(yaw / 2)
    payload[:, 7:10], payload[:, 10:13] = velocity, rate
    offset = np.einsum("wij,wnj->wni", turn(yaw), rest.offset)
    vehicles = np.zeros((count, n, 6))
    given = block.numbers("start", "vehicle_position")
    vehicles[..., :3] = np.where(np.isnan(given), position[:, None] + offset, given)
    moving = block.numbers("start", "vehicle_velocity")
    vehicles[..., 3:] = np.where(np.isnan(moving), velocity[:, None], moving)
    return payload, vehicles


def cable_lengths(block: Block, payload: Array, vehicles: Array) -> Array:
    """Distances from the attachments to the vehicles at the start, shape (worlds, n), m."""
    yaw = 2.0 * np.arctan2(payload[:, 6], payload[:, 3])
    arm = np.einsum("wij,wnj->wni", turn(yaw), block.numbers("plant", "attachment"))
    apart = vehicles[..., :3] - payload[:, None, :3] - arm
    return np.asarray(np.linalg.norm(apart, axis=2))


def turn(yaw: Array) -> Array:
    """From the level frame of each heading to the world, shape (worlds, 3, 3)."""
    c, s, zero, one = np.cos(yaw), np.sin(yaw), np.zeros_like(yaw), np.ones_like(yaw)
    return np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]]).transpose(2, 0, 1)


def rows(columns: Columns, worlds: Worlds) -> tuple[Array, NDArray[np.uint64]]:
    """The worlds' numbers as the core reads them, one row a world, and their seeds."""
    block = Block(columns, worlds)
    rest = rest_of(block)
    table = assemble(block, rest, *starts(block, rest))
    return np.ascontiguousarray(table), layout.seeds(columns, worlds)


def assemble(block: Block, rest: Rest, payload: Array, vehicles: Array) -> Array:
    """Rows of some worlds' numbers, or of how these change, in the core's order."""
    columns, scenario = block.columns, block.columns.scenario
    values = scenario.values
    parts = [block.flat("plant", tables.PLANT_NUMBERS)]
    for field in tables.PLANT_NUMBERS:
        key = f"controller.assumed.{field.name}"
        own = columns.is_own(key) or scenario.gives(key)
        parts.append(block.flat("controller.assumed" if own else "plant", (field,)))
    if values["vehicle"]["kind"] == "quadrotor":
        parts.append(block.flat("vehicle", tables.VEHICLE_NUMBERS))
        parts.append(block.flat("autopilot", tables.AUTOPILOT_NUMBERS))
    if values["ground"]["present"]:
        parts.append(block.flat("ground", tables.GROUND_NUMBERS))
    count = len(block.worlds)
    parts += [
        rest.offset.reshape(count, -1),
        rest.cable_force.reshape(count, -1),
        block.flat("goal", tables.GOAL.fields),
        block.flat("link", tables.LINK.fields),
        block.flat("limits", tables.LIMITS.fields),
    ]
    if not ideal_worlds(columns)[block.worlds[0]]:
        parts.append(block.flat("motion_capture", tables.MOTION_CAPTURE.fields))
    parts += [
        block.flat("wind", tables.WIND.fields),
        block.flat("safety", tables.SAFETY.fields),
        block.flat("controller", tables.LAWS[scenario.law].gains),
        payload,
        vehicles.reshape(count, -1),
    ]
    for k in range(len(values["push"])):
        parts.append(block.flat(f"push[{k}]", tables.PUSH_NUMBERS))
    return np.concatenate(parts, axis=1)


def problem(scenario: Scenario) -> tuple[Mapping[str, Any], Array, int]:
    """One world: the core's frame, its row and its seed."""
    columns, worlds = Columns(scenario, None, 1), np.zeros(1, dtype=np.intp)
    table, seeds = rows(columns, worlds)
    told = not ideal_worlds(columns)[0]
    return frame(scenario, Steps.of(scenario), motion_capture=told), table[0], int(seeds[0])


def ideal_worlds(columns: Columns) -> NDArray[np.bool_]:
    """Which worlds' laws are told the truth, so that no motion capture is simulated."""
    ideal = np.ones(columns.count, dtype=bool)
    for table, fields in _IDEAL_TABLES.items():
        for field in fields:
            ideal &= columns.get(table, field) == field.default
    return ideal


def frame(scenario: Scenario, steps: Steps, *, motion_capture: bool) -> Mapping[str, Any]:
    """What the worlds of one batch share, as the core's SpatialFrame takes it."""
    values = scenario.values
    pieces, end = references.pieces(values, scenario.where)
    return {
        "n": values["plant"]["vehicles"],
        "law": scenario.law,
        "quadrotors": values["vehicle"]["kind"] == "quadrotor",
        "rigid": values["plant"]["cables"] == "rigid",
        "ground": values["ground"]["present"],
        "motion_capture": motion_capture,
        "rotors_running": values["start"]["rotors"] == "running",
        "autopilot_steps": max(round(1.0 / values["autopilot"]["rate"] / steps.step), 1),
        "pieces": pieces,
        "path_end": end,
        "pushes": [
            (body_index(p["body"]), p["shape"], p["sample_times"] or [], p["sample_values"] or [])
            for p in values["push"]
        ],
        "happenings": [
            (e["kind"], body_index(e["vehicle"]), e["rotor"] - 1, round(e["time"] / steps.step))
            for e in values["event"]
        ],
        "step": steps.step,
        "steps": steps.steps,
        "control_steps": steps.control_steps,
        "record_steps": steps.record_steps,
    }


def body_index(name: str) -> int:
    """-1 for the payload, k - 1 for vehicle_k."""
    return -1 if name == "payload" else int(name.rpartition("_")[2]) - 1
