"""The planar plant in MuJoCo: a tree of hinges, stepped by its Runge-Kutta."""

from __future__ import annotations

from typing import Any

from multilift.bench.engine import Place
from multilift.models.planar.scenario import planar_only
from multilift.scenario import Scenario

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


def tree_start(scenario: Scenario) -> Place:
    """Swings the tree's hinges and has each vehicle hold itself and its half of the bar."""
    plant = planar_only(scenario, "MuJoCo's model").plant
    share = (plant.vehicle_mass + 0.5 * plant.bar_mass) * plant.gravity

    def place(data: Any, part: float) -> None:
        data.qpos[2:] = (part * _START[0], *_START[1:])
        data.xfrc_applied[2:, 2] = share

    return place
