"""Rollouts against a general multibody engine, MuJoCo, under the same stepped law.

MuJoCo's y and z are ours; its hinges turn about x, from y towards z. Two models of the same plant:

- a tree: the bar slides and turns, each vehicle is a point mass on a rod hinged at the bar's end.
  Five degrees of freedom and no constraint, so that both integrate the same equations by RK4 and
  differ by the 4th power of the step, and by the tiny inertias without which MuJoCo takes no body;
- free bodies and two tendons of limited length: seven degrees of freedom. The limits are soft: a
  cable under tension is longer by an amount that goes with the square of their time constant.
"""

from contextlib import contextmanager

import numpy as np
import pytest
from planar_runs import at_every_step, coordinates

import multilift as ml
from multilift import _core

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (multilift[test])")

DURATION = 2.0  # s
RATE = 50.0  # Hz
TINY = 1e-12  # kg m^2

HEADER = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="{integrator}"
          tolerance="1e-15" iterations="200">
    <flag contact="disable"/>
  </option>
"""
TREE = HEADER + """
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="{m3}" diaginertia="{inertia} {inertia} {inertia}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="1 0 0"/>
      <body pos="0 -{half} {l3}">
        <inertial pos="0 0 {l1}" mass="{m1}" diaginertia="{tiny} {tiny} {tiny}"/>
        <joint type="hinge" axis="1 0 0"/>
      </body>
      <body pos="0 {half} {l3}">
        <inertial pos="0 0 {l2}" mass="{m2}" diaginertia="{tiny} {tiny} {tiny}"/>
        <joint type="hinge" axis="1 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
TENDONS = HEADER + """
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="{m3}" diaginertia="{inertia} {inertia} {inertia}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="1 0 0"/>
      <site name="end_1" pos="0 -{half} {l3}"/>
      <site name="end_2" pos="0 {half} {l3}"/>
    </body>
    <body>
      <inertial pos="0 0 0" mass="{m1}" diaginertia="{tiny} {tiny} {tiny}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <site name="vehicle_1"/>
    </body>
    <body>
      <inertial pos="0 0 0" mass="{m2}" diaginertia="{tiny} {tiny} {tiny}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <site name="vehicle_2"/>
    </body>
  </worldbody>
  <tendon>
    <spatial limited="true" range="0 {l1}" solreflimit="{softness} 1">
      <site site="end_1"/><site site="vehicle_1"/>
    </spatial>
    <spatial limited="true" range="0 {l2}" solreflimit="{softness} 1">
      <site site="end_2"/><site site="vehicle_2"/>
    </spatial>
  </tendon>
</mujoco>
"""


class Engine:
    """The plant of a scenario in MuJoCo. Bodies 1, 2, 3 are the bar and vehicles 1 and 2."""

    def __init__(self, template, scenario, step, tiny=TINY, **options):
        plant = self.plant = scenario.plant
        (m1, m2), (l1, l2) = plant.vehicle_mass, plant.cable_length
        self.model = mujoco.MjModel.from_xml_string(
            template.format(
                step=step, gravity=plant.gravity, m1=m1, m2=m2, m3=plant.bar_mass, l1=l1, l2=l2,
                l3=plant.bar_half_thickness, half=0.5 * plant.bar_length,
                inertia=max(plant.bar_inertia, tiny), tiny=tiny, **options,
            )
        )  # fmt: skip
        self.data = mujoco.MjData(self.model)
        free = np.array(
            _core.planar_free_coordinates(
                scenario.plant_values(), scenario.q_start, scenario.q_dot_start
            )
        )
        self.place(free[:5], free[5:])
        mujoco.mj_forward(self.model, self.data)

    def motion(self, body):
        """Position, velocity and Jacobian of a body's centre of mass in the plane."""
        jacobian = np.empty((3, self.model.nv))
        mujoco.mj_jacBodyCom(self.model, self.data, jacobian, None, body)
        return self.data.xipos[body, 1:], jacobian[1:] @ self.data.qvel, jacobian[1:]

    def seven(self):
        """Our q and q_dot."""
        vehicles = [self.motion(body) for body in (2, 3)]
        angles, rates = self.angles()
        return (
            np.concatenate([vehicles[0][0], vehicles[1][0], angles]),
            np.concatenate([vehicles[0][1], vehicles[1][1], rates]),
        )

    def damp(self, model, data):
        """The damping (14), as forces along the degrees of freedom."""
        for body, drag in zip((2, 3), self.plant.vehicle_drag, strict=True):
            _, velocity, jacobian = self.motion(body)
            data.qfrc_passive += jacobian.T @ (-drag * velocity)
        data.qfrc_passive += self.TURNING.T @ (
            -self.plant.swing_damping * (self.TURNING @ data.qvel)
        )

    @contextmanager
    def damping(self):
        mujoco.set_mjcb_passive(self.damp)
        try:
            yield
        finally:
            mujoco.set_mjcb_passive(None)

    def fly(self, scenario):
        """q at each control instant under the scenario's law."""
        law = _core.PlanarLaw(
            scenario.law, scenario.gain_values(), scenario.assumed_values(),
            scenario.goal_vector(), scenario.control_period(),
        )  # fmt: skip
        half_bar = 0.5 * self.plant.bar_mass
        share = (self.plant.vehicle_mass + half_bar) * self.plant.gravity
        rows = []
        with self.damping():
            for _ in range(round(DURATION * RATE)):
                mujoco.mj_forward(self.model, self.data)
                q, q_dot = self.seven()
                rows.append(q)
                force = np.reshape(law.step(q, q_dot), (2, 2)) + np.outer(share, [0, 1])
                self.data.xfrc_applied[2:4, 1:3] = force
                mujoco.mj_step(
                    self.model, self.data, round(1 / (RATE * self.model.opt.timestep))
                )
            mujoco.mj_forward(self.model, self.data)
        return np.array([*rows, self.seven()[0]])


class Tree(Engine):
    # theta1..3 turn with the hinges: bar + rod 1, -(bar + rod 2), bar.
    TURNING = np.array([[0, 0, 1, 1, 0], [0, 0, -1, 0, -1], [0, 0, 1, 0, 0]])

    def __init__(self, scenario, step, tiny=TINY):
        super().__init__(TREE, scenario, step, tiny, integrator="RK4")

    def place(self, free, rates):
        self.data.qpos[:] = np.linalg.solve(self.COORDINATES, free)
        self.data.qvel[:] = np.linalg.solve(self.COORDINATES, rates)

    COORDINATES = np.vstack([np.eye(2, 5), TURNING])

    def angles(self):
        return self.TURNING @ self.data.qpos, self.TURNING @ self.data.qvel


class Tendons(Engine):
    def __init__(self, scenario, step, softness):
        super().__init__(
            TENDONS, scenario, step, softness=softness, integrator="implicitfast"
        )

    def place(self, free, rates):
        plant = self.model
        self.data.qpos[:3] = free[[0, 1, 4]]
        self.data.qvel[:3] = rates[[0, 1, 4]]
