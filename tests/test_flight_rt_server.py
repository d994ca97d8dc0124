"""The RT server: many clients at once, slow ones and rude ones."""

import asyncio
import contextlib
import socket
import struct
from typing import ClassVar

import pytest
from multilift.flight.mocap import rt_protocol as rt
from multilift.flight.mocap import rt_server
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Pose
from multilift.flight.mocap.rt_server import RTServer
from rt_fuzz import request

POSES = [Pose((0.1, 0.2, 0.3)), None]


@contextlib.asynccontextmanager
async def serving():
    server = RTServer(["one", "two"])
    port = await server.start(port=0)
    try:
        yield server, port
    finally:
        await server.stop()
        while Client.open:
            await Client.open.pop().close()


class Client:
    """Speaks the protocol in plain bytes."""

    open: ClassVar[list] = []

    def __init__(self, reader, writer):
        self.reader, self.writer = reader, writer
        self.open.append(self)

    async def close(self):
        self.writer.close()
        with contextlib.suppress(ConnectionError):
            await self.writer.wait_closed()

    @classmethod
    async def connect(cls, port):
        client = cls(*await asyncio.open_connection("127.0.0.1", port))
        assert await client.receive() == (rt.Packet.COMMAND, b"QTM RT Interface connected\0")
        return client

    async def receive(self):
        size, kind = struct.unpack("<II", await self.reader.readexactly(8))
        return kind, await self.reader.readexactly(size - 8)

    def send(self, text):
        self.writer.write(request(1, text.encode() + b"\0"))

    async def ask(self, text):
        self.send(text)
        return await self.receive()

    async def stream(self, text):
        """Asks for frames, and returns when the server has understood."""
        self.send(text)
        await self.ask("qtmversion")

    async def numbers(self, count):
        return [struct.unpack_from("<qI", (await self.receive())[1])[1] for _ in range(count)]

    async def is_closed(self):
        return await self.reader.read() == b""


def run(test):
    asyncio.run(asyncio.wait_for(test(), 60))


def test_each_client_gets_the_frames_it_asked_for():
    async def test():
        async with serving() as (server, port):
            every, third, slower = [await Client.connect(port) for _ in range(3)]
            await every.stream("StreamFrames AllFrames 6D")
            await third.stream("StreamFrames FrequencyDivisor:3 6DRes")
            await slower.stream("StreamFrames Frequency:25 6DEuler")
            for k in range(24):
                server.publish(k * 0.01, POSES)
            assert await every.numbers(24) == list(range(1, 25))
            assert await third.numbers(8) == list(range(3, 25, 3))
            assert await slower.numbers(6) == list(range(1, 25, 4))
            await every.stream("StreamFrames Stop")
            server.publish(1.0, POSES)
            assert (await every.ask("Version"))[0] == rt.Packet.COMMAND

    run(test)


def test_a_clock_that_goes_back_does_not_end_a_stream():
    async def test():
        async with serving() as (server, port):
            client = await Client.connect(port)
            await client.stream("StreamFrames Frequency:50 6D")
            for time in (100.0, 0.0, 0.02):
                server.publish(time, POSES)
            assert await client.numbers(3) == [1, 2, 3]

    run(test)


def test_datagrams_go_to_the_asker_alone():
    async def test():
        async with serving() as (server, port):
            client = await Client.connect(port)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
                udp.bind(("127.0.0.1", 0))
                udp.setblocking(False)
                await client.stream(f"StreamFrames AllFrames UDP:{udp.getsockname()[1]} 6D 3D")
                server.publish(0.0, POSES)
                datagram = await asyncio.get_running_loop().sock_recv(udp, 1000)
            assert datagram == rt.data_packet(server.latest, ("6d", "3d"))
            kind, _ = await client.ask("StreamFrames AllFrames UDP:192.0.2.1:53 6D")
            assert kind == rt.Packet.ERROR

    run(test)


def test_who_does_not_read_gets_the_newest_frame_when_it_does():
    async def test():
        async with serving() as (server, port):
            lazy, quick = await Client.connect(port), await Client.connect(port)
            await lazy.stream("StreamFrames AllFrames 6D 6DRes 6DEuler 3D")
            lazy.reader._transport.pause_reading()
            await quick.stream("StreamFrames FrequencyDivisor:50 6D")
            count = 0
            while server.counts["dropped"] < 100:  # whatever the system's own buffers hold
                server.publish(count * 0.01, POSES)
                count += 1
                if count % 50 == 0:
                    await quick.numbers(1)
            assert sum(c._transport.get_write_buffer_size() for c in server._clients) < 2**17
            lazy.reader._transport.resume_reading()
            last = 0
            while last < count:
                last = (await lazy.numbers(1))[0]
            assert last == count

    run(test)


def test_bad_requests_are_answered_counted_and_survived():
    async def test():
        async with serving() as (server, port):
            client = await Client.connect(port)
            for bad in (b"", b"\xff\xfe", b"TakeControl secret", b"Version 9.9", b"StreamFrames x"):
                client.writer.write(request(1, bad + b"\0"))
                assert (await client.receive())[0] == rt.Packet.ERROR
            client.writer.write(request(7, b"hello"))
            assert (await client.receive())[0] == rt.Packet.ERROR
            assert server.counts["malformed"] == 5
            assert server.counts["unknown"] == 1
            assert (await client.ask("Version 1.19"))[1] == b"Version set to 1.19\0"
            assert (await client.ask("GetCurrentFrame 6D"))[0] == rt.Packet.NO_MORE_DATA
            client.writer.write(struct.pack("<II", 2**31, 1))
            assert (await client.receive())[0] == rt.Packet.ERROR
            assert await client.is_closed()
            assert server.counts["oversized"] == 1

    run(test)


def test_a_flood_of_requests_is_not_answered():
    async def test():
        async with serving() as (server, port):
            client = await Client.connect(port)
            client.writer.write(request(1, b"GetParameters All\0") * 2000)
            answers = 0
            with contextlib.suppress(asyncio.IncompleteReadError, ConnectionError):
                while True:
                    await client.receive()
                    answers += 1
            assert answers < 2000
            assert server.counts["flooded"] == 1

    run(test)


def test_one_client_too_many_is_told_so_and_the_others_stay():
    async def test():
        async with serving() as (server, port):
            clients = [await Client.connect(port) for _ in range(rt_server.MOST_CLIENTS)]
            extra = Client(*await asyncio.open_connection("127.0.0.1", port))
            assert (await extra.receive())[0] == rt.Packet.ERROR
            assert await extra.is_closed()
            assert server.counts["refused"] == 1
            assert (await clients[0].ask("GetState"))[0] == rt.Packet.EVENT
            clients[0].writer.close()
            while len(server._clients) == rt_server.MOST_CLIENTS:
                await asyncio.sleep(0)
            await Client.connect(port)

    run(test)


def test_a_taken_port_is_one_clear_error():
    async def test():
        async with serving() as (_, port):
            with pytest.raises(CaptureError, match="what to do"):
                await RTServer(["one"]).start(port=port)

    run(test)
