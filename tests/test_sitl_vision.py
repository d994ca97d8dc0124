"""Motion capture's poses on ArduPilot's own port."""

import math
import select
import socket

import pytest
from multilift.flight.sitl import geodesy
from multilift.flight.sitl.autopilot import Pose
from multilift.flight.sitl.vision import VisionPort
from pymavlink.dialects.v20 import common
from test_sitl_ardupilot_json import sample

POSE = Pose((1.0, 2.0, -3.0), (0.125, -0.25, 3.0))


@pytest.fixture
def port():
    made = VisionPort(4, port=0)
    yield made
    made.close()


@pytest.fixture
def autopilot(port):
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    wire.connect(("127.0.0.1", port.port))
    wire.settimeout(5.0)
    yield wire
    wire.close()


def read(wire, count):
    decoder = common.MAVLink(None)
    told = [m for _ in range(count) for m in decoder.parse_buffer(wire.recv(65536))]
    assert not select.select([wire], [], [], 0)[0]
    return told


def test_nothing_is_said_before_the_autopilot_has_been_heard(port):
    port.send(sample()._replace(pose=POSE))


def test_poses_are_told_as_they_are_after_where_they_begin(port, autopilot):
    autopilot.send(b"anything")
    assert select.select([port._socket], [], [], 5.0)[0]
    port.send(sample(1.0))  # without a pose
    port.send(sample(1.02)._replace(pose=POSE))
    origin, pose = read(autopilot, 2)
    assert origin.get_type() == "SET_GPS_GLOBAL_ORIGIN"
    assert origin.target_system == 5
    assert (origin.latitude, origin.altitude) == (473977420, round(geodesy.HOME.altitude * 1000))
    assert pose.get_type() == "VISION_POSITION_ESTIMATE"
    assert (pose.usec, pose.x, pose.y, pose.z) == (1020000, *POSE.position)
    assert (pose.roll, pose.pitch, pose.yaw) == POSE.euler
    assert all(map(math.isnan, pose.covariance))


def test_where_they_begin_is_told_again_once_a_second(port, autopilot):
    autopilot.send(b"anything")
    assert select.select([port._socket], [], [], 5.0)[0]
    for k in range(100):
        port.send(sample(0.02 * k)._replace(pose=POSE))
    kinds = [m.get_type() for m in read(autopilot, 102)]
    assert kinds.count("SET_GPS_GLOBAL_ORIGIN") == 2
    assert kinds.count("VISION_POSITION_ESTIMATE") == 100


def test_it_listens_on_loopback_only(port):
    assert port._socket.getsockname()[0] == "127.0.0.1"
