"""The numbers of a spatial run that it can be differentiated along."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import _core, keys
from multilift.fields import Field
from multilift.gradient import COUNTED, REFUSED, no_number, push_refusal, refusal
from multilift.models.spatial import rows, tables
from multilift.models.spatial.formation import Rest
from multilift.models.spatial.rest_change import rest_change
from multilift.models.spatial.scenario import SpatialScenario
from multilift.overrides import Columns

Array = NDArray[np.float64]

#: Metrics without a derivative: they count steps or impacts, so that they stand still and jump.
WITHOUT_DERIVATIVE = (
    "swing_settling_time", "position_settling_time", "combined_settling",
    "payload_settling_time", "slack_time", "impacts",
)  # fmt: skip

_AHEAD = "it is worked out before the run, in plain numbers"
_JUMP = "cables come to hold what none of them held, so that their tensions jump"
_END = "it decides when a run ends and nothing else"
_NOISE = tuple(f.name for f in tables.MOTION_CAPTURE.fields if f.name.endswith("noise"))

#: Keys that cannot be differentiated along, with the reason.
_REFUSED = {
    **REFUSED,
    **{f"link.{f.name}": COUNTED for f in tables.LINK.fields},
    **{f"motion_capture.{f.name}": COUNTED for f in tables.MOTION_CAPTURE.fields
       if f.name not in _NOISE},
    **{f"safety.{f.name}": _END for f in tables.SAFETY.fields},
    "autopilot.rate": COUNTED,
    "wind.gust_speed": _AHEAD,
    "wind.altitude": _AHEAD,
}  # fmt: skip


class Direction(rows.Block):
    """How a scenario's numbers change with a key, table by table."""

    def __init__(self, scenario: SpatialScenario, key: str) -> None:
        super().__init__(Columns(scenario, None, 1), np.zeros(1, dtype=np.intp))
        self._base, self._places = keys.split_index(key)

    def flat(self, table: str, fields: Iterable[Field]) -> Array:
        """1 where the key names a number, else 0."""
        parts = [np.zeros(0)]
        of = self.tables[table.split("[", maxsplit=1)[0]]
        for field in fields:
            dims = of.field(field.name).dims
            change = np.zeros(dims)
            if f"{table}.{field.name}" == self._base and len(self._places) <= len(dims):
                inside = all(k < size for k, size in zip(self._places, dims, strict=False))
                if inside:
                    change[self._places] = 1.0
            parts.append(change.ravel())
        return np.concatenate(parts)[None]


def differentiate(scenario: SpatialScenario, along: Sequence[str]) -> dict[str, Any]:
    """See `multilift.models.Model.differentiate`."""
    frame, row, seed = rows.problem(scenario)
    tangents = np.array([tangent(scenario, key) for key in along]).reshape(len(along), len(row))
    result: dict[str, Any] = _core.spatial_gradient(
        _core.SpatialFrame(**frame), row, seed, tangents
    )
    return result


def tangent(scenario: SpatialScenario, key: str) -> Array:
    """How the run's row changes with a key.

    Raises:
        ScenarioError: for keys along which there are no derivatives, with the reason.
    """
    base, _ = keys.split_index(key)
    if reason := _REFUSED.get(base, "") or _refusal(scenario, base):
        raise refusal(scenario, key, reason)
    block = rows.Block(Columns(scenario, None, 1), np.zeros(1, dtype=np.intp))
    change = Direction(scenario, key)
    rest = rest_change(rows.hanging(block), rows.hanging(change))
    if rest is None:
        raise refusal(scenario, key, _JUMP)
    result: Array = rows.assemble(change, rest, *_start_change(block, change, rest))[0]
    if not result.any():
        raise no_number(
            scenario, key,
            "plant, vehicle, autopilot, formation, start, goal, controller, controller.assumed, "
            "limits, motion_capture, ground, wind and push[K]",
        )  # fmt: skip
    return result


def _start_change(block: rows.Block, change: Direction, rest: Rest) -> tuple[Array, Array]:
    """The derivative of `rows.starts`."""
    yaw, d_yaw = (b.numbers("start", "payload_yaw") for b in (block, change))
    position, velocity, rate = (
        change.numbers("start", f"payload_{name}") for name in ("position", "velocity", "rate")
    )
    payload = np.zeros((1, 13))
    payload[:, 0:3] = position
    payload[:, 3] = -0.5 * np.sin(yaw / 2) * d_yaw
    payload[:, 6] = 0.5 * np.cos(yaw / 2) * d_yaw
    payload[:, 7:10], payload[:, 10:13] = velocity, rate
    (turn,) = rows.turn(yaw)
    offset = rows.rest_of(block).offset[0] @ turn.T
    around = d_yaw * np.cross([0.0, 0.0, 1.0], offset)
    formed = position + rest.offset[0] @ turn.T + around
    vehicles = np.zeros((1, len(offset), 6))
    for at, name, otherwise in ((0, "position", formed), (3, "velocity", velocity)):
        given = block.numbers("start", f"vehicle_{name}")[0]
        own = change.numbers("start", f"vehicle_{name}")[0]
        vehicles[0, :, at : at + 3] = np.where(np.isnan(given), otherwise, own)
    return payload, vehicles


def _refusal(scenario: SpatialScenario, key: str) -> str:
    """Why this scenario cannot be differentiated along a key, or ""."""
    values = scenario.values
    moved = key in ("start.payload_position", "start.payload_yaw") or key.startswith("goal.")
    if moved and values["reference"]["kind"] != "step":
        return "the reference's path, worked out before the run in plain numbers, would move"
    table, _, name = key.partition(".")
    if table == "motion_capture" and values[table].get(name) == 0.0:
        return "without noise nothing is drawn that could grow; give it a value above 0"
    if key == "wind.mean" and values["wind"]["gust_speed"] > 0.0:
        return "the gusts' filters, worked out before the run in plain numbers, go by it"
    if key == "plant.payload_inertia" and not np.any(values["plant"]["payload_inertia"]):
        return "a point mass has none that could grow"
    if key == "autopilot.hover_thrust" and not np.all(values["autopilot"]["hover_thrust"]):
        return "0 stands for the rotors' thrust curve; give it values above 0"
    return push_refusal(scenario, key)
