"""The maker's client and `motioncapture` against our RT server, each in a process of its own."""

import asyncio
import fcntl
import math
import tempfile
import time
from pathlib import Path

import pytest
from multilift.flight.estimate.config import Tuning
from multilift.flight.estimate.estimator import Estimator, Verdict
from multilift.flight.estimate.state import Quality
from multilift.flight.mocap import rotations
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Frame, Pose
from multilift.flight.mocap.pipe import frame_from_bytes, frame_to_bytes
from multilift.flight.mocap.rt_server import RTServer
from multilift.flight.mocap.settings import Axes, Mount, Settings
from multilift.flight.mocap.source import CaptureSource

pytest.importorskip("qtm_rt", reason="needs multilift[fly]")
pytest.importorskip("motioncapture", reason="needs multilift[fly]")

TURN = rotations.from_vector((0.4, -0.3, 1.1))
#: Single precision of a few metres in millimetres, and of a quaternion.
METRES, TURNS = 1e-6, 1e-6

SYSTEMS = [("qualisys", ""), ("motioncapture", "qualisys")]


@pytest.fixture(scope="module", autouse=True)
def udp_port():
    """`motioncapture` always listens on the same port: one test of it at a time."""
    with (Path(tempfile.gettempdir()) / "multilift-6734.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def position(t):
    return (1.0 + 0.5 * math.sin(t), -2.0 + 0.3 * math.cos(t), 0.25 + 0.1 * t)


def flown(test):
    """Runs a test beside a server whose capture clock is the wall's, from zero."""

    async def beside():
        server = RTServer(["QTM drone", "unseen", "load & bar"])
        port = await server.start(port=0)
        start = time.monotonic()

        async def publish():
            while True:
                t = time.monotonic() - start
                server.publish(t, [Pose(position(t), TURN, 3e-4), None, Pose((0.0, 0.0, 0.1))])
                await asyncio.sleep(0.005)

        publishing = asyncio.create_task(publish())
        try:
            await test(server, port)
        finally:
            publishing.cancel()
            await server.stop()

    asyncio.run(asyncio.wait_for(beside(), 60))


BODIES = {"vehicle_1": "QTM drone", "vehicle_2": "unseen", "payload": "load & bar"}


@pytest.mark.parametrize(("system", "kind"), SYSTEMS)
def test_what_the_cameras_saw_arrives_in_metres(system, kind):
    async def test(server, port):
        del server
        source = CaptureSource(Settings(system, BODIES, kind, port=port))
        await source.open()
        numbers, heights = [], []
        for _ in range(50):
            frame = await source.next()
            assert set(frame.bodies) == {"vehicle_1", "payload"}
            pose = frame.bodies["vehicle_1"]
            t = (pose.position[2] - 0.25) / 0.1
            assert pose.position == pytest.approx(position(t), abs=2 * METRES)
            assert pose.attitude == pytest.approx(TURN, abs=TURNS)
            assert frame.bodies["payload"].position == pytest.approx((0, 0, 0.1), abs=METRES)
            if system == "qualisys":
                assert frame.capture_time == pytest.approx(t, abs=2 * METRES / 0.1)
                assert pose.residual == pytest.approx(3e-4, rel=1e-6)
                numbers.append(frame.number)
            heights.append(t)
            assert frame.received_time <= time.monotonic()
        assert heights == sorted(set(heights))
        assert numbers == sorted(set(numbers))
        assert source.malformed == 0
        await source.close()
        await source.close()

    flown(test)


def test_estimates_from_the_wire_are_near_the_truth():
    async def test(server, port):
        del server
        source = CaptureSource(Settings("qualisys", {"vehicle_1": "QTM drone"}, port=port))
        await source.open()
        estimator, differences = Estimator(["vehicle_1"]), []
        sound = 0
        while sound < 100:
            frame = await source.next()
            verdict = estimator.accept(frame)
            differences.append(frame.received_time - frame.capture_time)
            now = time.monotonic()
            body = estimator.at(now).bodies["vehicle_1"]
            if verdict is Verdict.NEW and body.standing.quality is Quality.GOOD:
                t = now - min(differences) + Tuning().latency
                # 3.5 sigmas of the noise for which the filter is made; this stream has none
                assert math.dist(body.position, position(t)) < 2e-3
                sound += 1
        await source.close()

    flown(test)


def test_axes_are_turned_at_the_edge():
    quarter = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    axes = Axes((0.0, 0.0, 1.0), quarter, {"payload": Mount((0.0, 0.0, -0.1))})
    seen = Pose((1.0, 2.0, 3.0), TURN)
    ours = axes.ours("vehicle_1", seen)
    assert ours.position == pytest.approx((-2.0, 1.0, 4.0))
    there = rotations.turned(quarter, rotations.turned(TURN, (1.0, 0.0, 0.0)))
    assert rotations.turned(ours.attitude, (1.0, 0.0, 0.0)) == pytest.approx(there)
    mounted = axes.ours("payload", Pose((0.0, 0.0, 0.1)))
    assert mounted.position == pytest.approx((0.0, 0.0, 1.0))
    settings = Settings("qualisys", BODIES, axes=axes)
    assert Settings.from_json(settings.to_json()) == settings


def test_a_body_that_is_not_there_is_named_with_those_that_are():
    async def test(server, port):
        del server
        source = CaptureSource(Settings("qualisys", {"payload": "load"}, port=port))
        with pytest.raises(CaptureError, match="'load' for payload") as raised:
            await source.open()
        assert "QTM drone, unseen, load & bar" in str(raised.value)

    flown(test)


@pytest.mark.parametrize(("system", "kind"), SYSTEMS)
def test_a_server_that_is_not_there_is_one_clear_error(system, kind):
    async def test(server, port):
        await server.stop()
        source = CaptureSource(Settings(system, BODIES, kind, port=port))
        with pytest.raises(CaptureError, match="what to do"):
            await source.open()

    flown(test)


@pytest.mark.parametrize(("system", "kind"), SYSTEMS)
def test_a_server_that_goes_away_never_holds_up_the_reader(system, kind):
    async def test(server, port):
        source = CaptureSource(Settings(system, BODIES, kind, port=port))
        await source.open()
        await server.stop()
        if system == "qualisys":
            with pytest.raises(CaptureError, match="closed the connection"):
                while True:
                    await source.next()
        await source.close()  # however busy the client is with waiting

    flown(test)


def test_who_reads_late_reads_new():
    async def test(server, port):
        source = CaptureSource(Settings("qualisys", BODIES, port=port))
        await source.open()
        while source.dropped < 5:
            await asyncio.sleep(0.01)
        number = server.latest.number
        frames = source.drain()
        assert len(frames) <= 32
        assert frames[-1].number > number - 32
        assert source.drain() == []
        await source.close()

    flown(test)


def test_a_packet_without_size_stalls_the_makers_client_and_not_us():
    async def test():
        async def lie(reader, writer):
            del reader
            greeting = b"QTM RT Interface connected\0"
            writer.write((8 + len(greeting)).to_bytes(4, "little") + b"\1\0\0\0" + greeting)
            writer.write(bytes(8))
            await writer.drain()

        server = await asyncio.start_server(lie, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        source = CaptureSource(Settings("qualisys", BODIES, port=port))
        with pytest.raises(CaptureError, match="no frame within"):
            await source.open(timeout=2.0)
        server.close()

    asyncio.run(asyncio.wait_for(test(), 60))


def test_frames_come_out_of_the_pipe_as_they_went_in():
    for frame in (
        Frame(7, 1.5, 100.25, {"payload": Pose((1.0, 2.0, 3.0), TURN, 1e-4)}),
        Frame(None, None, 3.0, {}),
    ):
        data = frame_to_bytes(frame, tuple(BODIES))
        assert frame_from_bytes(data, tuple(BODIES)) == frame
        with pytest.raises(ValueError, match="not whole"):
            frame_from_bytes(data[:-1], tuple(BODIES))
