"""Qualisys' protocol as bytes: packets, rotations, noise that does no harm."""

import asyncio
import math
import random

import pytest
import rt_fuzz
from hypothesis import given
from hypothesis import strategies as st
from multilift.flight.mocap import rotations
from multilift.flight.mocap import rt_protocol as rt
from multilift.flight.mocap.frames import Pose

#: Between rotations of double precision: a few rounding errors of acos near zero.
EPS = 1e-7

angle = st.floats(-math.pi, math.pi)
vector = st.tuples(*[st.floats(-3, 3)] * 3)
quaternion = st.builds(rotations.from_vector, st.tuples(*[st.floats(-1.8, 1.8)] * 3))


def between(p, q):
    """Angle between two rotations."""
    return math.hypot(*rotations.to_vector(rotations.product(rotations.inverse(p), q)))


@given(p=quaternion, q=quaternion, v=vector)
def test_rotations_are_a_group_that_acts_on_vectors(p, q, v):
    once = rotations.turned(p, rotations.turned(q, v))
    assert once == pytest.approx(rotations.turned(rotations.product(p, q), v), abs=1e-12)
    rows = rotations.matrix(q)
    by_rows = [sum(a * b for a, b in zip(row, v, strict=True)) for row in rows]
    assert rotations.turned(q, v) == pytest.approx(by_rows, abs=1e-12)
    assert between(rotations.from_matrix(rows), q) < EPS
    assert between(rotations.from_vector(rotations.to_vector(q)), q) < EPS


@given(q=quaternion)
def test_angles_are_roll_then_pitch_then_yaw(q):
    roll, pitch, yaw = rotations.to_angles(q)
    built = rotations.product(
        rotations.product(
            rotations.from_vector((roll, 0.0, 0.0)), rotations.from_vector((0.0, pitch, 0.0))
        ),
        rotations.from_vector((0.0, 0.0, yaw)),
    )
    # asin loses half the digits where its derivative has no bound
    assert between(built, q) < 1e-6


@given(
    sent=st.lists(st.tuples(st.integers(0, 12), st.binary(max_size=60)), max_size=8),
    cuts=st.lists(st.integers(1, 40), min_size=1),
)
def test_packets_come_out_as_they_went_in_however_they_are_cut(sent, cuts):
    data = b"".join(rt_fuzz.request(kind, content + b"\0") for kind, content in sent)
    reader, got, k = rt.RequestReader(), [], 0
    while data:
        n = cuts[k % len(cuts)]
        got += reader.feed(data[:n])
        data = data[n:]
        k += 1
    assert [(r.kind, r.content) for r in got] == sent


@pytest.mark.parametrize("size", [0, 7, rt.LARGEST_REQUEST + 1, 2**32 - 1])
def test_a_size_that_cannot_be_ends_the_connection(size):
    with pytest.raises(rt.RequestError):
        rt.RequestReader().feed(size.to_bytes(4, "little") + bytes(4))


@given(time=st.floats(0, 1e6), number=st.integers(1, 2**31), q=quaternion, position=vector)
def test_packets_say_their_own_size(time, number, q, position):
    capture = rt.Capture(number, time, (Pose(position, q, 1e-4), None))
    for names in [(name,) for name in rt.KINDS] + [tuple(rt.KINDS)]:
        packet = rt.data_packet(capture, names)
        assert int.from_bytes(packet[:4], "little") == len(packet)


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("allframes 6dres", rt.Stream(("6dres",))),
        ("frequencydivisor:4 6d 6deuler", rt.Stream(("6d", "6deuler"), divisor=4)),
        ("frequency:50 6d", rt.Stream(("6d",), period=0.02)),
        ("allframes udp:6734 6d", rt.Stream(("6d",), udp_port=6734)),
        ("allframes udp:::1:6734 6d", rt.Stream(("6d",), udp_port=6734, udp_host="::1")),
        ("", None),
        ("allframes", None),
        ("allframes skeleton", None),
        ("frequency:0 6d", None),
        ("frequency:٣ 6d", None),
        ("allframes udp:70000 6d", None),
        ("allframes udp: 6d", None),
    ],
)
def test_what_a_client_may_ask_to_be_streamed(text, meaning):
    assert rt.parse_stream(text.split()) == meaning


@given(seed=st.integers(0, 2**32))
def test_noise_is_answered_in_whole_packets_and_never_piles_up(seed):
    asyncio.run(rt_fuzz.attack_server(random.Random(seed), 200))
    rt_fuzz.attack_readers(random.Random(seed), 5)
