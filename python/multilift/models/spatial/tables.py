"""The tables of a spatial scenario; what the equations take is described by the core."""

from __future__ import annotations

from dataclasses import replace

from multilift import _core, pushes
from multilift.fields import Field
from multilift.models import LawInfo
from multilift.schema import SIMULATION, Table, core_fields

_CORE = _core.spatial_fields()

#: How many vehicles there may be.
MOST_VEHICLES = 64


def _optional(fields: tuple[Field, ...]) -> tuple[Field, ...]:
    """Fields that need no value as long as nothing asks for one; see `checks`."""
    return tuple(replace(f, required=False) for f in fields)


PLANT = Table(
    "plant",
    "payload, cables and the vehicles' masses; world x east, y north, z up",
    (
        Field("model", "which plant", "text", default="spatial", choices=("spatial",)),
        Field("vehicles", "how many vehicles carry the payload", "whole", default=2, least=1,
              most=MOST_VEHICLES, size="n"),
        Field("cables", "rigid: constant length while taut, impacts when pulled taut; elastic: "
              "spring and damper while stretched", "text", default="rigid",
              choices=("rigid", "elastic")),
        *core_fields(_CORE["plant"]),
    ),
)  # fmt: skip
VEHICLE = Table(
    "vehicle",
    "what the vehicles are; all of one kind, their numbers each its own",
    (
        Field("kind", "ideal: the commanded force acts at once; quadrotor: rigid body, rotors, "
              "autopilot", "text", default="ideal", choices=("ideal", "quadrotor")),
        Field("type", "name of a shipped vehicle, or a file like it, that gives what is not given "
              "here", "text", default=""),
        *_optional(core_fields(_CORE["quadrotor"])),
    ),
)  # fmt: skip
AUTOPILOT = Table(
    "autopilot",
    "a quadrotor's own attitude and rate control, in PX4's cascade",
    (
        Field("rate", "how often it is stepped", unit="Hz", range="positive", default=1000.0),
        *core_fields(_CORE["autopilot"]),
    ),
)
FORMATION = Table(
    "formation",
    "how the cables lean at rest, which places the vehicles about the level payload",
    (
        Field("tilt", "of each cable from the vertical, outwards", shape=("n",), unit="rad",
              default=0.0, range="non_negative"),
        Field("azimuth", "to where each cable leans, from the payload's x towards its y; left out: "
              "away from the payload's centre, or evenly about a point", shape=("n",), unit="rad"),
    ),
)  # fmt: skip
START = Table(
    "start",
    "where everything starts; left out: in formation and at rest",
    (
        Field("payload_position", "of the payload's centre of mass", shape=(3,), unit="m",
              required=True),
        Field("payload_yaw", "heading of the payload", unit="rad", default=0.0),
        Field("payload_velocity", "of the payload", shape=(3,), unit="m/s",
              default=[0.0, 0.0, 0.0]),
        Field("payload_rate", "angular rate of the payload, its frame", shape=(3,), unit="rad/s",
              default=[0.0, 0.0, 0.0]),
        Field("vehicle_position", "of each vehicle; left out: in formation", shape=("n", 3),
              unit="m"),
        Field("vehicle_velocity", "of each vehicle; left out: the payload's", shape=("n", 3),
              unit="m/s"),
        Field("rotors", "running: they hold their share of the load; stopped: as before take-off",
              "text", default="running", choices=("running", "stopped")),
    ),
)  # fmt: skip
GOAL = Table(
    "goal",
    "where the payload shall come to rest, level",
    (
        Field("payload_position", "of its centre of mass", shape=(3,), unit="m", required=True),
        Field("payload_yaw", "its heading", unit="rad", default=0.0),
    ),
)
REFERENCE = Table(
    "reference",
    "how the payload's target gets to the goal, the formation with it",
    (
        Field("kind", "step: at once; min_snap: one smooth move; jerk_limited: as fast as the "
              "limits let it; waypoints: smoothly through all; circle, figure_eight: around from "
              "the goal and back", "text", default="step",
              choices=("step", "min_snap", "jerk_limited", "waypoints", "circle", "figure_eight")),
        Field("start", "when it begins", unit="s", range="non_negative", default=0.0),
        Field("duration", "of min_snap, circle and figure_eight", unit="s", range="positive"),
        Field("speed_max", "of jerk_limited", unit="m/s", range="positive", default=1.0),
        Field("acceleration_max", "of jerk_limited", unit="m/s^2", range="positive", default=1.0),
        Field("jerk_max", "of jerk_limited", unit="m/s^3", range="positive", default=4.0),
        Field("radius", "of circle; half the length of figure_eight", unit="m", range="positive",
              default=1.0),
        Field("laps", "of circle and figure_eight", range="positive", default=1.0),
        Field("times", "of waypoints: when each is reached, ascending, after start", kind="list",
              unit="s"),
        Field("points", "of waypoints: x, y, z and yaw of each, one after the other; the last one "
              "is the goal", kind="list"),
    ),
)  # fmt: skip
GROUND = Table(
    "ground",
    "a level floor",
    (
        Field("present", "whether there is one", "flag", default=False),
        *core_fields(_CORE["ground"]),
    ),
)
LINK = Table("link", "from the law to the vehicles; left out: at once", core_fields(_CORE["link"]))
LIMITS = Table("limits", "of the commanded forces; left out: none", core_fields(_CORE["limits"]))
MOTION_CAPTURE = Table(
    "motion_capture",
    "what the law is told; left out: the truth at each control instant",
    core_fields(_CORE["motion_capture"]),
)
WIND = Table("wind", "the air's motion; left out: calm", core_fields(_CORE["wind"]))
SAFETY = Table(
    "safety", "what ends a run as a collision; left out: nothing", core_fields(_CORE["safety"])
)
ASSUMED = Table(
    "controller.assumed",
    "the plant as the law believes it to be; by default the true one",
    # How many vehicles there are, [plant] alone says.
    tuple(replace(f, size="") for f in PLANT.fields),
    follows="plant",
)
PUSH = Table(
    "push",
    "an outside force as a function of time; one [[push]] each",
    (
        Field("body", "what it acts on", "text", required=True, choices=("payload", "vehicle_{n}")),
        pushes.START,
        pushes.DURATION,
        Field("force", "at the body's centre of mass, world axes", shape=(3,), unit="N",
              default=[0.0, 0.0, 0.0]),
        Field("torque", "in the payload's frame; payload only", shape=(3,), unit="N m",
              default=[0.0, 0.0, 0.0]),
        *pushes.PROFILE,
    ),
    repeated=True,
)  # fmt: skip
EVENT = Table(
    "event",
    "something that breaks for good; one [[event]] each",
    (
        Field("kind", "cable_cut, rotor_stopped (quadrotors), or vehicle_lost: all its rotors stop",
              "text", required=True, choices=("cable_cut", "rotor_stopped", "vehicle_lost")),
        Field("time", "when", unit="s", range="non_negative", required=True),
        Field("vehicle", "whose, such as vehicle_1", "text", required=True,
              choices=("vehicle_{n}",)),
        Field("rotor", "which, counted from 1", "whole", default=1, least=1, most=4),
    ),
    repeated=True,
)  # fmt: skip

#: Numbers in the core's order.
PLANT_NUMBERS = PLANT.fields[3:]
VEHICLE_NUMBERS = VEHICLE.fields[2:]
AUTOPILOT_NUMBERS = AUTOPILOT.fields[1:]
GROUND_NUMBERS = GROUND.fields[1:]
PUSH_NUMBERS = tuple(
    PUSH.field(name) for name in ("force", "torque", "start", "duration", "frequency")
)

TABLES = {
    t.name: t
    for t in (PLANT, VEHICLE, AUTOPILOT, FORMATION, START, GOAL, REFERENCE, SIMULATION, LIMITS,
              LINK, MOTION_CAPTURE, WIND, GROUND, SAFETY, ASSUMED, PUSH, EVENT)
}  # fmt: skip
LAWS = {
    name: LawInfo(title, core_fields(gains))
    for name, (title, gains) in _core.spatial_laws().items()
}
