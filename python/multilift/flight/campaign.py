"""Flights with faults, drawn from a seed: ``python -m multilift.flight.campaign``.

Each flight is a twin's, stepped, through all wires; one thing goes wrong in it, at a time and of a
size that are drawn. It is judged by what is true, not by what the ground station saw.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import csv
import math
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from multilift.flight import lab as labs
from multilift.flight.log import Log, read
from multilift.flight.supervisor import State, Word
from multilift.flight.twin.cameras import CaptureFault
from multilift.flight.twin.stepped import START, SteppedFlight
from multilift.flight.twin.wire import Radio

#: A flight that is long enough for every fault and short enough for many: seconds of the law.
_DURATION = 4.0

#: How long a flight may take in all, s.
_PATIENCE = 150.0

#: Vehicles' centres nearer than this touch: a rotor disc and a half, m.
TOUCH = 0.5

#: How far beyond the fence nothing may ever be, m.
_BEYOND = 0.5

#: Faster than this nothing may come down: what legs and load stand, m/s.
_HARD = 1.5

#: A load that falls from where it hung, m/s.
_LOAD_HARD = 2.5

#: How far from the way that it was to be carried the load may lie in the end, m, and the vehicles
#: from the load; where a vehicle fell out of the air, the other pulls what is left about.
_STRAYED, _STRAYED_FALLEN = 0.5, 1.5
_SCATTERED = 2.5


@dataclass(frozen=True)
class Trial:
    """One flight of a campaign.

    Attributes:
        number: in the campaign.
        kind: of what goes wrong.
        at: when, counted from the order to take off, s.
        lasts: how long, s.
        vehicle: whose, or which body of motion capture.
        size: of it; what that is depends on the kind.
    """

    number: int
    kind: str
    at: float
    lasts: float
    vehicle: int
    size: float


@dataclass
class Outcome:
    """What became of a trial.

    Attributes:
        trial: which.
        ended: the supervisor's last state, "" where the ground station was gone.
        course: the states from take-off on.
        separation: least distance between two vehicles, m.
        landing: fastest touch-down of a vehicle, m/s.
        load_landing: of the load, m/s.
        faults: what must not be and was, in words; empty for a good flight.
    """

    trial: Trial
    ended: str
    course: tuple[str, ...]
    separation: float
    landing: float
    load_landing: float
    faults: list[str] = field(default_factory=list)


#: What goes wrong: by how much, from and to; for how long, from and to, s.
_KINDS: dict[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "radio loses": ((0.05, 0.5), (2.0, 20.0)),
    "radio delays": ((0.02, 0.25), (2.0, 20.0)),
    "radio jitters": ((0.01, 0.1), (2.0, 20.0)),
    "radio reorders": ((0.01, 0.05), (2.0, 20.0)),
    "link dies": ((0.0, 0.0), (0.3, 200.0)),
    "capture silent": ((0.0, 0.0), (0.05, 10.0)),
    "capture frozen": ((0.0, 0.0), (0.05, 10.0)),
    "capture jump": ((0.05, 1.0), (0.05, 5.0)),
    "capture swap": ((0.0, 0.0), (0.05, 5.0)),
    "capture drop": ((0.0, 0.0), (0.05, 10.0)),
    "capture noise": ((2.0, 20.0), (1.0, 10.0)),
    "capture clock": ((-2.0, 2.0), (5.0, 200.0)),
    "vehicle killed": ((0.0, 0.0), (200.0, 200.0)),
    "station killed": ((0.0, 0.0), (200.0, 200.0)),
    "vehicle masses": ((0.9, 1.1), (200.0, 200.0)),
    "load mass": ((0.7, 1.3), (200.0, 200.0)),
    "cable lengths": ((0.95, 1.05), (200.0, 200.0)),
    "battery sags": ((0.75, 0.95), (200.0, 200.0)),
    "pilot lands": ((0.0, 0.0), (0.0, 0.0)),
    "pilot holds": ((0.0, 0.0), (0.0, 0.0)),
}

KINDS = tuple(_KINDS)


def draw(seed: int, number: int) -> Trial:
    """The trial of a number in the campaign of a seed; kinds take turns."""
    dice = Random(f"{seed}/{number}")
    kind = KINDS[number % len(KINDS)]
    size, lasts = _KINDS[kind]
    body = dice.randrange(3) if kind.startswith("capture") else dice.randrange(2)
    return Trial(
        number, kind, round(dice.uniform(0.5, 24.0), 2), round(dice.uniform(*lasts), 2),
        body, round(dice.uniform(*size), 3),
    )  # fmt: skip


def lab_of(folder: Path) -> labs.Lab:
    """The lab of all trials: Exp 1-1's bar on a short way."""
    base = labs.load(labs.DEFAULT)
    flown = base.scenario.with_values({
        "goal.payload_position": [-0.45, 0.0, 0.88],
        "reference.kind": "min_snap",
        "reference.start": 0.0,
        "reference.duration": 3.0,
        "simulation.duration": _DURATION,
    })  # fmt: skip
    (folder / "campaign.toml").write_text(flown.to_toml(), encoding="utf-8")
    return labs.parse({"name": "campaign", "scenario": "campaign.toml"}, "campaign", folder)


