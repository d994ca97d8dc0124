"""What a twin's radio does to datagrams."""

from random import Random

from hypothesis import given
from hypothesis import strategies as st
from multilift.flight.twin.wire import Impaired, Radio

SOURCE = ("127.0.0.1", 1)


class Ether:
    """A transport that loses nothing, and a clock."""

    def __init__(self):
        self.peer, self.now, self.arrived, self.sent = None, 0.0, [], []

    def receive(self):
        came, self.arrived = self.arrived, []
        return [(data, SOURCE) for data in came]

    def send(self, data):
        self.sent.append((self.now, data))

    def forget_peer(self):
        self.peer = None


def passed(radio, seed, count=40, step=0.01):
    """What goes through, with times, of one datagram a step in either direction."""
    ether = Ether()
    air = Impaired(ether, radio, lambda: ether.now, Random(seed))
    heard = []
    for k in range(count + 200):
        if k < count:
            ether.arrived.append(k)
            air.send(k)
        heard += [(ether.now, data) for data, _source in air.receive()]
        ether.now += step
    return heard, ether.sent


radios = st.builds(
    Radio,
    delay=st.floats(0.0, 0.5),
    jitter=st.floats(0.0, 0.5),
    loss=st.floats(0.0, 1.0),
    double=st.floats(0.0, 1.0),
    overtakes=st.booleans(),
)


@given(radios, st.integers(0, 1000))
def test_nothing_is_made_up_early_or_later_than_it_may(radio, seed):
    for way in passed(radio, seed):
        for time, k in way:
            sent = 0.01 * k
            assert sent + radio.delay <= time + 1e-9
            # In order, it may wait behind another that is as late as can be; and for a look.
            assert time <= sent + radio.delay + radio.jitter + 0.01 + 1e-9
        assert {k for _time, k in way} <= set(range(40))
        if not radio.overtakes:
            assert [k for _time, k in way] == sorted(k for _time, k in way)


@given(st.integers(0, 1000))
def test_a_perfect_radio_changes_nothing_and_a_dead_one_passes_nothing(seed):
    heard, sent = passed(Radio(), seed)
    assert [k for _t, k in heard] == [k for _t, k in sent] == list(range(40))
    assert passed(Radio(loss=1.0), seed) == ([], [])
