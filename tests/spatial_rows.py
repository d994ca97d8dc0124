"""Spatial worlds as rows of numbers for `_core.spatial_run`, without scenarios."""

from dataclasses import dataclass, field

import numpy as np
from multilift import _core

TABLES = _core.spatial_fields()
LAWS = _core.spatial_laws()
GRAVITY = 9.8


def pack(table, n, **given):
    """A table's numbers; what is given for one vehicle holds for all."""
    numbers = []
    for name, _, _, shape, default, _ in table:
        full = tuple(n if size == "n" else size for size in shape)
        each = full[1:] if shape[:1] == ("n",) else full
        value = np.asarray(given.pop(name, default), float)
        if value.size == np.prod(each, dtype=int):
            value = value.reshape(each)
        numbers.append(np.ravel(np.broadcast_to(value, full)))
    assert not given, given
    return np.concatenate(numbers) if numbers else np.zeros(0)


@dataclass
class World:
    """A plant and its start. Vehicles stand at `vehicles`, W; `force` is what the law answers."""

    plant: dict
    vehicles: np.ndarray
    payload: np.ndarray = field(default_factory=lambda: np.zeros(3))
    attitude: tuple = (1.0, 0.0, 0.0, 0.0)
    velocity: tuple = (0.0, 0.0, 0.0)
    rate: tuple = (0.0, 0.0, 0.0)
    vehicle_velocity: np.ndarray | None = None
    rigid: bool = True
    ground: dict | None = None

    def row(self):
        n = len(self.vehicles)
        plant = pack(TABLES["plant"], n, **self.plant)
        mass = self.plant["payload_mass"]
        share = np.tile([0, 0, mass * GRAVITY / n], (n, 1))
        still = np.zeros((n, 3)) if self.vehicle_velocity is None else self.vehicle_velocity
        ones = dict.fromkeys(("k_p", "k_d", "gamma"), 1.0)
        parts = [
            plant,
            plant,
            [] if self.ground is None else pack(TABLES["ground"], n, **self.ground),
            self.vehicles - self.payload,
            share,
            np.zeros(4),
            *(pack(TABLES[name], n) for name in ("link", "limits", "wind", "safety")),
            pack(LAWS["pd"][1], n, **ones),
            self.payload,
            self.attitude,
            self.velocity,
            self.rate,
            np.hstack([self.vehicles, still]),
        ]
        return np.concatenate([np.ravel(np.asarray(part, float)) for part in parts])

    def fly(self, duration, step, force=None, *, control_steps=1, record_steps=1):
        """Columns by name. `force(t, vehicles, velocities, payload)` gives (n, 3), W, N."""
        n = len(self.vehicles)

        def law(t, vehicle, velocity, payload, *_):
            answer = np.zeros((n, 3)) if force is None else force(t, vehicle, velocity, payload)
            return np.asarray(answer, float).tolist()

        frame = _core.SpatialFrame(
            n=n, law="pd", quadrotors=False, rigid=self.rigid, ground=self.ground is not None,
            motion_capture=False, rotors_running=True, autopilot_steps=1, pieces=[], path_end=0.0,
            pushes=[], happenings=[], step=step, steps=round(duration / step),
            control_steps=control_steps, record_steps=record_steps,
        )  # fmt: skip
        out = _core.spatial_run(frame, self.row(), 0, law)
        names = [name for name, *_ in _core.spatial_describe(n, False)["columns"]]
        out["columns"] = dict(zip(names, np.asarray(out["samples"]).T, strict=True))
        return out


def vectors(columns, name):
    """A vector's three columns, an instant a row."""
    return np.stack([columns[f"{name}_{axis}"] for axis in "xyz"], axis=1)
