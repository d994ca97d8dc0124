"""Bytes that no client should send, sent to the RT server; `make fuzz` sends millions."""

import argparse
import asyncio
import contextlib
import random
import struct

from multilift.flight.mocap import pipe, qualisys
from multilift.flight.mocap import rt_protocol as rt
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Pose
from multilift.flight.mocap.rt_server import RTServer, _Client
from multilift.flight.mocap.settings import Settings

#: What may wait to be sent: a client that does not read is sent away at 1 MiB, plus one answer.
MOST_WAITING = 1 << 20 | 1 << 17

WORDS = [
    *("version", "1.19", "1.25", "1.8", "1.99", "2.0", "qtmversion", "byteorder", "getstate"),
    *("getparameters", "all", "6d", "general", "getcurrentframe", "streamframes", "stop"),
    *("allframes", "frequency:50", "frequency:0", "frequency:-1", "frequency:1e9"),
    *("frequencydivisor:3", "frequencydivisor:", "udp:6734", "udp:127.0.0.1:6734", "udp::::"),
    *("udp:10.0.0.1:53", "udp:0", "udp:99999999999999999999", "6dres", "6deuler", "6deulerres"),
    *("3dnolabels", "skeleton", "takecontrol", "new", "\u0663"),
]


class Sink(asyncio.Transport):
    """A client that may not read: keeps what it is sent, until it is closed."""

    def __init__(self, reads):
        super().__init__({"peername": ("127.0.0.1", 9)})
        self.reads = reads
        self.waiting = 0
        self.most = 0
        self.closed = False
        self.answers = 0

    def set_write_buffer_limits(self, high=None, low=None):
        pass

    def get_write_buffer_size(self):
        return self.waiting

    def write(self, data):
        size, kind = struct.unpack_from("<II", data)
        assert size == len(data)
        assert kind in set(rt.Packet)
        self.answers += 1
        if not self.reads:
            self.waiting += len(data)
            self.most = max(self.most, self.waiting)

    def is_closing(self):
        return self.closed

    def close(self):
        self.closed = True

    abort = close


def request(kind, content):
    return struct.pack("<II", 8 + len(content), kind) + content


def noise(rng):
    """One message: a command, a command gone wrong, or plain noise."""
    how = rng.random()
    if how < 0.6:
        text = " ".join(rng.choices(WORDS, k=rng.randint(0, 6)))
        message = bytearray(request(1, text.encode() + b"\0"))
        for _ in range(rng.choice((0, 0, 0, 1, 3))):
            message[rng.randrange(len(message))] = rng.randrange(256)
        return bytes(message)
    if how < 0.8:
        return request(rng.randrange(12), rng.randbytes(rng.randrange(40)))
    if how < 0.9:
        return struct.pack("<II", rng.choice((0, 7, 8, 4097, 1 << 31, 0xFFFFFFFF)), 1)
    return rng.randbytes(rng.randrange(60))


async def attack_server(rng, count):
    """Send `count` messages over many connections; the answers are whole packets, and bounded."""
    server = RTServer(["one", "two"])
    sent = 0
    while sent < count:
        client, sink = _Client(server), Sink(reads=rng.random() < 0.7)
        client.connection_made(sink)
        for _ in range(rng.randint(1, 200)):
            message = noise(rng)
            cut = rng.randrange(len(message) + 1)
            for part in (message[:cut], message[cut:]):
                if not sink.closed:
                    client.data_received(part)
            sent += 1
            server.publish(sent * 0.01, [None, Pose((0.0, 0.0, 0.0))])
            if sink.closed:
                break
        assert sink.most <= MOST_WAITING
        assert len(client._reader._rest) <= rt.LARGEST_REQUEST
        client.connection_lost(None)
    assert not server._clients
    return server.counts


def attack_readers(rng, count):
    """What comes from the reading process, and parameters from a server, as noise."""
    names = ("a", "b")
    settings = Settings("qualisys", {"a": "a"})
    xml = rt.parameters_xml(names, 100.0, 25, ["all"]).encode()
    for _ in range(count):
        with contextlib.suppress(ValueError):
            pipe.frame_from_bytes(rng.randbytes(rng.choice((0, 20, 28, 96, 100, 164))), names)
        broken = bytearray(xml)
        for _ in range(rng.randrange(5)):
            broken[rng.randrange(len(broken))] = rng.randrange(256)
        with contextlib.suppress(CaptureError):
            assert set(qualisys.body_places(bytes(broken), settings, "here")) == {"a"}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=3_000_000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    print(f"server: {asked.count} messages, {dict(asyncio.run(attack_server(rng, asked.count)))}")
    attack_readers(rng, asked.count // 10)
    print(f"readers: {asked.count // 10} messages")


if __name__ == "__main__":
    main()
