"""The socket of a link: one peer, no blocking, nothing beyond loopback unless it is named."""

import select
import socket

import pytest
from multilift.flight.link.address import Address
from multilift.flight.link.udp import Udp


@pytest.fixture
def pair():
    """A listening end and a plain socket beside it."""
    free = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
    free.close()
    end = Udp(Address(True, "127.0.0.1", port))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        other.settimeout(10.0)
        yield end, other
    end.close()


def come(end):
    select.select([end._socket], [], [], 10.0)
    return list(end.receive())


def test_it_answers_who_is_taken_as_its_peer_and_hears_nobody_else(pair):
    end, other = pair
    end.send(b"lost")  # to nobody
    other.sendto(b"hello", ("127.0.0.1", end.port))
    [(data, source)] = come(end)
    assert data == b"hello"
    end.peer = source
    end.send(b"back")
    assert other.recv(100) == b"back"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"me too", ("127.0.0.1", end.port))
        assert come(end) == []
        assert end.strangers == 1
        end.forget_peer()
        stranger.sendto(b"me now", ("127.0.0.1", end.port))
        assert [d for d, _s in come(end)] == [b"me now"]


def test_nothing_there_is_nothing_and_a_flood_is_cut(pair):
    end, other = pair
    assert list(end.receive()) == []
    for _ in range(100):
        other.sendto(b"x", ("127.0.0.1", end.port))
    assert len(come(end)) <= 64


def test_an_aimed_end_speaks_first_and_keeps_its_peer(pair):
    end, _other = pair
    aimed = Udp(Address(False, "127.0.0.1", end.port))
    aimed.send(b"first")
    [(data, source)] = come(end)
    assert (data, source[0]) == (b"first", "127.0.0.1")
    peer = aimed.peer
    aimed.forget_peer()
    assert aimed.peer == peer
    aimed.close()
