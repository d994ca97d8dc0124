"""A Qualisys RT server of our own, so that the maker's client has somebody to talk to.

It says what QTM says to those who read bodies, and refuses to be controlled. One event loop owns
it; `publish` is called there, as often as there are frames.
"""

from __future__ import annotations

import asyncio
import ipaddress
from collections import Counter
from collections.abc import Callable, Sequence

from multilift.flight.mocap import rt_protocol as rt
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Pose
from multilift.flight.mocap.rt_protocol import Packet

#: QTM's port for little-endian clients; C++ clients ask for one below and add one.
DEFAULT_PORT = 22223

#: Clients at a time; more are told so and sent away.
MOST_CLIENTS = 16

#: What may wait for a client that does not read, bytes; beyond it frames wait, the newest only.
_HIGH_WATER = 64 * 1024
#: Answers that may wait for it before it is sent away, bytes.
_MOST_WAITING = 1024 * 1024
#: Requests that it may send at once; clients send one and wait.
_MOST_AT_ONCE = 256
#: How long it may take to read the last words, s.
_LAST_WORDS = 2.0

_GREETING = "QTM RT Interface connected"
_VERSION = "multilift RT server"


class RTServer:
    """Streams bodies by Qualisys' RT protocol.

    Attributes:
        names: of the bodies, in the order in which captures give them.
        rate: of capture as clients are told, Hz.
        counts: of what happened, by name: "clients", "refused", "malformed", "unknown",
            "oversized", "flooded", "dropped", "overfull".
    """

    def __init__(self, names: Sequence[str], *, rate: float = 100.0) -> None:
        self.names = tuple(names)
        self.rate = rate
        self.counts: Counter[str] = Counter()
        self._clients: set[_Client] = set()
        self._latest: rt.Capture | None = None
        self._number = 0
        self._server: asyncio.Server | None = None
        self._udp: asyncio.DatagramTransport | None = None

    async def start(self, host: str = "127.0.0.1", port: int = DEFAULT_PORT) -> int:
        """Listen.

        Args:
            host: an address of this machine; it listens there and nowhere else.
            port: 0 for any that is free.

        Returns:
            The port.

        Raises:
            CaptureError: the address or port is not to be had.
        """
        loop = asyncio.get_running_loop()
        try:
            self._server = await loop.create_server(lambda: _Client(self), host, port)
            self._udp, _ = await loop.create_datagram_endpoint(
                asyncio.DatagramProtocol, local_addr=(host, 0)
            )
        except OSError as error:
            await self.stop()
            raise CaptureError(
                f"RT server: {host}:{port} cannot be listened on: {error.strerror}\n"
                "  what to do: free the port or name another"
            ) from None
        return int(self._server.sockets[0].getsockname()[1])

    async def stop(self) -> None:
        """Send everybody away; more than once does no harm."""
        for client in tuple(self._clients):
            client.abort()
        if self._udp is not None:
            self._udp.close()
            self._udp = None
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()
            self._server = None

    def publish(self, time: float, poses: Sequence[Pose | None]) -> None:
        """Send a frame to all who asked.

        Args:
            time: of capture, since the capture began, s.
            poses: in the order of `names`; None for a body that is not seen.
        """
        if len(poses) != len(self.names):
            raise ValueError(f"{len(poses)} poses for {len(self.names)} bodies")
        self._number += 1
        self.publish_capture(rt.Capture(self._number, time, tuple(poses)))

    def publish_capture(self, capture: rt.Capture) -> None:
        """Send a frame whose number is not the next, as a faulty system would."""
        self._latest = capture
        packets: dict[tuple[str, ...], bytes] = {}
        for client in tuple(self._clients):
            stream = client.due(capture)
            if stream is None:
                continue
            if stream.components not in packets:
                packets[stream.components] = rt.data_packet(capture, stream.components)
            client.deliver(packets[stream.components])

    def send_udp(self, packet: bytes, address: tuple[str, int]) -> None:
        """To a client that asked for datagrams."""
        if self._udp is not None:
            self._udp.sendto(packet, address)

    def join(self, client: _Client) -> bool:
        """Whether there is room for one more."""
        if len(self._clients) >= MOST_CLIENTS:
            self.counts["refused"] += 1
            return False
        self.counts["clients"] += 1
        self._clients.add(client)
        return True

    def leave(self, client: _Client) -> None:
        """A client is gone."""
        self._clients.discard(client)

    @property
    def latest(self) -> rt.Capture | None:
        """The last frame that was published."""
        return self._latest


