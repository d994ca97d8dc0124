"""The states of a flight and every way from one to another.

As data, which flights, tests and the drawing in the documentation all read.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from enum import Enum


class State(Enum):
    """What all vehicles are doing; the value is how people read it."""

    IDLE = "idle"
    PREFLIGHT = "pre-flight"
    ARMED = "arming"
    TAKE_OFF = "take-off"
    FORM_UP = "form up"
    LIFT = "lift"
    FLY = "fly"
    PAUSE = "pause"
    SET_DOWN = "set down"
    LAND = "land"
    HOLD = "hold"
    LAND_APART = "land apart"
    KILL = "kill"


class Event(Enum):
    """Why a state ends, the most urgent first: of several at once, the first counts."""

    KILL = "the pilot kills"
    ALL_DISARMED = "all disarmed"
    TROUBLE = "trouble"
    HOLD_OVER = "hold is over or useless"
    HOLD_WORD = "the pilot holds"
    LAND_WORD = "the pilot lands"
    START_WORD = "the pilot starts"
    GO_WORD = "the pilot says go"
    ALL_ARMED = "all armed"
    DONE = "done"
    TOO_LONG = "takes too long"


@dataclass(frozen=True)
class Transition:
    """One way from a state to another."""

    start: State
    event: Event
    end: State


#: The regular flight, in order; what each does when it is done is to begin the next.
COURSE = (State.TAKE_OFF, State.FORM_UP, State.LIFT, State.FLY, State.SET_DOWN, State.LAND)

#: Vehicles are in the air, follow our set-points and go by a plan.
FLYING = (*COURSE[:-1], State.PAUSE)

#: With the load in the air the pilot's landing begins with setting it down.
_CARRYING = (State.LIFT, State.FLY, State.PAUSE)

#: How long each may take, s.
MOST_TIME = {
    State.IDLE: math.inf,
    State.PREFLIGHT: 600.0,
    State.ARMED: 10.0,
    State.TAKE_OFF: 30.0,
    State.FORM_UP: 60.0,
    State.LIFT: 60.0,
    State.FLY: math.inf,
    State.PAUSE: 60.0,
    State.SET_DOWN: 60.0,
    State.LAND: 60.0,
    State.HOLD: math.inf,
    State.LAND_APART: 60.0,
    State.KILL: 10.0,
}

TRANSITIONS = (
    Transition(State.IDLE, Event.START_WORD, State.PREFLIGHT),
    Transition(State.PREFLIGHT, Event.GO_WORD, State.ARMED),
    Transition(State.PREFLIGHT, Event.LAND_WORD, State.IDLE),
    Transition(State.PREFLIGHT, Event.TOO_LONG, State.IDLE),
    Transition(State.ARMED, Event.ALL_ARMED, State.TAKE_OFF),
    *(Transition(State.ARMED, event, State.LAND)
      for event in (Event.TROUBLE, Event.HOLD_WORD, Event.LAND_WORD, Event.TOO_LONG)),
    *(Transition(start, Event.DONE, end) for start, end in itertools.pairwise(COURSE)),
    *(Transition(state, Event.TROUBLE, State.HOLD) for state in FLYING),
    *(Transition(state, Event.HOLD_WORD, State.HOLD)
      for state in FLYING if state not in (State.FLY, State.PAUSE)),
    *(Transition(state, Event.TOO_LONG, State.HOLD)
      for state in FLYING if state is not State.PAUSE),
    Transition(State.FLY, Event.HOLD_WORD, State.PAUSE),
    Transition(State.PAUSE, Event.GO_WORD, State.FLY),
    Transition(State.PAUSE, Event.TOO_LONG, State.SET_DOWN),
    *(Transition(state, Event.LAND_WORD, State.SET_DOWN) for state in _CARRYING),
    *(Transition(state, Event.LAND_WORD, State.LAND) for state in (State.TAKE_OFF, State.FORM_UP)),
    *(Transition(State.LAND, event, State.LAND_APART)
      for event in (Event.TROUBLE, Event.TOO_LONG)),
    Transition(State.HOLD, Event.HOLD_OVER, State.LAND_APART),
    Transition(State.HOLD, Event.LAND_WORD, State.LAND_APART),
    Transition(State.LAND_APART, Event.TOO_LONG, State.KILL),
    *(Transition(state, Event.KILL, State.KILL)
      for state in State if state not in (State.IDLE, State.KILL)),
    *(Transition(state, Event.ALL_DISARMED, State.IDLE)
      for state in (State.LAND, State.HOLD, State.LAND_APART, State.KILL)),
    Transition(State.KILL, Event.TOO_LONG, State.IDLE),
)  # fmt: skip

#: The same by state, the most urgent event first.
WAYS: dict[State, dict[Event, State]] = {
    state: {e: t.end for e in Event for t in TRANSITIONS if (t.start, t.event) == (state, e)}
    for state in State
}
