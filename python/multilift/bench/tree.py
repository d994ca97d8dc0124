"""MuJoCo on the same plant: a tree of hinges, its Runge-Kutta, one world or many."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from multilift.bench.rows import nanoseconds
from multilift.models.planar.scenario import planar_only
from multilift.scenario import Scenario

#: What one repetition does: steps of one world; worlds, and steps of each.
_STEPS = 10_000
_WORLDS = 16
_WORLD_STEPS = 500

#: Angles of the three hinges at the start, rad.
_START = (0.02, 0.05, -0.05)

_TREE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="RK4">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body name="bar">
      <inertial pos="0 0 0" mass="{m3}" diaginertia="{bar} {bar} {bar}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="1 0 0"/>
      <body name="vehicle_1" pos="0 -{half} {l3}">
        <inertial pos="0 0 {l1}" mass="{m1}" diaginertia="{rod} {rod} {rod}"/>
        <joint type="hinge" axis="1 0 0"/>
      </body>
      <body name="vehicle_2" pos="0 {half} {l3}">
        <inertial pos="0 0 {l2}" mass="{m2}" diaginertia="{rod} {rod} {rod}"/>
        <joint type="hinge" axis="1 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def mujoco_tree(scenario: Scenario, step: float, inertia: float = 1e-12) -> str:
    """The plant as an MJCF model without any constraint; tests/test_mujoco.py flies it.

    The bar slides and turns; each vehicle is a point mass on a massless rod that is hinged at the
    bar's end. MuJoCo's y and z are ours. The damping (14) is left out.

    Args:
        scenario: whose plant.
        step: of the integrator, s.
        inertia: rotational inertia of each rod, and of a bar that has none, kg m^2; MuJoCo
            refuses bodies without any.
    """
    plant = planar_only(scenario, "MuJoCo's model").plant
    return _TREE.format(
        step=step,
        gravity=plant.gravity,
        m1=plant.vehicle_mass[0],
        m2=plant.vehicle_mass[1],
        m3=plant.bar_mass,
        l1=plant.cable_length[0],
        l2=plant.cable_length[1],
        l3=plant.bar_half_thickness,
        half=0.5 * plant.bar_length,
        bar=max(plant.bar_inertia, inertia),
        rod=inertia,
    )


def one_world(scenario: Scenario) -> Callable[[], float] | None:
    """Measures ``mj_step`` from a swung start, ns a step; None if MuJoCo is not installed."""
    try:
        import mujoco  # noqa: PLC0415 - an optional package
    except ImportError:
        return None
    model, data = _model(mujoco, scenario)

    def measure() -> float:
        mujoco.mj_resetData(model, data)
        data.qpos[2:] = _START
        data.xfrc_applied[2:, 2] = _shares(scenario)
        return nanoseconds(lambda: mujoco.mj_step(model, data, _STEPS), _STEPS)

    return measure


def many_worlds(scenario: Scenario) -> Callable[[], float] | None:
    """Measures ``mujoco.rollout`` on one thread, ns a step of a world; None without it."""
    try:
        import mujoco  # noqa: PLC0415
        from mujoco import rollout  # noqa: PLC0415
    except ImportError:
        return None
    model, data = _model(mujoco, scenario)
    data.qpos[2:] = _START
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros((_WORLDS, mujoco.mj_stateSize(model, full)))
    for k, row in enumerate(state):
        data.qpos[2] = _START[0] * (1.0 + k / _WORLDS)
        mujoco.mj_getState(model, data, row, full)
    force = np.zeros((model.nbody, 6))
    force[2:, 2] = _shares(scenario)
    out = np.zeros((_WORLDS, _WORLD_STEPS, state.shape[1]))

    def measure() -> float:
        return nanoseconds(
            lambda: rollout.rollout(
                model, [data], state, np.tile(force.ravel(), (1, _WORLD_STEPS, 1)), state=out,
                control_spec=int(mujoco.mjtState.mjSTATE_XFRC_APPLIED),
            ),
            _WORLDS * _WORLD_STEPS,
        )  # fmt: skip

    return measure


def _model(mujoco: Any, scenario: Scenario) -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(mujoco_tree(scenario, scenario["simulation.step"]))
    return model, mujoco.MjData(model)


def _shares(scenario: Scenario) -> Any:
    """The force that holds each vehicle and its half of the bar, N."""
    plant = planar_only(scenario, "the benchmark").plant
    return (plant.vehicle_mass + 0.5 * plant.bar_mass) * plant.gravity
