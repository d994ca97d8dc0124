"""ULog files, written by the published format: header, flags, formats, subscriptions, data."""

import struct

import numpy as np


def message(kind, content):
    return struct.pack("<HB", len(content), ord(kind)) + content


def _fields(name):
    """The fields of a topic's format, each of so many floats."""
    if name == "vehicle_attitude":
        return [("q", 4)]
    if name == "vehicle_attitude_setpoint":
        return [("q_d", 4), ("thrust_body", 3)]
    return [(axis, 1) for axis in "xyz"]


def _format(name):
    fields = "".join(
        f"float[{size}] {field};" if size > 1 else f"float {field};"
        for field, size in _fields(name)
    )
    return message("F", f"{name}:uint64_t timestamp;{fields}".encode())


def write(topics, start=0):
    """The bytes of a log.

    Args:
        topics: times in s and rows of floats, by the topic's name.
        start: of the log, microseconds since the autopilot booted.
    """
    out = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", start), message("B", bytes(40))]
    out += [_format(name) for name in topics]
    out.append(message("I", bytes([len(b"char[4] sys_name")]) + b"char[4] sys_name" + b"test"))
    records = []
    for number, (name, (t, rows)) in enumerate(topics.items()):
        out.append(message("A", struct.pack("<BH", 0, number) + name.encode()))
        for time, row in zip(t, rows, strict=True):
            stamp = round(time * 1e6)
            records.append((stamp, struct.pack(f"<HQ{len(row)}f", number, stamp, *row)))
    out += [message("D", data) for _stamp, data in sorted(records, key=lambda r: r[0])]
    return b"".join(out)


def turned(q):
    """FLU in ENU to FRD in NED, by the product of quaternions."""
    half = np.sqrt(0.5)
    before, behind = np.array([0.0, half, half, 0.0]), np.array([0.0, 1.0, 0.0, 0.0])
    return product(product(np.broadcast_to(before, q.shape), q), np.broadcast_to(behind, q.shape))


def product(a, b):
    (aw, ax, ay, az), (bw, bx, by, bz) = a.T, b.T
    return np.column_stack([
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ])  # fmt: skip
