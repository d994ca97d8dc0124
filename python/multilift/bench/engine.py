"""MuJoCo's time for a step, one world or many on one thread, whatever the model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from multilift.bench.rows import nanoseconds

#: What one repetition does: steps of one world; worlds, and steps of each.
_STEPS = 10_000
_WORLDS = 16
_WORLD_STEPS = 500

#: Puts MuJoCo's data at a start, off rest in proportion to a part, and sets the forces held.
Place = Callable[[Any, float], None]


def one_world(xml: str, place: Place) -> Callable[[], float] | None:
    """Measures ``mj_step``, ns a step; None if MuJoCo is not installed.

    Args:
        xml: the model, MJCF.
        place: where its data start, and the forces on bodies.
    """
    try:
        import mujoco  # noqa: PLC0415 - an optional package
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)

    def measure() -> float:
        mujoco.mj_resetData(model, data)
        place(data, 1.0)
        return nanoseconds(lambda: mujoco.mj_step(model, data, _STEPS), _STEPS)

    return measure


def many_worlds(xml: str, place: Place) -> Callable[[], float] | None:
    """Measures ``mujoco.rollout`` on one thread, ns a step of a world; None without it.

    Args:
        xml: the model, MJCF.
        place: where its data start, and the forces on bodies.
    """
    try:
        import mujoco  # noqa: PLC0415
        from mujoco import rollout  # noqa: PLC0415
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros((_WORLDS, mujoco.mj_stateSize(model, full)))
    for k, row in enumerate(state):
        place(data, 1.0 + k / _WORLDS)
        mujoco.mj_getState(model, data, row, full)
    force = np.tile(data.xfrc_applied.ravel(), (1, _WORLD_STEPS, 1))
    out = np.zeros((_WORLDS, _WORLD_STEPS, state.shape[1]))

    def measure() -> float:
        return nanoseconds(
            lambda: rollout.rollout(
                model, [data], state, force, state=out,
                control_spec=int(mujoco.mjtState.mjSTATE_XFRC_APPLIED),
            ),
            _WORLDS * _WORLD_STEPS,
        )  # fmt: skip

    return measure
