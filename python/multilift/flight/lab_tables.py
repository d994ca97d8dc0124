"""The tables of a lab file."""

from __future__ import annotations

from multilift.fields import Field
from multilift.schema import Table

VEHICLE = Table(
    "vehicle",
    "one vehicle, in the scenario's order; one [[vehicle]] each, or none for a twin",
    (
        Field("system", "its MAVLink system id, exactly as the autopilot has it", "whole", least=1,
              most=250, required=True),
        Field("component", "the autopilot's component id", "whole", default=1, least=1, most=250),
        Field("address", "udpin:HOST:PORT listens, udpout:HOST:PORT sends first; left out: a twin",
              "text", default=""),
        Field("firmware", "of the autopilot", "text", default="px4", choices=("px4", "ardupilot")),
        Field("hover_thrust", "normalised thrust at which it hovers without load; left out: of the "
              "scenario's rotors, twins only", range="positive"),
        Field("thrust_curve", "its THR_MDL_FAC (PX4) or MOT_THST_EXPO (ArduPilot), 0 to 1; left "
              "out: autopilot.thrust_curve of the scenario", range="non_negative"),
        Field("battery_voltage", "at which hover_thrust was measured; 0: not compensated here",
              unit="V", range="non_negative", default=0.0),
        Field("body", "its name in the motion capture system; left out: vehicle_1, vehicle_2, ...",
              "text", default=""),
    ),
    repeated=True,
)  # fmt: skip
MOTION_CAPTURE = Table(
    "motion_capture",
    "where poses come from",
    (
        Field("system", "twin: simulated; qualisys: its RT server; motioncapture: what that "
              "library speaks to; autopilot: the vehicles' own estimate, the payload from capture",
              "text",
              default="twin", choices=("twin", "qualisys", "motioncapture", "autopilot")),
        Field("kind", "which system, where motioncapture is to speak to it", "text", default="",
              choices=("", "vicon", "optitrack", "qualisys", "nokov", "vrpn", "motionanalysis",
                       "fzmotion")),
        Field("host", "of its server", "text", default=""),
        Field("payload", "the payload's body", "text", default="payload"),
    ),
)  # fmt: skip
RATES = Table(
    "rates",
    "how often things are sent",
    (
        Field("setpoints", "attitude and thrust to each vehicle, 50 to 100", unit="Hz",
              range="positive", default=100.0),
        Field("pose", "captured pose to each vehicle, 30 to 50", unit="Hz", range="positive",
              default=40.0),
        Field("pose_message", "vision: VISION_POSITION_ESTIMATE; odometry: ODOMETRY", "text",
              default="vision", choices=("vision", "odometry")),
    ),
)  # fmt: skip
LIMITS = Table(
    "limits",
    "what, when passed, ends the flight of all vehicles: hold, then land apart",
    (
        Field("fence_low", "lowest x, y, z of any vehicle; twins: 3 m around the scenario",
              shape=(3,), unit="m"),
        Field("fence_high", "highest x, y, z of any vehicle", shape=(3,), unit="m"),
        Field("tilt", "of a vehicle from level", unit="rad", range="positive", default=0.7),
        Field("swing", "of a cable from the vertical", unit="rad", range="positive", default=0.8),
        Field("separation", "least distance between two vehicles", unit="m", range="positive",
              default=0.8),
        Field("speed", "of a vehicle", unit="m/s", range="positive", default=3.0),
        Field("saturation", "how long a command may lie on its bound", unit="s", range="positive",
              default=0.5),
        Field("state_age", "of what a set-point is computed from", unit="s", range="positive",
              default=0.1),
        Field("mocap_age", "of the last pose of any body", unit="s", range="positive",
              default=0.15),
        Field("link_age", "of the last heartbeat of any vehicle", unit="s", range="positive",
              default=2.5),
        Field("round_trip", "to a vehicle and back, the median of half a second", unit="s",
              range="positive", default=0.25),
        Field("hold", "how long to wait in hold before landing apart", unit="s", range="positive",
              default=3.0),
        Field("battery", "least charge at which to arm", range="non_negative", default=0.3),
    ),
)  # fmt: skip
SECURITY = Table(
    "security",
    "who may speak to the flight program",
    (
        Field("key_file", "32 bytes, or 64 hexadecimal digits, that sign every message; beside "
              "this file", "text", default=""),
        Field("allow_unsigned", "beyond this machine without a key", "flag", default=False),
        Field("system", "the ground station's own system id", "whole", default=255, least=1,
              most=255),
    ),
)  # fmt: skip

TABLES = {t.name: t for t in (VEHICLE, MOTION_CAPTURE, RATES, LIMITS, SECURITY)}
