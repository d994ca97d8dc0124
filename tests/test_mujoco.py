"""Rollouts against a general multibody engine, MuJoCo, under the same stepped law.

MuJoCo's y and z are ours; its hinges turn about x, from y towards z. Two models of the same plant:

- the tree that benchmarks measure: the bar slides and turns, each vehicle is a point mass on a rod
  hinged at the bar's end. Five degrees of freedom, linear in ours, and no constraint, so that RK4
  makes the same steps there and here. What differs is the round-off, and the tiny inertias without
  which MuJoCo takes no body;
- free bodies and two tendons of limited length: seven degrees of freedom. The limits are soft: a
  cable under tension is longer by an amount that goes with the square of their time constant.
"""

import multilift as ml
import numpy as np
import pytest
from multilift import _core, bench
from planar_runs import COMPILED, UNLIKE, coordinates

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (multilift[test])")

DURATION = 2.0  # s
RATE = 50.0  # Hz
TINY = 1e-12  # kg m^2

TENDONS = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="RK4"
          tolerance="1e-15" iterations="200">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="{m3}" diaginertia="{J} {J} {J}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="1 0 0"/>
      <site name="end_1" pos="0 -{half} {l3}"/>
      <site name="end_2" pos="0 {half} {l3}"/>
    </body>
    <body>
      <inertial pos="0 0 0" mass="{m1}" diaginertia="1 1 1"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <site name="vehicle_1"/>
    </body>
    <body>
      <inertial pos="0 0 0" mass="{m2}" diaginertia="1 1 1"/>
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
    """The plant of a scenario in MuJoCo. Bodies 1, 2, 3 are the bar and vehicles 1 and 2.

    A model sets `turning`, the matrix that makes theta_dot of its velocities, as far as these
    are hinges, and offers `place` and `angles`.
    """

    def __init__(self, scenario, xml):
        self.scenario, self.plant = scenario, scenario.plant
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        self.place(
            _core.planar_free_coordinates(
                scenario.plant_values(), scenario.q_start, scenario.q_dot_start
            )
        )

    def motion(self, body):
        """Position, velocity and Jacobian of a body's centre of mass in the plane."""
        jacobian = np.empty((3, self.model.nv))
        mujoco.mj_jacBodyCom(self.model, self.data, jacobian, None, body)
        return self.data.xipos[body, 1:], jacobian[1:] @ self.data.qvel, jacobian[1:]

    def seven(self):
        """Our q and q_dot."""
        (xi_1, xi_1_dot, _), (xi_2, xi_2_dot, _) = self.motion(2), self.motion(3)
        theta, theta_dot = self.angles()
        return np.hstack([xi_1, xi_2, theta]), np.hstack([xi_1_dot, xi_2_dot, theta_dot])

    def damp(self, _, data):
        """Adds the damping (14) to the forces along the engine's degrees of freedom."""
        for body, drag in zip((2, 3), self.plant.vehicle_drag, strict=True):
            _, velocity, jacobian = self.motion(body)
            data.qfrc_passive += jacobian.T @ (-drag * velocity)
        data.qfrc_passive += self.turning.T @ (
            -self.plant.swing_damping * (self.turning @ data.qvel)
        )

    def fly(self):
        """Coordinates q at each control instant of a flight under the scenario's law."""
        scenario, model, data = self.scenario, self.model, self.data
        law = _core.PlanarLaw(
            scenario.law, scenario.gain_values(), scenario.assumed_values(),
            scenario.goal_vector(), scenario.control_period(),
        )  # fmt: skip
        share = (self.plant.vehicle_mass + 0.5 * self.plant.bar_mass) * self.plant.gravity
        steps = round(scenario.control_period() / model.opt.timestep)
        rows = []
        mujoco.set_mjcb_passive(self.damp)
        try:
            for _ in range(round(DURATION / scenario.control_period()) + 1):
                mujoco.mj_forward(model, data)
                q, q_dot = self.seven()
                rows.append(q)
                u = np.reshape(law.step(q, q_dot), (2, 2))
                data.xfrc_applied[2:4, 1:3] = u + np.outer(share, [0, 1])
                mujoco.mj_step(model, data, steps)
        finally:
            mujoco.set_mjcb_passive(None)
        return np.array(rows)