class Referee:
    """Watches what is true in a flight."""

    def __init__(self, flight: SteppedFlight) -> None:
        self.flight = flight
        self.course: list[str] = []
        self.landing = self.load_landing = 0.0
        self.beyond = 0.0
        self._before = [True] * flight.world.count
        self._falling = [0.0] * flight.world.count
        self._load_before, self._load_falling = True, 0.0

    def look(self) -> None:
        """Once a step."""
        flight, world = self.flight, self.flight.world
        state = flight.station.supervisor.state.value
        if not self.course or state != self.course[-1]:
            self.course.append(state)
        limits = flight.lab.limits
        for k, (place, speed) in enumerate(
            zip(world.vehicle.tolist(), world.vehicle_velocity.tolist(), strict=True)
        ):
            for x, low, high in zip(place, limits.fence_low, limits.fence_high, strict=True):
                self.beyond = max(self.beyond, low - x, x - high)
            stands = bool(world.standing[k])
            if stands and not self._before[k]:
                self.landing = max(self.landing, self._falling[k])
            self._before[k], self._falling[k] = stands, -speed[2]
        stands = bool(world.payload_contact[2] > 0.0)
        if stands and not self._load_before:
            self.load_landing = max(self.load_landing, self._load_falling)
        self._load_before, self._load_falling = stands, -float(world.payload_velocity[2])


def fly(trial: Trial, seed: int, log: Path | None = None) -> Outcome:
    """Flies one trial.

    Args:
        trial: what goes wrong.
        seed: of radios and cameras.
        log: written where one is named.
    """
    with tempfile.TemporaryDirectory() as folder:
        lab = lab_of(Path(folder))
        written = None if log is None else Log(log, START)
        flight = SteppedFlight(lab, seed + trial.number, plant=_plant(trial, lab), log=written)
        try:
            return _fly(flight, trial)
        finally:
            flight.close()
            if written is not None:
                written.close()


