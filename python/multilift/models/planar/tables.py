"""The tables of a planar scenario; plant, gains, actuators and sensors as the core has them."""

from __future__ import annotations

import numpy as np

from multilift import _core, pushes
from multilift.fields import Field
from multilift.models import LawInfo
from multilift.schema import SIMULATION, Table, core_fields

PLANT = Table(
    "plant",
    "the vehicles, cables and bar (paper, section 2)",
    (
        Field("model", "which plant", "text", default="planar", choices=("planar",)),
        *core_fields(_core.planar_plant_fields()),
    ),
)
#: The plant's numbers, in the core's order.
PLANT_NUMBERS = PLANT.fields[1:]

START = Table(
    "start",
    "where the system starts; it must satisfy the bar's closure",
    (
        Field("vehicle_position", "(y, z) of vehicles 1 and 2", shape=(2, 2), unit="m",
              required=True),
        Field("angle", "theta1, theta2, theta3; left out: the load hangs at rest below the "
              "vehicles", shape=(3,), unit="rad"),
        Field("vehicle_velocity", "(y, z) velocities of the vehicles; left out: at rest",
              shape=(2, 2), unit="m/s"),
        Field("angle_rate", "rates of the three angles; left out: at rest", shape=(3,),
              unit="rad/s"),
    ),
)  # fmt: skip
GOAL = Table(
    "goal",
    "where the vehicles shall come to rest, equation (17)",
    (
        Field("vehicle_position", "(y, z) of vehicles 1 and 2", shape=(2, 2), unit="m",
              required=True),
        Field("allow_mismatch", "accept goals that break (17): y2 - y1 = bar length, "
              "z1 - l1 = z2 - l2; the load then hangs with nonzero angles", "flag", default=False),
    ),
)  # fmt: skip
REFERENCE = Table(
    "reference",
    "how the bar's target gets to the goal, the vehicles with it",
    (
        Field("kind", "step: at once; flat: one smooth move; least_snap: one with the least "
              "greatest snap, from rest; zv, zvd, ei: the vehicles' smooth move split by an input "
              "shaper; antiswing: a move in two parts, from any state of swing; waypoints: "
              "smoothly through all", "text", default="step",
              choices=("step", "flat", "least_snap", "zv", "zvd", "ei", "antiswing",
                       "waypoints")),
        Field("start", "when it begins", unit="s", range="non_negative", default=0.0),
        Field("duration", "of flat and least_snap; left out: the shortest within the limits",
              unit="s", range="positive"),
        Field("speed_max", "of the bar's way if flat or least_snap, of the vehicles' if shaped or "
              "antiswing", unit="m/s", range="positive", default=1.0),
        Field("acceleration_max", "likewise", unit="m/s^2", range="positive", default=1.0),
        Field("jerk_max", "likewise", unit="m/s^3", range="positive", default=4.0),
        Field("snap_max", "likewise; antiswing has none for its second part", unit="m/s^4",
              range="positive", default=np.inf),
        Field("tolerance", "of ei: what it leaves of the swing where frequency and damping are "
              "right, below 1", range="non_negative", default=0.05),
        Field("damping_ratio", "of antiswing, as a part of the swing's critical damping, below 1",
              range="positive", default=0.7),
        Field("lead", "by how much the law gives the forces along the way ahead of time, for "
              "actuators that lag", unit="s", range="non_negative", default=0.0),
        Field("measured_delay", "how old the law takes its measurements to be: it compares them "
              "with where the target was then", unit="s", range="non_negative", default=0.0),
        Field("damping", "of flat and waypoints: whether the forces along the way make up for the "
              "vehicles' drag and the cables' swing damping, as the law assumes them; needs "
              "controller.d_hat_start = 0", "flag", default=False),
        Field("times", "of waypoints: when each is reached; of flat: when the goal jumps to "
              "each; ascending, after start", kind="list",
              unit="s"),
        Field("points", "of waypoints, and of flat with a goal that jumps: y and z of vehicle 1 at "
              "each, one after the other; the last one is its goal", kind="list"),
    ),
)  # fmt: skip
ACTUATORS = Table(
    "actuators",
    "from the command u to thrust and attitude; left out: u acts at once, without limits",
    core_fields(_core.planar_actuator_fields()),
)
SENSORS = Table(
    "sensors",
    "what the law is told; left out: the truth at each control instant",
    core_fields(_core.planar_sensor_fields()),
)
ASSUMED = Table(
    "controller.assumed",
    "the plant as the law believes it to be; by default the true one",
    PLANT.fields,
    follows="plant",
)
PUSH = Table(
    "push",
    "an outside force as a function of time; one [[push]] each",
    (
        Field("body", "what it acts on", "text", required=True,
              choices=("bar", "vehicle_1", "vehicle_2")),
        pushes.START,
        pushes.DURATION,
        Field("force", "(y, z) at the body's centre of mass", shape=(2,), unit="N",
              default=[0.0, 0.0]),
        Field("torque", "about x, from y towards z; bar only", unit="N m", default=0.0),
        *pushes.PROFILE,
    ),
    repeated=True,
)  # fmt: skip
#: A push's numbers, in the core's order.
PUSH_NUMBERS = tuple(
    PUSH.field(name) for name in ("force", "torque", "start", "duration", "frequency")
)

TABLES = {
    t.name: t
    for t in (PLANT, START, GOAL, REFERENCE, SIMULATION, ACTUATORS, SENSORS, ASSUMED, PUSH)
}
LAWS = {
    name: LawInfo(title, core_fields(gains)) for name, (title, gains) in _core.planar_laws().items()
}
