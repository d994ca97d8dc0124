"""A payload on limited tendons under quadrotors, as MuJoCo models it."""

import numpy as np
from spatial_rows import GRAVITY

#: Corners of an X frame from the front left, counterclockwise, per arm; the first rotor's drag
#: turns its vehicle counterclockwise, the next one's clockwise.
CORNERS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) / np.sqrt(2.0)
SENSES = (1.0, -1.0, 1.0, -1.0)


def engine(mujoco, plant, step, softness, craft):
    """Model and data. Tendons yield with a critically damped time constant `softness`, s.

    Args:
        plant: as the core's table, complete where it is used here.
        craft: of quadrotors with X frames: inertia (n, 3), arm_length, torque_ratio; their rotors
            are actuators, four a vehicle, whose controls are thrusts, N.
    """
    n = len(plant["vehicle_mass"])
    inertia, corners = craft["inertia"], craft["arm_length"] * CORNERS
    vehicles = "".join(
        f'<body name="v{i}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{plant["vehicle_mass"][i]}" diaginertia="{row(inertia[i])}"/>'
        f'<site name="v{i}"/>'
        + "".join(f'<site name="r{i}_{k}" pos="{row(at)} 0"/>' for k, at in enumerate(corners))
        + "</body>"
        for i in range(n)
    )
    ties = "".join(f'<site name="t{i}" pos="{row(plant["attachment"][i])}"/>' for i in range(n))
    tendons = "".join(
        f'<spatial limited="true" range="0 {plant["cable_length"][i]}"'
        f' solreflimit="{softness} 1" solimplimit="0.9999 0.9999 0.001">'
        f'<site site="t{i}"/><site site="v{i}"/></spatial>'
        for i in range(n)
    )
    rotors = "".join(
        f'<motor site="r{i}_{k}" gear="0 0 1 0 0 {SENSES[k] * craft["torque_ratio"]}"/>'
        for i in range(n)
        for k in range(len(corners))
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" gravity="0 0 -{GRAVITY}" integrator="RK4"'
        f' tolerance="1e-15" iterations="200"><flag contact="disable"/></option><worldbody>'
        f'<body name="load"><freejoint/><inertial pos="0 0 0" mass="{plant["payload_mass"]}"'
        f' diaginertia="{row(plant["payload_inertia"])}"/>{ties}</body>{vehicles}</worldbody>'
        f"<tendon>{tendons}</tendon><actuator>{rotors}</actuator></mujoco>"
    )
    return model, mujoco.MjData(model)


def row(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def bodies(data, n):
    """Positions and velocities of the vehicles, shape (n, 3) each."""
    place, speed = data.qpos[7:].reshape(n, 7), data.qvel[6:].reshape(n, 6)
    return place[:, :3].copy(), speed[:, :3].copy()
