"""The tables of a planar scenario; plant, gains, actuators and sensors as the core has them."""

from __future__ import annotations

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
    t.name: t for t in (PLANT, START, GOAL, SIMULATION, ACTUATORS, SENSORS, ASSUMED, PUSH)
}  # fmt: skip
LAWS = {
    name: LawInfo(title, core_fields(gains)) for name, (title, gains) in _core.planar_laws().items()
}
