"""The supervisor: one state for all vehicles, stepped with what is seen and the time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

from multilift.flight.lab import Limits
from multilift.flight.supervisor import trouble
from multilift.flight.supervisor.seen import Seen, VehicleSeen, Word
from multilift.flight.supervisor.states import FLYING, MOST_TIME, WAYS, Event, State

#: How long a hold that cannot help lasts, s.
_USELESS_HOLD = 0.5

#: How long where nothing can be sent, s: vehicles go on leaning as they last were told to.
_BLIND_HOLD = 0.1

#: How long a vehicle must look past saving before its thrust is cut, s.
_SURE = 0.3

#: How many troubles are kept to be told.
_TOLD = 200


class Order(Enum):
    """What one vehicle is to get now."""

    NOTHING = "nothing"
    WARM_UP = "set-points without thrust, so that it can take our mode"
    ARM = "the same, and the order to arm"
    TRACK = "set-points of the plan"
    STAY = "set-points that hold it where it is"
    DESCEND = "set-points down and away from the others"
    LAND = "the order to land by itself"
    DISARM = "the order to disarm"
    CUT = "the order to stop its motors at once"


#: Orders that are carried out by set-points.
BY_SET_POINT = (Order.WARM_UP, Order.ARM, Order.TRACK, Order.STAY, Order.DESCEND)

_WORDS = {
    Word.KILL: Event.KILL,
    Word.HOLD: Event.HOLD_WORD,
    Word.LAND: Event.LAND_WORD,
    Word.START: Event.START_WORD,
    Word.GO: Event.GO_WORD,
}


@dataclass(frozen=True)
class Orders:
    """What is to be done until the next step.

    Attributes:
        state: of all.
        vehicles: the order of each.
        may_send: whether set-points may go out at all.
        problems: what speaks against arming, or is wrong in flight, in words.
    """

    state: State
    vehicles: tuple[Order, ...]
    may_send: bool
    problems: tuple[str, ...]


@dataclass
class Supervisor:
    """All vehicles of one lab.

    Attributes:
        limits: what ends a flight.
        count: how many vehicles.
        flight_time: longest time in the air, s.
        state: now.
        told: when and why states changed, oldest first.
    """

    limits: Limits
    count: int
    flight_time: float = 600.0
    state: State = State.IDLE
    told: list[tuple[float, State, Event, str]] = field(default_factory=list)
    _now: float = -math.inf
    _since: float = -math.inf
    _armed_at: float = math.inf
    _boots: tuple[int, ...] = ()
    _by_itself: bool = False
    _doomed: list[float | None] = field(default_factory=list)
    _cut: list[bool] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._forget()

    @property
    def lasted(self) -> float:
        """How long the state has, s."""
        return self._now - self._since if math.isfinite(self._since) else 0.0

    def _forget(self) -> None:
        self._armed_at, self._by_itself = math.inf, False
        self._doomed, self._cut = [None] * self.count, [False] * self.count
        self._boots = (0,) * self.count

    def step(self, seen: Seen, now: float) -> Orders:
        """One step, as often as the loop runs.

        Args:
            seen: now.
            now: monotonic, s; a time that goes back counts as none passed.
        """
        assert len(seen.vehicles) == self.count
        self._now = max(self._now, now) if math.isfinite(now) else self._now
        problems = tuple(self._problems(seen))
        for event, end in WAYS[self.state].items():
            if self._happens(event, seen, problems):
                self._enter(end, event, seen, "; ".join(problems))
                break
        return self._orders(seen, problems)

    def _problems(self, seen: Seen) -> list[str]:
        if self.state in (State.IDLE, State.PREFLIGHT):
            return list(trouble.before_flight(seen, self.limits))
        found = list(trouble.in_flight(seen, self.limits, self.state, self._boots))
        if self.state in FLYING and self._now - self._armed_at > self.flight_time:
            found.append("in the air for too long")
        return found

    def _happens(self, event: Event, seen: Seen, problems: tuple[str, ...]) -> bool:
        lasted = self._now - self._since
        if event is Event.GO_WORD and problems:
            return False
        if event in _WORDS.values():
            return seen.word is not None and _WORDS[seen.word] is event
        happens = {
            Event.ALL_DISARMED: self._all(seen, armed=False),
            Event.ALL_ARMED: self._all(seen, armed=True),
            Event.TROUBLE: bool(problems),
            Event.DONE: seen.done,
            Event.TOO_LONG: lasted >= MOST_TIME[self.state],
            Event.HOLD_OVER: lasted >= self.limits.hold
            or (lasted >= _USELESS_HOLD and trouble.makes_hold_useless(seen, self.limits))
            or (lasted >= _BLIND_HOLD and not trouble.is_fresh(seen, self.limits)),
        }
        return happens[event]

    def _all(self, seen: Seen, *, armed: bool) -> bool:
        """Whether all say so, and said so lately."""
        return all(
            v.armed == armed and 0.0 <= v.link_age <= self.limits.link_age for v in seen.vehicles
        )

    def _enter(self, state: State, event: Event, seen: Seen, why: str) -> None:
        self.told = [*self.told[-_TOLD:], (self._now, state, event, why)]
        self.state, self._since = state, self._now
        if state is State.IDLE:
            self._forget()
        if state is State.ARMED:
            self._armed_at = self._now
            self._boots = tuple(v.boots for v in seen.vehicles)

    def _orders(self, seen: Seen, problems: tuple[str, ...]) -> Orders:
        self._watch(seen)
        fresh = trouble.is_fresh(seen, self.limits)
        # What landing by themselves has begun is not taken back: two ways down would cross.
        landing = self.state in (State.LAND, State.LAND_APART)
        self._by_itself |= landing and not fresh
        orders = tuple(self._order(k, v) for k, v in enumerate(seen.vehicles))
        return Orders(self.state, orders, fresh, problems)

    def _watch(self, seen: Seen) -> None:
        """Finds the vehicles whose thrust must be cut; once so, always so."""
        for k, vehicle in enumerate(seen.vehicles):
            lost = self.state is State.LAND_APART and trouble.is_past_saving(
                vehicle, seen, self.limits
            )
            first = self._doomed[k]
            self._doomed[k] = None if not lost else self._now if first is None else first
            if lost and first is not None and self._now - first >= _SURE:
                self._cut[k] = True

    def _order(self, k: int, vehicle: VehicleSeen) -> Order:
        if self.state is State.KILL or (self.state is State.LAND_APART and self._cut[k]):
            return Order.CUT
        if self.state in (State.LAND, State.LAND_APART):
            if vehicle.landed or not vehicle.armed:
                return Order.DISARM
            # Who does not follow set-points is told to land in the way that it does follow.
            alone = self._by_itself or not vehicle.follows
            return Order.LAND if alone else Order.DESCEND
        if self.state in FLYING:
            return Order.STAY if self.state is State.PAUSE else Order.TRACK
        return {
            State.IDLE: Order.NOTHING,
            State.PREFLIGHT: Order.WARM_UP,
            State.ARMED: Order.ARM,
            State.HOLD: Order.STAY,
        }[self.state]
