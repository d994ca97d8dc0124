"""How a spatial run can end, in words."""

from __future__ import annotations

#: Names of the core's statuses, by their code; spatial runs end in three of them.
STATUSES = ("finished", "diverged", "slack", "swing_limit", "collision")

#: Those in the order in which tables and figures show them.
OUTCOMES = ("finished", "collision", "diverged")


def reason(status: str) -> str:
    """Why a run ended, in a few words; empty if it finished."""
    return {
        "finished": "",
        "collision": "vehicles, or a vehicle and a cable, came too close",
        "diverged": "diverged",
        "left": "the flight left its course",
    }[status]