class _Client(asyncio.Protocol):
    """One connection: its requests, its version, its stream."""

    def __init__(self, server: RTServer) -> None:
        self._server = server
        self._reader = rt.RequestReader()
        self._version = 1
        self._stream: rt.Stream | None = None
        self._due = 0.0
        self._waiting: bytes | None = None
        self._paused = False
        self._peer = ""
        self._commands: dict[str, Callable[[list[str]], bytes | None]] = {
            "version": self._set_version,
            "qtmversion": lambda _: rt.text_packet(Packet.COMMAND, f"QTM Version is {_VERSION}"),
            "byteorder": lambda _: rt.text_packet(Packet.COMMAND, "Byte order is little endian"),
            "getstate": lambda _: rt.event_packet(rt.Event.CONNECTED),
            "getparameters": self._parameters,
            "getcurrentframe": self._current_frame,
            "streamframes": self._stream_frames,
            "checklicense": lambda _: rt.text_packet(Packet.COMMAND, "License fail"),
        }

    # What asyncio calls.

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        self._peer = str(transport.get_extra_info("peername")[0])
        transport.set_write_buffer_limits(high=_HIGH_WATER)
        if self._server.join(self):
            self._send(rt.text_packet(Packet.COMMAND, _GREETING))
        else:
            self._dismiss("Too many clients")

    def connection_lost(self, error: Exception | None) -> None:
        del error
        self._server.leave(self)

    def data_received(self, data: bytes) -> None:
        try:
            requests = self._reader.feed(data)
        except rt.RequestError:
            self._server.counts["oversized"] += 1
            self._dismiss("Parse error")
            return
        if len(requests) > _MOST_AT_ONCE:
            self._server.counts["flooded"] += 1
            self._dismiss("Too many requests")
            return
        for request in requests:
            answer = self._answer(request)
            if answer is not None:
                self._send(answer)
            if self._transport.is_closing():
                return

    def pause_writing(self) -> None:
        self._paused = True

    def resume_writing(self) -> None:
        self._paused = False
        packet, self._waiting = self._waiting, None
        if packet is not None:
            self._send(packet)

    # What the server calls.

    def due(self, capture: rt.Capture) -> rt.Stream | None:
        """The stream, where this frame is one that the client asked for."""
        stream = self._stream
        if stream is None or capture.number % stream.divisor:
            return None
        if stream.period:
            if self._due - stream.period <= capture.time < self._due - 1e-6:
                return None
            behind = capture.time - self._due
            self._due = (self._due if 0 <= behind < stream.period else capture.time) + stream.period
        return stream

    def deliver(self, packet: bytes) -> None:
        """Send a frame, or let it take the place of the one that waits."""
        if self._stream is not None and self._stream.udp_port is not None:
            self._server.send_udp(packet, (self._peer, self._stream.udp_port))
        elif self._paused:
            self._server.counts["dropped"] += self._waiting is not None
            self._waiting = packet
        else:
            self._send(packet)

    def abort(self) -> None:
        """Close at once."""
        self._stream = None
        self._server.leave(self)
        self._transport.abort()

    # What clients ask.

    def _send(self, packet: bytes) -> None:
        if self._transport.get_write_buffer_size() > _MOST_WAITING:
            self._server.counts["overfull"] += 1
            self.abort()
        else:
            self._transport.write(packet)

    def _dismiss(self, why: str) -> None:
        """Say why, and close; who does not read that is not waited for."""
        self._stream = self._waiting = None
        self._server.leave(self)
        self._send(rt.text_packet(Packet.ERROR, why))
        self._transport.close()
        asyncio.get_running_loop().call_later(_LAST_WORDS, self._transport.abort)

    def _answer(self, request: rt.Request) -> bytes | None:
        try:
            words = request.content.decode("ascii").lower().split()
        except UnicodeDecodeError:
            words = []
        if request.kind != Packet.COMMAND or not words:
            self._server.counts["malformed"] += 1
            return rt.text_packet(Packet.ERROR, "Parse error")
        command = self._commands.get(words[0])
        if command is None:
            self._server.counts["unknown"] += 1
            return rt.text_packet(Packet.ERROR, "Parse error")
        return command(words[1:])

    def _malformed(self, why: str = "Parse error") -> bytes:
        self._server.counts["malformed"] += 1
        return rt.text_packet(Packet.ERROR, why)

    def _set_version(self, words: list[str]) -> bytes:
        if not words:
            return rt.text_packet(Packet.COMMAND, f"Version is 1.{self._version}")
        version = rt.parse_version(words[0])
        if version is None or len(words) > 1:
            return self._malformed("Version NOT supported")
        self._version = version
        return rt.text_packet(Packet.COMMAND, f"Version set to 1.{version}")

    def _parameters(self, words: list[str]) -> bytes:
        server = self._server
        if not words:
            return self._malformed()
        xml = rt.parameters_xml(server.names, server.rate, self._version, words)
        return rt.text_packet(Packet.XML, xml)

    def _current_frame(self, words: list[str]) -> bytes:
        components = rt.parse_components(words)
        if not components:
            return self._malformed()
        latest = self._server.latest
        return rt.data_packet(latest, components) if latest else rt.no_more_data_packet()

    def _stream_frames(self, words: list[str]) -> bytes | None:
        if words == ["stop"]:
            self._stream = None
            return None
        stream = rt.parse_stream(words)
        if stream is None:
            return self._malformed()
        if stream.udp_port is not None and not self._is_own(stream.udp_host):
            return self._malformed("UDP only to the client's own address")
        self._stream = stream
        self._due = 0.0
        return None

    def _is_own(self, host: str) -> bool:
        """Whether datagrams go back to who asked: nobody is to be flooded on another's word."""
        if host in ("", "localhost"):
            return host == "" or ipaddress.ip_address(self._peer).is_loopback
        try:
            return ipaddress.ip_address(host) == ipaddress.ip_address(self._peer)
        except ValueError:
            return False
