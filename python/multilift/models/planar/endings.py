"""How a planar run can end, in words."""

from __future__ import annotations

from multilift.run import Run

#: Names of the core's statuses, by their code.
STATUSES = ("finished", "diverged", "slack", "swing_limit")

#: The same in the order in which tables and figures show them.
OUTCOMES = ("finished", "slack", "swing_limit", "diverged")

#: Of what a culprit is the index: two cables, three angles.
CULPRITS = 3


def reason(status: str, culprit: int) -> str:
    """Why a run ended, in a few words; empty if it finished."""
    return {
        "finished": "",
        "slack": f"cable {culprit + 1} would go slack",
        "swing_limit": f"|theta{culprit + 1}| reached 90 degrees",
        "diverged": "diverged",
    }[status]


def sentence(run: Run) -> str:
    """How a run ended, as a sentence."""
    when = f"at t = {run.end_time:.3f} s"
    if run.status == "finished":
        return f"ran to its end {when}, cables taut throughout"
    if run.status == "slack":
        return (
            f"stopped {when}: cable {run.culprit + 1} would go slack, where the taut-cable "
            "model ends"
        )
    if run.status == "swing_limit":
        return f"stopped {when}: |theta{run.culprit + 1}| reached 90 degrees, assumption 3"
    last = ", ".join(
        f"{name} = {run[name][-1]:.4g}"
        for name in ("y1", "z1", "y2", "z2", "theta1", "theta2", "theta3")
    )
    return f"diverged {when}: {last}"
