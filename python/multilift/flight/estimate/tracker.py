"""One body: its filter, and what was wrong with its last pose."""

from __future__ import annotations

import math

from multilift.flight.estimate.config import Tuning
from multilift.flight.estimate.filter import PoseFilter
from multilift.flight.estimate.state import Fault, Quality, Standing
from multilift.flight.mocap.frames import Pose

#: Positions beyond this are no positions in a room, m.
_FARTHEST = 1e4

#: Poses after which a challenger may take the filter's place, besides the time.
_LEAST_POSES = 5


def is_pose(pose: Pose | None) -> bool:
    """Whether a pose is there, of numbers, and somewhere on earth."""
    return pose is not None and pose.is_finite and math.hypot(*pose.position) < _FARTHEST


class Tracker:
    """What is known of one body.

    Attributes:
        filter: None before the first pose.
        fault: of the last frame; NONE where its pose was taken in.
        since: when this fault began, `time.monotonic()`, s.
    """

    def __init__(self, tuning: Tuning) -> None:
        self._tuning = tuning
        self.filter: PoseFilter | None = None
        self.fault = Fault.UNSEEN
        self.since = 0.0
        self._sound = 0.0
        self._challenger: PoseFilter | None = None
        self._last: Pose | None = None

    def repeats(self, pose: Pose) -> bool:
        """Whether a pose is the last one again, to the last bit: no camera sees that."""
        last, self._last = self._last, pose
        return (
            last is not None and pose.position == last.position and pose.attitude == last.attitude
        )

    def fits(self, time: float, pose: Pose) -> bool:
        """Whether a pose goes with what is known."""
        return self.filter is not None and self.filter.fits(time, pose)

    def take(self, time: float, pose: Pose, received: float, fault: Fault = Fault.NONE) -> None:
        """Take in a pose that fits, or the first; the fault is how it came about."""
        if self.filter is None:
            self.filter = PoseFilter(self._tuning, time, pose)
            self._sound = time + self._tuning.settle
        else:
            self.filter.take(time, pose)
        self._challenger = None
        self._note(fault, received)

    def miss(self, received: float, fault: Fault) -> None:
        """There was no pose to take in."""
        if self.filter is not None:
            self._note(fault, received)

    def contest(self, time: float, pose: Pose, received: float) -> bool:
        """A pose does not fit; whether it and those before it agree for long enough to be right."""
        self._note(Fault.JUMP, received)
        challenger = self._challenger
        if challenger is None or not challenger.fits(time, pose):
            self._challenger = PoseFilter(self._tuning, time, pose)
            return False
        challenger.take(time, pose)
        lasted = time - challenger.born >= self._tuning.rebirth
        return lasted and challenger.count >= _LEAST_POSES

    def believe(self, received: float) -> None:
        """What was contested was right."""
        assert self._challenger is not None
        self.filter, self._challenger = self._challenger, None
        self._sound = self.filter.born + self._tuning.settle
        self._note(Fault.NONE, received)

    def distance(self, pose: Pose) -> float:
        """From where the body was last, m; infinite where it never was."""
        if self.filter is None:
            return math.inf
        return math.dist(self.filter.motion(0.0)[0], pose.position)

    def shift(self, by: float) -> None:
        """The source's clock jumped."""
        for pose_filter in (self.filter, self._challenger):
            if pose_filter is not None:
                pose_filter.shift(by)
        self._sound += by

    def standing(self, time: float, now: float, stream: Fault, since: float) -> Standing:
        """How far to trust the filter.

        Args:
            time: the present by the source's clock, s.
            now: the present, `time.monotonic()`, s.
            stream: what is wrong with all frames, over what is wrong with this body.
            since: when that began, s.
        """
        tuning = self._tuning
        if self.filter is None:
            return Standing(Quality.NONE, Fault.UNSEEN, now, math.inf)
        fault, began = (self.fault, self.since) if stream is Fault.NONE else (stream, since)
        age = max(0.0, time - self.filter.time)
        if age > tuning.lost:
            quality = Quality.LOST
        elif age > tuning.coast or fault is Fault.SWAPPED:
            quality = Quality.SUSPECT
        elif fault is not Fault.NONE:
            sound = self.filter.time >= self._sound
            quality = Quality.COASTING if sound else Quality.SUSPECT
        elif self.filter.time < self._sound:
            return Standing(Quality.CONVERGING, Fault.STARTING, now, age)
        else:
            return Standing(Quality.GOOD, Fault.NONE, now, age)
        if fault is Fault.NONE:  # frames came, but none was new enough
            fault, began = Fault.SILENT, now
        return Standing(quality, fault, began, age)

    def _note(self, fault: Fault, received: float) -> None:
        if fault is not self.fault:
            self.fault, self.since = fault, received
