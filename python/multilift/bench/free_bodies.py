"""A spatial plant in MuJoCo: free bodies, and tendons of limited length as cables."""

from __future__ import annotations

from typing import Any

import numpy as np

from multilift.bench.engine import Place

_WORLD = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="RK4" {option}>
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body name="load">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia}"/>
      {ties}
    </body>
    {vehicles}
  </worldbody>
  <tendon>{tendons}</tendon>
</mujoco>
"""
_TIE = '<site name="t{i}" pos="{place}"/>'
_VEHICLE = (
    '<body name="v{i}"><freejoint/><inertial pos="0 0 0" mass="{mass}" diaginertia="1 1 1"/>'
    '<site name="v{i}"/></body>'
)
_TENDON = (
    '<spatial limited="true" range="0 {length}" solreflimit="{softness} 1"'
    ' solimplimit="0.9999 0.9999 0.001"><site site="t{i}"/><site site="v{i}"/></spatial>'
)

#: Velocity of the load at the start, m/s.
_START = (0.2, 0.1, 0.0)


def mujoco_free_bodies(
    plant: dict[str, Any], step: float, softness: float = 0.02, option: str = ""
) -> str:
    """The plant as an MJCF model; tests/test_spatial_mujoco.py flies it.

    The load is a free body, body 1, and so is each vehicle, from body 2 on. Drag is left out.

    Args:
        plant: payload_mass, payload_inertia (3,), vehicle_mass (n,), cable_length (n,), attachment
            (n, 3) and gravity, as in a scenario's [plant].
        step: of the integrator, s.
        softness: time constant of the limits, s; MuJoCo's own is 0.02.
        option: further attributes of MJCF's <option>.
    """
    tied = list(zip(plant["attachment"], plant["vehicle_mass"], plant["cable_length"], strict=True))
    return _WORLD.format(
        step=step,
        gravity=plant["gravity"],
        option=option,
        mass=plant["payload_mass"],
        inertia=_numbers(plant["payload_inertia"]),
        ties="".join(_TIE.format(i=i, place=_numbers(r)) for i, (r, _, _) in enumerate(tied)),
        vehicles="".join(_VEHICLE.format(i=i, mass=m) for i, (_, m, _) in enumerate(tied)),
        tendons="".join(
            _TENDON.format(i=i, length=length, softness=softness)
            for i, (_, _, length) in enumerate(tied)
        ),
    )


def free_bodies_start(plant: dict[str, Any], vehicles: Any, force: Any) -> Place:
    """Puts the load at the origin with some speed and the vehicles, at rest, above it.

    Args:
        plant: as above.
        vehicles: (n, 3), from the load, m.
        force: (n, 3), held of each vehicle, N.
    """
    n = len(plant["vehicle_mass"])

    def place(data: Any, part: float) -> None:
        data.qpos[:] = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], n + 1)
        data.qvel[:3] = part * np.array(_START)
        for i in range(n):
            data.qpos[7 + 7 * i : 10 + 7 * i] = vehicles[i]
        data.xfrc_applied[2:, :3] = force

    return place


def _numbers(values: Any) -> str:
    return " ".join(str(float(x)) for x in values)
