"""The ground station flies twins from floor to floor, through all wires, without a clock."""

import math

import numpy as np
import pytest
from multilift.flight import lab
from multilift.flight.supervisor import State, Word
from multilift.flight.supervisor.states import COURSE
from multilift.flight.twin.stepped import SteppedFlight


def short_lab(folder, duration=4.0, **changes):
    """Exp 1-1's bar, moved by 30 cm in a shortened flight."""
    from multilift import scenario

    flown = scenario.load("exp1_1_quadrotors").with_values({
        "goal.payload_position": [-0.5, 0.0, 0.9],
        "reference.kind": "min_snap",
        "reference.start": 0.0,
        "reference.duration": 2.5,
        "simulation.duration": duration,
        **changes,
    })  # fmt: skip
    (folder / "short.toml").write_text(flown.to_toml())
    return lab.parse({"scenario": "short.toml"}, "lab", folder)


class Watched:
    """A flight with what passes by."""

    def __init__(self, folder, seed=1):
        self.flight = SteppedFlight(short_lab(folder), seed)
        self.states, self.track, self.refused = [], [], 0

    def fly(self):
        flight = self.flight
        assert flight.prepare()
        flight.station.say(Word.GO)
        assert flight.run(90.0, self._look), flight.station.supervisor.told
        flight.close()
        return self

    def _look(self):
        flight = self.flight
        state = flight.station.supervisor.state
        if not self.states or state is not self.states[-1]:
            self.states.append(state)
        self.track.append(np.concatenate([flight.world.vehicle.ravel(), flight.world.payload]))
        return state is State.IDLE


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    return Watched(tmp_path_factory.mktemp("lab")).fly()


def test_a_regular_flight_takes_the_course_and_ends_on_the_floor(flown):
    assert flown.states == [State.PREFLIGHT, State.ARMED, *COURSE, State.IDLE]
    world = flown.flight.world
    assert world.standing.all()
    assert world.status == "running"
    assert not any(link.status.armed for link in flown.flight.station.links)


def test_load_and_vehicles_come_down_where_they_should(flown):
    track = np.array(flown.track)
    load = track[:, -3:]
    assert load[:, 2].max() > 0.85
    # Set down below where it was flown to, to a part of the swing that it still had.
    assert load[-1, :2] == pytest.approx([-0.5, 0.0], abs=0.05)
    # Beside their ends of the bar, outwards.
    offset = track[-1, :6].reshape(2, 3)[:, 0] - load[-1, 0]
    assert offset[0] < -0.75
    assert offset[1] > 0.75


def test_the_pair_is_never_nearer_than_the_lab_allows(flown):
    assert flown.flight.separation > flown.flight.lab.limits.separation


def test_every_set_point_is_of_a_fresh_state(flown):
    limits, times = flown.flight.lab.limits, flown.flight.station.times
    assert times.latency.count > 1000
    assert times.latency.most <= limits.state_age
    assert times.latency.quantile(0.5) <= times.latency.quantile(0.999) <= times.latency.most
    # What was refused was refused before motion capture had been seen.
    for link in flown.flight.station.links:
        assert set(link.freshness.refused) <= {"stale"}
        assert sum(link.guard.dropped.values()) == 0


def test_thrust_is_learnt_and_tensions_are_seen(flown):
    station = flown.flight.station
    for link, vehicle in zip(station.links, flown.flight.lab.vehicles, strict=True):
        # The twin's rotors are what the lab file says: nothing is to be learnt.
        assert link.thrust.hover_now == pytest.approx(vehicle.hover_thrust, rel=0.02)
    assert station.pulls.slack == [True, True]


def test_the_same_seed_flies_the_same_flight_to_the_last_bit(flown, tmp_path):
    again = Watched(tmp_path)
    again.flight.prepare()
    again.flight.station.say(Word.GO)
    again.flight.run(8.0, again._look)
    again.flight.close()
    assert np.array_equal(np.array(again.track), np.array(flown.track)[: len(again.track)])


def test_another_seed_flies_another_flight(flown, tmp_path):
    other = Watched(tmp_path, seed=2)
    other.flight.prepare()
    other.flight.station.say(Word.GO)
    other.flight.run(2.0, other._look)
    other.flight.close()
    assert not math.isclose(other.track[-1][0], flown.track[len(other.track) - 1][0], abs_tol=0.0)