def _fly(flight: SteppedFlight, trial: Trial) -> Outcome:
    referee = Referee(flight)
    ready = flight.prepare(30.0)
    flight.station.say(Word.GO)
    took_off = flight.run(10.0, lambda: flight.station.supervisor.state is State.TAKE_OFF)
    begin = flight.time + trial.at
    if trial.kind.startswith("capture"):
        kind = trial.kind.removeprefix("capture ")
        flight.cameras.faults = (
            CaptureFault(kind, begin, begin + trial.lasts, trial.vehicle, trial.size),
        )
    began = ended = False

    def is_over() -> bool:
        nonlocal began, ended
        referee.look()
        if not began and flight.time >= begin:
            began = True
            _break(flight, trial)
        if began and not ended and flight.time >= begin + trial.lasts:
            ended = True
            _mend(flight, trial)
        return not any(p.armed for p in flight.rig.autopilots) and bool(flight.world.standing.all())

    world = flight.world
    down = took_off and flight.run(_PATIENCE, is_over)
    # What lies still may not stay still: cables and load settle.
    end = flight.time + 2.0
    while flight.time < end and world.status == "running":
        flight.step()
        referee.look()
    state = flight.station.supervisor.state.value if flight.station_lives else ""
    outcome = Outcome(trial, state, tuple(referee.course), flight.separation, referee.landing,
                      referee.load_landing)  # fmt: skip
    killed = trial.kind == "vehicle killed"
    told: Sequence[tuple[bool, str]] = (
        (not ready, "was never ready"),
        (ready and not took_off, "did not take off"),
        (took_off and not down, "did not come down"),
        (world.status != "running", f"the plant ended: {world.status}"),
        (flight.separation < TOUCH, f"vehicles came within {flight.separation:.2f} m"),
        (_strayed(flight) > (_STRAYED_FALLEN if killed else _STRAYED),
         f"the load came down {_strayed(flight):.2f} m off its way"),
        (_scattered(flight) > _SCATTERED, f"a vehicle came down {_scattered(flight):.2f} m off"),
        (referee.beyond > _BEYOND, f"{referee.beyond:.2f} m beyond the fence"),
        (not killed and referee.landing > _HARD, f"landed with {referee.landing:.1f} m/s"),
        (not killed and referee.load_landing > _LOAD_HARD,
         f"the load fell with {referee.load_landing:.1f} m/s"),
        (flight.log is not None and flight.log.dropped > 0, "records were lost"),
    )  # fmt: skip
    outcome.faults = [text for is_so, text in told if is_so]
    return outcome


def _strayed(flight: SteppedFlight) -> float:
    """How far the load lies from the straight way that it was to be carried, seen from above, m."""
    values = flight.lab.scenario.values
    (a, b), (c, d) = (values[key]["payload_position"][:2] for key in ("start", "goal"))
    x, y = flight.world.payload[:2].tolist()
    u, v = c - a, d - b
    part = min(max(((x - a) * u + (y - b) * v) / max(u * u + v * v, 1e-12), 0.0), 1.0)
    return math.hypot(x - a - part * u, y - b - part * v)


def _scattered(flight: SteppedFlight) -> float:
    """How far the farthest vehicle stands from the load, seen from above, m."""
    x, y = flight.world.payload[:2].tolist()
    return max(math.hypot(a - x, b - y) for a, b, _z in flight.world.vehicle.tolist())


def _plant(trial: Trial, lab: labs.Lab) -> dict[str, Any]:
    """What is otherwise in the plant than the ground station believes."""
    plant, size = lab.scenario.values["plant"], trial.size
    if trial.kind == "vehicle masses":
        masses = [float(m) for m in _each(plant["vehicle_mass"], lab.scenario.count)]
        masses[trial.vehicle] *= size
        return {"plant.vehicle_mass": masses}
    if trial.kind == "load mass":
        return {"plant.payload_mass": float(plant["payload_mass"]) * size}
    if trial.kind == "cable lengths":
        lengths = [float(m) for m in _each(plant["cable_length"], lab.scenario.count)]
        lengths[trial.vehicle] *= size
        return {"plant.cable_length": lengths}
    return {}


def _each(value: Any, count: int) -> list[Any]:
    return list(value) if isinstance(value, (list, tuple)) else [value] * count


