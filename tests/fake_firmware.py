"""Minimal firmware that speaks both physics protocols as PX4 and ArduPilot do, and flies.

Run as ``python fake_firmware.py px4|ardupilot`` with the arguments the real ones are given. It
takes off to where FAKE_TARGETS says ("north,east,down;..." one for each instance, from
FAKE_FIRST on) and stays there. It shares no code with the package: frames, motor numbers and
messages are written again from the firmwares' documents.
"""

import json
import math
import os
import socket
import struct
import sys
import time
from pathlib import Path

ARM_AT = 0.5
#: When it goes to above the load, with slack cables, and when it lifts it; and until when.
GO, GONE, LIFT, LIFTED = 1.0, 3.0, 3.5, 7.0
SLACK_HEIGHT = -0.6
GRAVITY = 9.8
#: Of motors 1 to 4 of a quad X, FRD: what more thrust does to roll, pitch and yaw.
MIXER = ((-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1))


def rotate(q, v):
    w, x, y, z = q
    a, b, c = v
    d, e, f = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return (a + w * d + y * f - z * e, b + w * e + z * d - x * f, c + w * f + x * e - y * d)


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def turned(q, rate, dt):
    w, x, y, z = q
    p, r, s = (0.5 * dt * u for u in rate)
    q = (w - x * p - y * r - z * s, x + w * p + y * s - z * r, y + w * r + z * p - x * s,
         z + w * s + x * r - y * p)  # fmt: skip
    size = math.sqrt(sum(u * u for u in q))
    return tuple(u / size for u in q)


def from_euler(roll, pitch, yaw):
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy)  # fmt: skip


def part(t, begin, end):
    """From 0 to 1, at rest at both ends."""
    u = min(max((t - begin) / (end - begin), 0.0), 1.0)
    return u * u * (3.0 - 2.0 * u)


class Pilot:
    """Position, attitude and rate control in NED and FRD."""

    def __init__(self, target, hover):
        self.target, self.hover = target, hover
        self.start = self.yaw = None
        self.sum = [0.0, 0.0, 0.0]

    def step(self, t, dt, position, velocity, q, gyro):
        w, x, y, z = q
        yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        if self.start is None:
            self.start, self.yaw = position, yaw
        flying = t > GO
        gone, lifted = part(t, GO, GONE), part(t, LIFT, LIFTED)
        above = (*self.target[:2], SLACK_HEIGHT)
        force = []
        for k in range(3):
            wanted = (
                self.start[k]
                + gone * (above[k] - self.start[k])
                + lifted * (self.target[k] - above[k])
            )
            off = wanted - position[k]
            if flying:
                self.sum[k] += 1.0 * off * dt
            force.append(3.0 * off - 3.0 * velocity[k] + self.sum[k])
        force[2] -= GRAVITY
        size = math.sqrt(sum(f * f for f in force))
        down = tuple(-f / size for f in force)
        # Where body z has to go, as seen from the body: the cross product turns it there.
        seen = rotate(conjugate(q), down)
        tilt = (-seen[1], seen[0])
        error = (self.yaw - yaw + math.pi) % (2 * math.pi) - math.pi
        torque = (
            0.04 * (6.0 * tilt[0] - gyro[0]),
            0.04 * (6.0 * tilt[1] - gyro[1]),
            0.2 * (1.5 * error - gyro[2]),
        )
        level = self.hover * size / GRAVITY if flying else 0.02
        motors = []
        for roll, pitch, spin in MIXER:
            share = level + roll * torque[0] + pitch * torque[1] + spin * torque[2]
            motors.append(math.sqrt(min(max(share, 0.0004), 1.0)))
        return motors


def target_of(instance):
    all_of_them = os.environ["FAKE_TARGETS"].split(";")
    return tuple(map(float, all_of_them[instance - int(os.environ["FAKE_FIRST"])].split(",")))


