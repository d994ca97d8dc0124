"""One physics for all: nobody goes ahead, nobody is waited for in vain, and it says who."""

import threading
from contextlib import ExitStack, closing

import multilift as ml
import pytest
import sitl_flights
from multilift.flight.sitl.ardupilot_json import ArduPilotLink
from multilift.flight.sitl.autopilot import SitlError
from multilift.flight.sitl.lockstep import Lockstep
from multilift.flight.sitl.physics import LONGEST_PERIOD, Physics
from multilift.flight.sitl.px4_hil import Px4Link
from multilift.flight.sitl.sensors import Sensors
from test_sitl_ardupilot_json import Firmware as Frames
from test_sitl_ardupilot_json import packet
from test_sitl_px4_hil import CONTROLS, HEARTBEAT, actuators
from test_sitl_px4_hil import Firmware as Stream


@pytest.fixture
def stack():
    with ExitStack() as made:
        yield made


def lockstep(links, patience=20.0, **options):
    physics = Physics(ml.load("bar_from_floor"))
    sensors = [Sensors(1, i) for i in range(physics.count)]
    return physics, Lockstep(physics, sensors, links, patience=patience, **options)


class Answering(threading.Thread):
    """ArduPilots that ask for so many frames, each at its own rate; the last goes unanswered."""

    def __init__(self, links, frames, rates=(400, 400)):
        super().__init__()
        self.wires = [Frames(link).wire for link in links]
        self.frames, self.rates = frames, rates
        self.times = [[] for _ in links]

    def run(self):
        for k in range(max(self.frames) + 1):
            asking = [i for i, most in enumerate(self.frames) if k <= most]
            for i in asking:
                self.wires[i].send(packet(k, 1100 + 100 * i, self.rates[i]))
            for i in asking:
                if k < self.frames[i]:
                    self.times[i].append(self.wires[i].recv(65536))

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.join()
        for wire in self.wires:
            wire.close()


@pytest.fixture
def pair(stack):
    return [stack.enter_context(closing(ArduPilotLink(i, port=0))) for i in range(2)]


def test_all_go_through_the_same_instants_each_by_its_own_motors(pair):
    physics, loop = lockstep(pair)
    commanded = []
    with Answering(pair, (200, 200)) as firmwares:
        loop.connect()
        done = loop.run(0.5, lambda p: commanded.append(p.world.rotor_speed.copy()))
    assert done.steps == 200
    assert done.simulated == pytest.approx(0.5) == pytest.approx(physics.time)
    assert done.speed > 0
    first, second = (
        [line.split(b",", 1)[0] for line in times] for times in firmwares.times
    )  # the time stamps
    assert first == second
    assert len(set(first)) == 200
    # A tenth and a fifth of full speed, reached with the motors' lag.
    assert commanded[-1][0] == pytest.approx([95.0] * 4, rel=1e-6)
    assert commanded[-1][1] == pytest.approx([190.0] * 4, rel=1e-6)


@pytest.mark.parametrize(
    ("rates", "period"),
    [
        ((400, 400), 0.0025),
        ((400, 1000), 0.001),
        ((65535, 65535), 0.0005),
        ((1, 1), LONGEST_PERIOD),
    ],
)
def test_the_shortest_step_asked_for_counts_within_what_the_model_can(pair, rates, period):
    physics, loop = lockstep(pair)
    with Answering(pair, (3, 3), rates):
        loop.connect()
        loop.run(2.5 * period)
    assert physics.time == pytest.approx(3 * period)


def test_who_stops_answering_is_named_and_the_world_stands_still(pair):
    physics, loop = lockstep(pair, patience=0.3)
    with Answering(pair, (11, 10)):
        loop.connect()
        with pytest.raises(SitlError, match=r"^vehicle_2: the firmware does not answer") as told:
            loop.run(1.0)
        assert "vehicle_1" not in str(told.value)
    # The frame that it still asked for was the last.
    assert physics.time == pytest.approx(11 * 0.0025)


def test_who_never_comes_is_named(pair):
    _, loop = lockstep(pair, patience=0.1)
    unheard = pytest.raises(SitlError, match=r"^vehicle_2: .* not been heard")
    with Answering(pair[:1], (0,)), unheard:
        loop.connect()


def test_who_watches_is_asked_while_nobody_comes(pair):
    def watch():
        raise SitlError("vehicle_1: the firmware ended")

    _, loop = lockstep(pair, watch=watch)
    with pytest.raises(SitlError, match="ended"):
        loop.connect()


def test_the_end_of_the_world_is_an_error_that_says_when(pair):
    world = Physics(ml.load("bar_from_floor").with_values({"safety.vehicle_distance": 1.6}))
    with pytest.raises(SitlError, match=r"ended by collision at t = 0\."):
        for _ in range(10):
            world.advance([(0.0,) * 4] * 2, 0.004)


def test_a_mixed_pair_flies_and_the_starting_one_is_not_waited_for(stack):
    links = [
        stack.enter_context(closing(ArduPilotLink(0, port=0))),
        stack.enter_context(closing(Px4Link(1, port=0))),
    ]
    physics, loop = lockstep(links, patience=3.0)
    other = stack.enter_context(closing(Stream(links[1], HEARTBEAT).wire))
    with Answering(links[:1], (41,)):
        loop.connect()
        loop.run(0.1)  # free, as PX4 has not started its outputs
        assert links[1].free_running
        other.sendall(actuators(1, CONTROLS, 129, 1))
        loop.run(0.0025)
        assert links[1].motors == CONTROLS[:4]
        # From now on it is waited for.
        with pytest.raises(SitlError, match=r"^vehicle_2: the firmware does not answer"):
            loop.run(0.0025)
    assert physics.time == pytest.approx(0.1025)


@pytest.mark.parametrize("kind", ["px4", "ardupilot"])
def test_two_firmwares_take_off_lift_the_bar_and_hold_it(kind, tmp_path, monkeypatch):
    """From slack cables on the floor to the bar hanging, through all wires; nothing is shared but
    the protocols' documents."""
    lowest = []
    physics, done = sitl_flights.fly(
        kind, sitl_flights.program(tmp_path / "firmware", kind), tmp_path / "run", monkeypatch,
        duration=14.0, each=lambda p: lowest.append(p.world.clearance[0]),
    )  # fmt: skip
    assert done.simulated == pytest.approx(14.0, abs=0.004)
    world = physics.world
    for motion, target in zip(physics.motions, sitl_flights.ABOVE, strict=True):
        # What is left of the swing moves them.
        assert motion.position == pytest.approx(target, abs=0.1)
    assert world.payload[2] == pytest.approx(1.75 - 1.21 - 0.01, abs=0.1)
    assert world.taut.all()
    assert world.tension.sum() == pytest.approx(0.386 * 9.8, rel=0.1)
    assert min(lowest) > 1.3
    told = [i.what for i in world.incidents]
    assert told.count("lift_off") == 3


def test_a_flight_is_the_same_again_to_the_last_bit(tmp_path, monkeypatch):
    """Who answers first, and how long that takes, changes nothing."""
    file = sitl_flights.program(tmp_path / "firmware", "ardupilot")
    ends = [
        sitl_flights.fly("ardupilot", file, tmp_path / str(k), monkeypatch, duration=3.0)[0]
        for k in range(2)
    ]
    for name in ("vehicle", "vehicle_attitude", "rotor_speed", "payload"):
        first, second = (getattr(physics.world, name) for physics in ends)
        assert first.tobytes() == second.tobytes(), name
    assert ends[0].motions == ends[1].motions
    assert ends[0].world.vehicle[0, 2] > 0.5
