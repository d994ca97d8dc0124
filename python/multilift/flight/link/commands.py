"""Commands that must be acknowledged: sent, awaited, sent again, given up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pymavlink.dialects.v20 import common as mavlink

#: How long an answer may take, s, and how often a command is sent in all.
_PATIENCE = 0.5
_TRIES = 5

#: Once it is in progress.
_LONG_PATIENCE = 10.0

_RESULTS = {
    mavlink.MAV_RESULT_ACCEPTED: "accepted",
    mavlink.MAV_RESULT_TEMPORARILY_REJECTED: "rejected for now",
    mavlink.MAV_RESULT_DENIED: "denied",
    mavlink.MAV_RESULT_UNSUPPORTED: "unsupported",
    mavlink.MAV_RESULT_FAILED: "failed",
    mavlink.MAV_RESULT_IN_PROGRESS: "in progress",
}


@dataclass
class Command:
    """One command under way or done.

    Attributes:
        number: MAV_CMD.
        parameters: its seven.
        outcome: "" while awaited, then "accepted", "denied", ..., or "no answer".
        tries: how often it was sent.
    """

    number: int
    parameters: tuple[float, ...]
    outcome: str = ""
    tries: int = 0
    _due: float = 0.0
    _given_up: float = float("inf")

    @property
    def accepted(self) -> bool:
        """Whether the vehicle took it."""
        return self.outcome == "accepted"


class Commands:
    """The commands of one link; of each number at most one is under way."""

    def __init__(self) -> None:
        self._awaited: dict[int, Command] = {}

    def put(self, number: int, parameters: tuple[float, ...], now: float) -> Command:
        """Takes a command up; one of its number that is under way is forgotten as cancelled."""
        old = self._awaited.get(number)
        if old is not None:
            old.outcome = "cancelled"
        full = tuple(parameters) + (0.0,) * (7 - len(parameters))
        command = Command(number, full, _due=now)
        self._awaited[number] = command
        return command

    def due(self, now: float) -> Iterator[Command]:
        """The commands to be sent now; `tries` less one is their confirmation."""
        for command in list(self._awaited.values()):
            if now < command._due:
                continue
            if command.tries >= _TRIES or now >= command._given_up:
                command.outcome = "no answer"
                del self._awaited[command.number]
                continue
            command.tries += 1
            command._due = now + _PATIENCE
            yield command

    def sees(self, number: int, result: int, now: float) -> Command | None:
        """Takes in an acknowledgement.

        Returns:
            The command that is done by it; None if it is for none, or tells of progress.
        """
        command = self._awaited.get(number)
        if command is None or command.tries == 0:
            return None
        if result == mavlink.MAV_RESULT_IN_PROGRESS:
            command._due = command._given_up = now + _LONG_PATIENCE
            return None
        command.outcome = _RESULTS.get(result, f"result {result}")
        del self._awaited[number]
        return command

    @property
    def under_way(self) -> int:
        """How many are awaited."""
        return len(self._awaited)