def _break(flight: SteppedFlight, trial: Trial) -> None:
    usual = flight.usual_radio
    radios = {
        "radio loses": Radio(usual.delay, usual.jitter, trial.size),
        "radio delays": Radio(usual.delay + trial.size, usual.jitter),
        "radio jitters": Radio(usual.delay, usual.jitter + trial.size),
        "radio reorders": Radio(usual.delay, usual.jitter + trial.size, 0.0, 0.2, True),
    }
    if trial.kind in radios:
        for air in flight.radios:  # one access point serves all
            air.radio = radios[trial.kind]
    actions: dict[str, Callable[[], None]] = {
        "link dies": lambda: setattr(flight.radios[trial.vehicle], "dead", True),
        "vehicle killed": lambda: flight.kill_vehicle(trial.vehicle),
        "station killed": lambda: setattr(flight, "station_lives", False),
        "battery sags": lambda: _sag(flight, trial),
        "pilot lands": lambda: flight.station.say(Word.LAND),
        "pilot holds": lambda: flight.station.say(Word.HOLD),
    }
    actions.get(trial.kind, lambda: None)()


def _sag(flight: SteppedFlight, trial: Trial) -> None:
    pilot = flight.rig.autopilots[trial.vehicle]
    pilot.strength = trial.size
    pilot.voltage *= math.sqrt(trial.size)


def _mend(flight: SteppedFlight, trial: Trial) -> None:
    for air in flight.radios:
        air.dead = False
        air.radio = flight.usual_radio


def command(seed: int, number: int) -> str:
    """What flies one trial again, with its log."""
    return (
        f"python -m multilift.flight.campaign --seed {seed} --only {number} "
        f"--log trial-{number}.mcap"
    )


def _one(seed: int, number: int) -> Outcome:
    return fly(draw(seed, number), seed)


def main() -> int:
    """Flies a campaign, prints what became of it, and fails if a flight did."""
    parser = argparse.ArgumentParser(prog="python -m multilift.flight.campaign")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--flights", type=int, default=300)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", type=int, help="fly this one alone")
    parser.add_argument("--log", type=Path, help="the log of that one")
    parser.add_argument("--output", type=Path, help="a table of all flights, CSV")
    asked = parser.parse_args()
    if asked.only is not None:
        outcome = fly(draw(asked.seed, asked.only), asked.seed, asked.log)
        _print(outcome)
        if asked.log is not None:
            print(f"{asked.log}: {sum(1 for _ in read(asked.log))} records")
        return 1 if outcome.faults else 0
    numbers = range(asked.flights)
    with concurrent.futures.ProcessPoolExecutor(asked.jobs) as pool:
        outcomes = []
        for outcome in pool.map(_one, [asked.seed] * asked.flights, numbers):
            outcomes.append(outcome)
            _print(outcome)
    if asked.output is not None:
        write(asked.output, outcomes)
    failed = [o for o in outcomes if o.faults]
    print(f"\n{len(outcomes) - len(failed)} of {len(outcomes)} flights as they should be")
    least = min(o.separation for o in outcomes)
    print(f"least distance between vehicles {least:.2f} m")
    for kind, number in Counter(o.trial.kind for o in failed).items():
        print(f"{kind}: {number} failed")
    for outcome in failed:
        print(f"{'; '.join(outcome.faults)}: {command(asked.seed, outcome.trial.number)}")
    return 1 if failed else 0


def write(path: Path, outcomes: Sequence[Outcome]) -> None:
    """A table of all flights."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["number", "kind", "at", "lasts", "vehicle", "size", "ended", "course",
                       "separation", "landing", "load_landing", "faults"])  # fmt: skip
        for o in outcomes:
            rows.writerow([*asdict(o.trial).values(), o.ended, " > ".join(o.course), o.separation,
                           o.landing, o.load_landing, "; ".join(o.faults)])  # fmt: skip


def _print(outcome: Outcome) -> None:
    trial = outcome.trial
    end = next((s for s in reversed(outcome.course) if s != State.IDLE.value), "")
    print(
        f"{trial.number:4d}  {trial.kind:15s} at {trial.at:5.2f} s for {trial.lasts:6.2f} s, "
        f"{trial.size:6.3f}, of {trial.vehicle}: {end:10s} apart {outcome.separation:.2f} m, "
        f"down with {outcome.landing:.2f} m/s, load {outcome.load_landing:.2f} m/s  "
        f"{'; '.join(outcome.faults) or 'ok'}",
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main())