class Tree(Engine):
    # theta1 is the turn of bar and rod 1, theta2 that of bar and rod 2 the other way round.
    turning = np.array([[0, 0, 1, 1, 0], [0, 0, -1, 0, -1], [0, 0, 1, 0, 0]])
    coordinates = np.vstack([np.eye(2, 5), turning])

    def __init__(self, scenario, step, tiny=TINY):
        super().__init__(scenario, bench.mujoco_tree(scenario, step, tiny))

    def place(self, free):
        self.data.qpos[:] = np.linalg.solve(self.coordinates, free[:5])
        self.data.qvel[:] = np.linalg.solve(self.coordinates, free[5:])

    def angles(self):
        return self.turning @ self.data.qpos, self.turning @ self.data.qvel


class Tendons(Engine):
    # Cables are no hinges here, so that only the bar's swing can be damped.
    turning = np.outer([0, 0, 1], [0, 0, 1, 0, 0, 0, 0])

    def __init__(self, scenario, step, softness):
        plant = scenario.plant
        (m1, m2), (l1, l2) = plant.vehicle_mass, plant.cable_length
        xml = TENDONS.format(
            step=step, gravity=plant.gravity, m1=m1, m2=m2, m3=plant.bar_mass, l1=l1, l2=l2,
            l3=plant.bar_half_thickness, half=0.5 * plant.bar_length, J=plant.bar_inertia,
            softness=softness,
        )  # fmt: skip
        super().__init__(scenario, xml)

    def place(self, free):
        vehicles, rates = self.scenario.q_start[:4], self.scenario.q_dot_start[:4]
        self.data.qpos[:] = [*free[0:2], free[4], *vehicles]
        self.data.qvel[:] = [*free[5:7], free[9], *rates]

    def angles(self):
        position, velocity, turn = self.data.qpos, self.data.qvel, np.array([[0, -1], [1, 0]])
        theta, theta_dot = [], []
        for end, vehicle, side in ((0, 2, 1), (1, 3, -1)):
            bar_end = self.data.site_xpos[end, 1:]
            end_velocity = velocity[:2] + velocity[2] * (turn @ (bar_end - position[:2]))
            cable = self.data.site_xpos[vehicle, 1:] - bar_end
            rate = velocity[2 * vehicle - 1 : 2 * vehicle + 1] - end_velocity
            theta.append(side * np.arctan2(-cable[0], cable[1]))
            theta_dot.append(side * (turn @ cable) @ rate / (cable @ cable))
        return np.array([*theta, position[2]]), np.array([*theta_dot, velocity[2]])


CASES = {"sim1": ("sim1", {}), "sim2": ("sim2", {}), "unlike vehicles": ("sim2", UNLIKE)}


def case(name, **values):
    base, changed = CASES[name]
    timing = {
        "controller.rate": RATE,
        "simulation.duration": DURATION,
        "simulation.record_period": 1 / RATE,
    }
    return ml.load(base).with_values(timing | changed | values)


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("step", [0.02, 0.001])
@pytest.mark.parametrize("name", CASES)
def test_a_tree_of_hinges_moves_alike_to_the_last_digits(name, step, law):
    # A step of 20 ms shows that even the error of RK4 is the same.
    scenario = case(name, **{"simulation.step": step}).with_law(law)
    ours = coordinates(ml.simulate(scenario))
    engine = Tree(scenario, step).fly()
    assert np.abs(np.diff(ours, axis=0)).max() > 1e-3  # it flies
    np.testing.assert_allclose(engine, ours, rtol=0, atol=1e-12)


def test_inertia_that_the_engine_needs_shows_in_proportion():
    scenario = case("sim1")
    ours = coordinates(ml.simulate(scenario))
    apart = [np.abs(Tree(scenario, 0.001, tiny).fly() - ours).max() for tiny in (1e-5, 1e-6)]
    assert apart[0] / apart[1] == pytest.approx(10.0, rel=1e-3)
    # At TINY it is far below the round-off that the test above permits.
    assert apart[1] / 1e-6 * TINY < 1e-13


@pytest.mark.parametrize("name", ["sim1", "unlike vehicles"])
def test_soft_tendons_approach_the_taut_cables_as_they_stiffen(name):
    scenario = case(name, **{"plant.bar_inertia": 0.2, "plant.swing_damping": [0.0, 0.0, 0.05]})
    ours = coordinates(ml.simulate(scenario))
    apart = [
        np.abs(Tendons(scenario, 0.1 * softness, softness).fly() - ours).max()
        for softness in (0.01, 0.005)  # s, the time constant of the limit
    ]
    assert apart[1] < 1e-5  # m
    assert apart[0] / apart[1] == pytest.approx(4.0, rel=0.1)
