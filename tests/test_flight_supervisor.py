"""The supervisor: laws that hold whatever comes in, and the course of a flight without trouble."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from multilift.flight.lab import Limits
from multilift.flight.supervisor import Order, Seen, State, Supervisor, VehicleSeen, Word
from multilift.flight.supervisor.machine import BY_SET_POINT
from multilift.flight.supervisor.states import COURSE, FLYING, MOST_TIME, TRANSITIONS, WAYS, Event

LIMITS = Limits(
    fence_low=[-3.0, -3.0, -0.5], fence_high=[3.0, 3.0, 4.0], tilt=0.7, swing=0.8, separation=0.8,
    speed=3.0, saturation=0.5, state_age=0.1, mocap_age=0.15, link_age=2.5, hold=3.0, battery=0.3,
)  # fmt: skip
TICK = 0.05


def craft(k, **changes):
    """Vehicle k in the air, well, 1.5 m from the next."""
    well = VehicleSeen(0.1, True, True, False, False, (1.5 * k - 0.75, 0.0, 2.0), 0.1, 0.05)
    return replace(well, **changes)


def seen(*changes, vehicles=None, **common):
    """Two vehicles, all well, but for the changes."""
    given_ = changes or ({}, {})
    well = Seen(vehicles or tuple(craft(k, **c) for k, c in enumerate(given_)), 0.01, "", 0.01, 0.1)
    return replace(well, **common)


GROUND = {"armed": False, "landed": True}


def grounded(**common):
    return seen(GROUND, GROUND, **common)


def flying(state=State.FLY):
    """A supervisor that has come to a state of the course, and the time."""
    boss = Supervisor(LIMITS, 2)
    now = 0.0
    for step in (grounded(word=Word.START), grounded(word=Word.GO), seen()):
        now += TICK
        boss.step(step, now)
    while boss.state is not state:
        now += TICK
        boss.step(seen(done=True), now)
    return boss, now


def test_every_way_is_named_once_and_every_state_leads_home():
    assert len({(t.start, t.event) for t in TRANSITIONS}) == len(TRANSITIONS)
    reached, home = {State.IDLE}, {State.IDLE}
    for _ in State:
        reached |= {t.end for t in TRANSITIONS if t.start in reached}
        home |= {t.start for t in TRANSITIONS if t.end in home}
    assert reached == home == set(State)


def test_in_the_air_trouble_leads_to_hold_and_hold_leads_apart():
    assert {WAYS[s][Event.TROUBLE] for s in FLYING} == {State.HOLD}
    assert {end for event, end in WAYS[State.HOLD].items()
            if event not in (Event.KILL, Event.ALL_DISARMED)} == {State.LAND_APART}  # fmt: skip


def test_only_the_pilot_or_a_landing_that_never_ends_kills():
    into = {(t.start, t.event) for t in TRANSITIONS if t.end is State.KILL}
    assert {start for start, event in into if event is not Event.KILL} == {State.LAND_APART}
    assert {event for _start, event in into} == {Event.KILL, Event.TOO_LONG}


def test_every_state_ends_by_time_alone():
    for state in State:
        ends = math.isfinite(MOST_TIME[state]) and Event.TOO_LONG in WAYS[state]
        # Hold by its own limit, fly by the time in the air; idle is the end.
        assert ends or state in (State.HOLD, State.FLY, State.IDLE)


def test_the_course_of_a_flight():
    boss = Supervisor(LIMITS, 2)
    course = []
    plan = [
        (grounded(word=Word.START), Order.WARM_UP),
        (grounded(word=Word.GO), Order.ARM),
        (seen(), Order.TRACK),
        *[(seen(done=True), Order.TRACK)] * 4,
        (seen(done=True), Order.DESCEND),
        (seen({"landed": True}, {"landed": True}), Order.DISARM),
        (grounded(), Order.NOTHING),
    ]
    for k, (step, order) in enumerate(plan):
        orders = boss.step(step, k * TICK)
        assert orders.vehicles == (order, order)
        course.append(orders.state)
    assert course == [State.PREFLIGHT, State.ARMED, *COURSE, State.LAND, State.IDLE]


BEFORE = [
    (grounded(mocap_age=1.0), "motion capture"),
    (grounded(mocap_fault="bodies swapped"), "swapped"),
    (seen(GROUND, GROUND | {"follows": False}), "vehicle 2: does not take"),
    (seen(GROUND, GROUND | {"charge": 0.2}), "battery"),
    (seen(GROUND, GROUND | {"charge": math.nan}), "battery"),
    (seen(GROUND, GROUND | {"problems": ("COM_OF_LOSS_T is 1",)}), "COM_OF_LOSS_T"),
    (seen(GROUND, GROUND | {"link_age": math.inf}), "heartbeat"),
    (seen(GROUND, {}), "vehicle 2: is armed"),
    (seen(GROUND, GROUND | {"position": (-0.5, 0.0, 2.0)}), "close"),
    (seen(GROUND, GROUND | {"position": (9.0, 0.0, 0.0)}), "fence"),
]


@pytest.mark.parametrize(("step", "words"), BEFORE)
def test_nobody_arms_while_anything_speaks_against_it(step, words):
    boss = Supervisor(LIMITS, 2)
    boss.step(grounded(word=Word.START), 0.0)
    orders = boss.step(replace(step, word=Word.GO), TICK)
    assert orders.state is State.PREFLIGHT
    assert any(words in line for line in orders.problems)
    assert boss.step(grounded(word=Word.GO), 2 * TICK).state is State.ARMED


TROUBLES = {
    "link": {"link_age": 3.0}, "disarmed": {"armed": False}, "mode": {"follows": False},
    "failsafe": {"failsafe": True}, "tilt": {"tilt": 0.8}, "speed": {"speed": 4.0},
    "saturation": {"saturated": 0.6}, "fence": {"position": (3.5, 0.0, 2.0)},
    "separation": {"position": (-0.2, 0.0, 2.0)}, "boot": {"boots": 1},
    "no number": {"tilt": math.nan}, "nowhere": {"position": (math.nan, 0.0, 2.0)},
}  # fmt: skip
COMMON = {
    "frozen": {"mocap_age": 0.2}, "swapped": {"mocap_fault": "bodies swapped"},
    "old": {"state_age": 0.2}, "swing": {"swing": 0.9}, "swing unknown": {"swing": math.nan},
    "clock": {"mocap_age": -1.0},
}  # fmt: skip


@pytest.mark.parametrize("state", FLYING[:-1], ids=lambda s: s.name)
@pytest.mark.parametrize("name", [*TROUBLES, *COMMON])
def test_the_trouble_of_one_acts_on_all(state, name):
    boss, now = flying(state)
    bad = seen({}, TROUBLES[name]) if name in TROUBLES else seen(**COMMON[name])
    orders = boss.step(bad, now + TICK)
    assert orders.state is State.HOLD
    assert orders.vehicles == (Order.STAY, Order.STAY)
    assert orders.problems
    # Whether it goes on or is over, all land apart, at the latest when the hold is over.
    for after in (bad, seen()):
        other, start = flying(state)
        other.step(bad, start + TICK)
        for k in range(round(LIMITS.hold / TICK) + 2):
            orders = other.step(after, start + TICK * (k + 2))
        assert orders.state is State.LAND_APART
        assert set(orders.vehicles) <= {Order.DESCEND, Order.LAND, Order.DISARM}


def test_without_fresh_state_they_land_by_themselves_and_stay_with_it():
    boss, now = flying()
    for k in range(20):
        orders = boss.step(seen(mocap_age=9.0, state_age=9.0), now + TICK * (k + 1))
        assert not orders.may_send
    assert orders.vehicles == (Order.LAND, Order.LAND)
    orders = boss.step(seen(), now + 2.0)
    assert orders.may_send
    assert orders.vehicles == (Order.LAND, Order.LAND)


def test_one_that_has_overturned_is_cut_and_the_other_lands():
    boss, now = flying()
    over = seen({}, {"tilt": 2.5})
    cut = []
    for k in range(150):
        orders = boss.step(over, now + TICK * (k + 1))
        assert orders.vehicles[0] is not Order.CUT
        cut.append(orders.vehicles[1] is Order.CUT)
    assert orders.state is State.LAND_APART
    assert cut[-1]
    assert cut == sorted(cut)


def test_the_pilots_words():
    boss, now = flying()
    assert boss.step(seen(word=Word.HOLD), now + 0.1).vehicles == (Order.STAY, Order.STAY)
    assert boss.step(seen(word=Word.GO), now + 0.2).state is State.FLY
    assert boss.step(seen(word=Word.LAND), now + 0.3).state is State.SET_DOWN
    orders = boss.step(seen(word=Word.KILL), now + 0.4)
    assert orders.vehicles == (Order.CUT, Order.CUT)
    assert boss.step(grounded(), now + 0.5).state is State.IDLE


def test_a_load_that_hangs_is_set_down_before_landing():
    for state in FLYING[:-1]:
        if state is State.SET_DOWN:
            continue
        boss, now = flying(state)
        down = State.SET_DOWN if state in (State.LIFT, State.FLY) else State.LAND
        assert boss.step(seen(word=Word.LAND), now + TICK).state is down


def test_refused_arming_ends_disarmed():
    boss = Supervisor(LIMITS, 2)
    boss.step(grounded(word=Word.START), 0.0)
    boss.step(grounded(word=Word.GO), 0.1)
    one = seen(GROUND | {"armed": True}, GROUND)
    orders = boss.step(one, 20.0)
    assert orders.state is State.LAND
    assert orders.vehicles == (Order.DISARM, Order.DISARM)
    assert boss.step(grounded(), 20.1).state is State.IDLE


NUMBERS = st.sampled_from([0.0, 0.05, 0.12, 0.6, 1.0, 2.0, 5.0, -1.0, math.nan, math.inf])
PLACES = st.tuples(NUMBERS, NUMBERS, NUMBERS)
VEHICLES = st.builds(
    VehicleSeen, NUMBERS, st.booleans(), st.booleans(), st.booleans(),
    st.sampled_from([None, True, False]), PLACES, NUMBERS, NUMBERS, NUMBERS, NUMBERS,
    st.integers(0, 2), st.sampled_from([(), ("bad",)]),
)  # fmt: skip
ANYTHING = st.builds(
    Seen, st.tuples(VEHICLES, VEHICLES), NUMBERS, st.sampled_from(["", "swapped"]), NUMBERS,
    NUMBERS, st.booleans(), st.sampled_from([None, *Word]),
)  # fmt: skip
GOOD = st.builds(
    lambda done, word, on_ground: (grounded if on_ground else seen)(done=done, word=word),
    st.booleans(), st.sampled_from([None, *Word]), st.booleans(),
)  # fmt: skip


class AnyFlight(RuleBasedStateMachine):
    """Whatever is seen, in whatever order, at whatever times."""

    def __init__(self):
        super().__init__()
        self.boss = Supervisor(LIMITS, 2)
        self.now = 0.0
        self.seen = grounded()
        self.before = State.IDLE
        self.orders = self.boss.step(self.seen, self.now)

    def step(self, what, wait):
        self.now += wait
        self.seen, self.before = what, self.boss.state
        self.orders = self.boss.step(what, self.now)

    @rule(what=ANYTHING, wait=st.sampled_from([0.01, 0.2, 4.0, -1.0, 100.0]))
    def anything(self, what, wait):
        self.step(what, wait)

    @rule(what=GOOD, wait=st.sampled_from([0.01, 0.2, 4.0]))
    def well(self, what, wait):
        self.step(what, wait)

    @precondition(lambda self: self.boss.state is State.IDLE)
    @rule(state=st.sampled_from(FLYING[:-1]))
    def flight(self, state):
        self.boss, now = flying(state)
        self.now = self.now + now
        self.step(seen(), 0.01)

    @rule(what=ANYTHING)
    def it_ends(self, what):
        """The same for ever, without the pilot: home within the sum of all limits."""
        left = sum(t for t in MOST_TIME.values() if math.isfinite(t)) + LIMITS.hold
        end = self.now + left + self.boss.flight_time
        what = replace(what, word=None)
        while self.now < end and self.boss.state is not State.IDLE:
            self.step(what, 0.25)
            self.laws()
        assert self.boss.state is State.IDLE

    @invariant()
    def laws(self):
        orders, state = self.orders, self.orders.state
        assert orders.state is self.boss.state
        assert len(orders.vehicles) == 2
        # Every change is one of the table's.
        if state is not self.before:
            assert state in WAYS[self.before].values()
        # Nothing is sent from a state that is too old.
        assert orders.may_send == (0.0 <= self.seen.state_age <= LIMITS.state_age)
        # The trouble of one ends the plan of all.
        if self.before in FLYING and orders.problems:
            assert Order.TRACK not in orders.vehicles
        # All are in the air by our plan, or none is.
        assert len({o is Order.TRACK for o in orders.vehicles}) == 1
        # Thrust is cut by the pilot, in a landing that never ends, or where nothing else is left.
        if Order.CUT in orders.vehicles:
            assert state in (State.KILL, State.LAND_APART)
        # On the ground and unarmed nobody is told to go up.
        if state in (State.IDLE, State.PREFLIGHT):
            assert set(orders.vehicles) <= {Order.NOTHING, Order.WARM_UP}
        # Landing by itself is not mixed with set-points.
        for order in orders.vehicles:
            assert (order is Order.LAND) <= (order not in BY_SET_POINT)


TestAnyFlight = AnyFlight.TestCase
TestAnyFlight.settings = settings(max_examples=60, stateful_step_count=20, deadline=None)


@given(st.lists(st.tuples(ANYTHING, st.floats()), max_size=10))
def test_times_that_are_no_times_do_no_harm(steps):
    boss = Supervisor(LIMITS, 2)
    for what, now in steps:
        assert isinstance(boss.step(what, now).state, State)
