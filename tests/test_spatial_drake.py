"""Quadrotors against Drake: rigid bodies, distance constraints, forces where rotors stand.

Drake steps its constraints implicitly, of first order in the step, so that a flight at half of the
step is off by half as much, and twice the one less the other has an error of second order. Cables
that keep their lengths are all that its distance constraints are.
"""

import numpy as np
import pytest
from spatial_mujoco import CORNERS, SENSES
from spatial_rotors import DRAG, ROTOR_DRAG, our_flight, our_rows, quaternions, rotor_speeds
from spatial_rows import GRAVITY

tree = pytest.importorskip(
    "pydrake.multibody.tree", reason="Drake is not installed: make test-drake"
)
from pydrake.common.eigen_geometry import Quaternion  # noqa: E402
from pydrake.common.value import Value  # noqa: E402
from pydrake.math import RigidTransform  # noqa: E402
from pydrake.multibody.math import SpatialForce, SpatialVelocity  # noqa: E402
from pydrake.multibody.plant import (  # noqa: E402
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)

ROWS = 51  # of 10 ms


def body(plant, name, mass, moments):
    inertia = tree.SpatialInertia.MakeFromCentralInertia(
        mass, np.zeros(3), tree.RotationalInertia(*map(float, moments))
    )
    return plant.AddRigidBody(name, inertia)


def push(bodies, index, at, force, torque=(0.0, 0.0, 0.0)):
    """A force in W at a place in a body's frame."""
    applied = ExternallyAppliedSpatialForce()
    applied.body_index = bodies[index].index()
    applied.p_BoBq_B = np.asarray(at)
    applied.F_Bq_W = SpatialForce(np.asarray(torque), np.asarray(force))
    return applied


def pose(state):
    """Drake's transform and velocity of position, attitude, velocity and rate in the body."""
    attitude = Quaternion(state[3:7] / np.linalg.norm(state[3:7]))
    turn = attitude.rotation()
    return RigidTransform(attitude, state[:3]), SpatialVelocity(turn @ state[10:], state[7:10])


def engine_flight(n, step):
    """Positions of payload and vehicles every 10 ms, by the thrusts of our flight of that step."""
    crew, (payload, vehicles), craft, run = our_flight(n, False, step)
    attitude = quaternions(run["columns"], n)[:, :, 0]
    speeds = rotor_speeds(run["columns"], n)
    plant = MultibodyPlant(time_step=step)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -GRAVITY])
    load = body(plant, "load", crew.payload_mass, crew.payload_inertia)
    bodies = [body(plant, f"v{i}", crew.mass[i], craft["inertia"][i]) for i in range(n)]
    for i in range(n):
        plant.AddDistanceConstraint(
            bodies[i], np.zeros(3), load, crew.attachment[i], float(crew.length[i])
        )
    plant.Finalize()
    context = plant.CreateDefaultContext()
    starts = [
        payload,
        *(np.r_[vehicles[i, :3], attitude[i], vehicles[i, 3:], 0, 0, 0] for i in range(n)),
    ]
    every = [load, *bodies]
    for who, state in zip(every, starts, strict=True):
        transform, velocity = pose(state)
        plant.SetFreeBodyPose(context, who, transform)
        plant.SetFreeBodySpatialVelocity(context, who, velocity)
    port = plant.get_applied_spatial_force_input_port()
    corners = np.hstack([craft["arm_length"] * CORNERS, np.zeros((4, 1))])
    rows = []
    between = round(0.01 / step)
    for k in range(between * (ROWS - 1) + 1):
        poses = [plant.EvalBodyPoseInWorld(context, who) for who in every]
        if k % between == 0:
            rows.append(np.concatenate([p.translation() for p in poses]))
        moving = [
            plant.EvalBodySpatialVelocityInWorld(context, who).translational() for who in every
        ]
        forces = [push(every, 0, np.zeros(3), -DRAG["payload_drag"] * moving[0])]
        for i in range(n):
            up = poses[i + 1].rotation().matrix()[:, 2]
            air = moving[i + 1]
            drag = -DRAG["vehicle_drag"] * air
            drag = drag - ROTOR_DRAG * speeds[i, :, k].sum() * (air - (up @ air) * up)
            forces.append(push(every, i + 1, np.zeros(3), drag))
            turning = 0.5 * (speeds[i, :, k] + speeds[i, :, k + 1])
            for at, sense, speed in zip(corners, SENSES, turning, strict=True):
                thrust = craft["thrust_coefficient"][i] * speed**2
                forces.append(
                    push(every, i + 1, at, thrust * up, sense * craft["torque_ratio"] * thrust * up)
                )
        port.FixValue(context, Value[list[ExternallyAppliedSpatialForce]](forces))
        plant.ExecuteForcedEvents(context)  # one discrete step
        context.SetTime(step * (k + 1))
    return np.array(rows)


@pytest.mark.parametrize("n", [2, 3, 6])
def test_drake_s_first_order_steps_approach_ours(n):
    off = {}
    for step in (1e-3, 5e-4):
        off[step] = engine_flight(n, step) - our_rows(n, False, step)[:ROWS, : 3 + 3 * n]
    assert np.ptp(our_rows(n, False, 1e-3)[:ROWS, :3], axis=0).max() > 0.02  # it flies
    sizes = [np.abs(each).max() for each in off.values()]
    assert sizes[0] / sizes[1] == pytest.approx(2.0, rel=0.05)
    # Twice the finer less the coarser: of second order, a fiftieth of the first here.
    assert np.abs(2 * off[5e-4] - off[1e-3]).max() < 0.02 * sizes[1]