class Estimate:
    """Position, velocity and attitude from gyroscope, accelerometer and motion capture."""

    def __init__(self):
        self.q = None
        self.position, self.velocity = [0.0] * 3, [0.0] * 3

    def predict(self, dt, gyro, accel):
        if self.q is None:
            return
        self.q = turned(self.q, gyro, dt)
        felt = rotate(self.q, accel)
        for k, gravity in enumerate((0.0, 0.0, GRAVITY)):
            self.position[k] += dt * self.velocity[k]
            self.velocity[k] += dt * (felt[k] + gravity)

    def see(self, pose):
        seen = from_euler(pose.roll, pose.pitch, pose.yaw)
        if self.q is None:
            self.q, self.position = seen, [pose.x, pose.y, pose.z]
        sign = math.copysign(0.1, sum(a * b for a, b in zip(self.q, seen, strict=True)))
        q = [0.9 * a + sign * b for a, b in zip(self.q, seen, strict=True)]
        size = math.sqrt(sum(u * u for u in q))
        self.q = tuple(u / size for u in q)
        for k, place in enumerate((pose.x, pose.y, pose.z)):
            # Seen 10 ms ago.
            off = place + 0.01 * self.velocity[k] - self.position[k]
            self.position[k] += 0.3 * off
            self.velocity[k] += 1.0 * off


def connected(port):
    while True:
        try:
            wire = socket.create_connection(("127.0.0.1", port), 30)
            break
        except ConnectionRefusedError:
            time.sleep(0.02)
    wire.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    print(os.getpid(), flush=True)
    return wire


def messages(wire, mav):
    while data := wire.recv(65536):
        yield from mav.parse_buffer(data) or []


def px4(arguments):
    from pymavlink.dialects.v20 import common

    instance = int(arguments[arguments.index("-i") + 1])
    assert Path(arguments[arguments.index("-d") + 1]).is_dir()
    pilot = Pilot(target_of(instance), float(os.environ["PX4_PARAM_MPC_THR_HOVER"]))
    mav = common.MAVLink(None, srcSystem=int(os.environ["PX4_PARAM_MAV_SYS_ID"]), srcComponent=1)
    wire = connected(4560 + instance)

    def send(message):
        wire.sendall(message.pack(mav))
        mav.seq = (mav.seq + 1) % 256

    send(common.MAVLink_command_long_message(0, 0, 511, 0, 115, 5000, 0, 0, 0, 0, 0))
    send(common.MAVLink_heartbeat_message(0, 12, 0, 0, 0, 3))
    # A real one starts its outputs later than its sensors.
    starting, last, estimate = 40, None, Estimate()
    for m in messages(wire, mav):
        if m.get_type() == "VISION_POSITION_ESTIMATE":
            estimate.see(m)
        if m.get_type() != "HIL_SENSOR":
            continue
        assert m.fields_updated & 0b111111 == 0b111111
        now = m.time_usec / 1e6
        dt, last = (now - last if last else 0.0), now
        gyro = (m.xgyro, m.ygyro, m.zgyro)
        estimate.predict(dt, gyro, (m.xacc, m.yacc, m.zacc))
        starting -= 1
        if starting > 0:
            continue
        armed, e = now > ARM_AT, estimate
        out = pilot.step(now, dt, tuple(e.position), e.velocity, e.q, gyro) if armed else [0.0] * 4
        mode = 1 | (128 if armed else 0)
        send(common.MAVLink_hil_actuator_controls_message(m.time_usec, out + [0.0] * 12, mode, 1))


def ardupilot(arguments):
    instance = int(arguments[arguments.index("--instance") + 1])
    text = Path(arguments[arguments.index("--defaults") + 1]).read_text(encoding="utf-8")
    parameters = {k: float(v) for k, v in map(str.split, text.splitlines())}
    pilot = Pilot(target_of(instance), parameters["MOT_THST_HOVER"])
    rate = int(parameters["SIM_RATE_HZ"])
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    wire.connect(("127.0.0.1", 9002 + 10 * instance))
    wire.settimeout(1.0)
    pwm, frame, last = [1000] * 16, 0, None
    while True:
        packet = struct.pack("<HHI16H", 18458, rate, frame, *pwm)
        while True:
            try:
                wire.send(packet)
                state = json.loads(wire.recv(65536))
                break
            except (TimeoutError, ConnectionRefusedError):
                time.sleep(0.02)
        frame += 1
        now = state["timestamp"]
        dt, last = (now - last if last else 0.0), now
        if now > ARM_AT:
            motors = pilot.step(now, dt, tuple(state["position"]), state["velocity"],
                                state["quaternion"], state["imu"]["gyro"])  # fmt: skip
            pwm[:4] = [round(1000 + 1000 * u) for u in motors]


if __name__ == "__main__":
    {"px4": px4, "ardupilot": ardupilot}[sys.argv[1]](sys.argv[2:])
