"""Frames in, estimates out: takes what fits, says what does not, and extrapolates to now."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from enum import Enum

from multilift.flight.estimate.cables import cable_state, worst
from multilift.flight.estimate.clock import CaptureClock
from multilift.flight.estimate.config import Cable, Tuning
from multilift.flight.estimate.state import BodyState, Estimate, Fault, Standing
from multilift.flight.estimate.tracker import Tracker, is_pose
from multilift.flight.mocap.frames import IDENTITY, Frame, Pose

#: Clocks beyond this many seconds have no microseconds left in double precision.
_LONGEST = 1e9


class Verdict(Enum):
    """What became of a frame."""

    NEW = "new"
    """Its poses were looked at."""
    DUPLICATE = "duplicate"
    """Of the same time as the last."""
    LATE = "late"
    """Older than one that came before."""
    CLOCK = "clock"
    """Held up, or of a clock that jumped."""
    MALFORMED = "malformed"
    """With times that are no times."""


_FAULTS = {
    Verdict.DUPLICATE: Fault.FROZEN,
    Verdict.LATE: Fault.FROZEN,
    Verdict.CLOCK: Fault.CLOCK,
    Verdict.MALFORMED: Fault.CLOCK,
}


class Estimator:
    """The state of all bodies and cables, from frames of one source.

    Attributes:
        counts: of frames, by their verdicts' values.
    """

    def __init__(
        self, bodies: Sequence[str], cables: Sequence[Cable] = (), tuning: Tuning | None = None
    ) -> None:
        """Bodies by their names in frames; those of cables must be among them."""
        self.tuning = tuning or Tuning()
        self.counts: Counter[str] = Counter()
        self._cables = tuple(cables)
        self._trackers = {name: Tracker(self.tuning) for name in bodies}
        self._clock = CaptureClock(self.tuning.clock_slack, self.tuning.rebirth)
        self._last_time = -math.inf
        self._received = -math.inf
        self._fault = Fault.NONE
        self._since = 0.0
        for cable in self._cables:
            if not {cable.vehicle, cable.payload} <= set(bodies):
                raise ValueError(f"{cable} ties bodies that are not among {list(bodies)}")

    def accept(self, frame: Frame) -> Verdict:
        """Take in a frame; never raises, whatever is in it."""
        verdict = self._judge(frame)
        self.counts[verdict.value] += 1
        fault = _FAULTS.get(verdict, Fault.NONE)
        if fault is not self._fault:
            self._fault, self._since = fault, self._received
        return verdict

    def forget(self) -> None:
        """Start anew, as after bodies were carried about: each is where it is seen next."""
        self._trackers = {name: Tracker(self.tuning) for name in self._trackers}

    def at(self, now: float) -> Estimate:
        """Everything, extrapolated to a time.

        Args:
            now: `time.monotonic()`, s; not before the last frame was received.
        """
        time = now - self._clock.offset + self.tuning.latency  # NaN before the first frame
        stream, since = self._fault, self._since
        if now - self._received > self.tuning.coast:
            stream, since = Fault.SILENT, self._received
        bodies = {
            name: self._body(tracker, time, tracker.standing(time, now, stream, since))
            for name, tracker in self._trackers.items()
        }
        cables = tuple(cable_state(c, bodies[c.vehicle], bodies[c.payload]) for c in self._cables)
        return Estimate(now, worst(*(b.standing for b in bodies.values())), bodies, cables)

    def _body(self, tracker: Tracker, time: float, standing: Standing) -> BodyState:
        if tracker.filter is None:
            zero = (0.0, 0.0, 0.0)
            return BodyState(standing, zero, zero, zero, IDENTITY, zero, math.inf, math.inf)
        dt = min(max(0.0, time - tracker.filter.time), self.tuning.lost)
        position, velocity, acceleration = tracker.filter.motion(dt)
        attitude, rate = tracker.filter.turning(dt)
        sigmas = tracker.filter.sigmas(dt)
        return BodyState(standing, position, velocity, acceleration, attitude, rate, *sigmas)

    def _judge(self, frame: Frame) -> Verdict:
        received = frame.received_time
        capture = received if frame.capture_time is None else frame.capture_time
        if not (abs(received) < _LONGEST and abs(capture) < _LONGEST):  # NaN is neither
            return Verdict.MALFORMED
        if received < self._received:
            return Verdict.LATE
        self._received = received
        if capture == self._last_time:
            return Verdict.DUPLICATE
        if not self._clock.fits(capture, received):
            ahead = self._clock.jumped(capture, received)
            if ahead is None:
                return Verdict.CLOCK
            self._last_time += ahead
            for tracker in self._trackers.values():
                tracker.shift(ahead)
        if capture <= self._last_time:
            return Verdict.LATE
        self._last_time = capture
        self._update(capture, received, frame)
        return Verdict.NEW

    def _update(self, time: float, received: float, frame: Frame) -> None:
        strays: dict[str, Pose] = {}
        idle: set[str] = set()
        for name, tracker in self._trackers.items():
            pose = frame.bodies.get(name)
            if pose is None or not is_pose(pose):
                idle.add(name)
                tracker.miss(received, Fault.DROPPED)
            elif tracker.repeats(pose):
                idle.add(name)
                tracker.miss(received, Fault.FROZEN)
            elif tracker.filter is None or tracker.fits(time, pose):
                tracker.take(time, pose, received)
            else:
                strays[name] = pose
        self._settle_strays(time, received, strays, idle | set(strays))

    def _settle_strays(
        self, time: float, received: float, strays: dict[str, Pose], open_to: set[str]
    ) -> None:
        """Poses that do not fit their bodies: another's, whose own does not fit either, or wrong.

        A pose under another body's name is taken in where it belongs, and both bodies are said to
        be swapped for as long as that lasts. Bodies that come back after they were lost are not
        believed to be who they are said to be if they are where another one was.
        """
        swapped: set[str] = set()
        for name, pose in strays.items():
            for other in sorted(open_to - {name}):
                tracker = self._trackers[other]
                if tracker.fits(time, pose):
                    tracker.take(time, pose, received, Fault.SWAPPED)
                    open_to.discard(other)
                    swapped.add(name)
                    break
        for name, pose in strays.items():
            tracker = self._trackers[name]
            if name in swapped:
                if name in open_to:
                    tracker.miss(received, Fault.SWAPPED)
            elif tracker.contest(time, pose, received):
                if self._is_anothers(name, pose, open_to):
                    tracker.miss(received, Fault.SWAPPED)
                else:
                    tracker.believe(received)

    def _is_anothers(self, name: str, pose: Pose, open_to: set[str]) -> bool:
        """Whether a body that comes back does so nearer to where another one was lost."""
        own = self._trackers[name].distance(pose)
        return any(self._trackers[other].distance(pose) < own for other in open_to - {name})
