"""Outside forces as functions of time: what the ``[[push]]`` of all models have in common."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.overrides import Columns

START = Field("start", "when it begins", unit="s", range="non_negative", required=True)
DURATION = Field("duration", "how long it lasts", unit="s", range="positive", required=True)

#: The profile over time, of height 1.
PROFILE = (
    Field("shape", "profile over time, of height 1", "text", default="pulse",
          choices=("pulse", "half_sine", "sine", "samples")),
    Field("frequency", "of shape 'sine'", unit="Hz", range="positive"),
    Field("sample_times", "for shape 'samples': times after start, ascending", kind="list",
          unit="s"),
    Field("sample_values", "for shape 'samples': heights at these times, linear between",
          kind="list"),
)  # fmt: skip


def check_profile(push: dict[str, Any], key: str, where: str) -> None:
    """Refuses a profile that lacks what its shape needs.

    Args:
        push: the normalised table.
        key: its place, such as ``push[0]``.
        where: for errors.

    Raises:
        ScenarioError: naming the key that is missing or wrong.
    """
    if push["shape"] == "sine" and push["frequency"] is None:
        raise ScenarioError(
            "is missing", where=where, key=f"{key}.frequency", permitted="> 0 Hz",
            advice="shape 'sine' needs it",
        )  # fmt: skip
    times, heights = push["sample_times"] or [], push["sample_values"] or []
    if push["shape"] == "samples" and (
        len(times) < 2 or len(times) != len(heights) or (np.diff(times) <= 0).any()
    ):
        raise ScenarioError(
            "does not make a profile",
            where=where,
            key=f"{key}.sample_times",
            value=times,
            permitted="two or more ascending times, as many as sample_values",
        )


def check_steps(values: dict[str, Any], where: str) -> None:
    """Refuses pushes that the fixed step would miss or smear.

    Raises:
        ScenarioError: naming the push's duration and what fits.
    """
    step = float(values["simulation"]["step"])
    for k, push in enumerate(values["push"]):
        on_grid = all(
            abs(x / step - round(x / step)) < 1e-6 * max(1.0, x / step)
            for x in (push["start"], push["duration"])
        )
        if push["duration"] < (1 - 1e-6) * step or (push["shape"] == "pulse" and not on_grid):
            raise ScenarioError(
                "does not fit the integration step",
                where=where,
                key=f"push[{k}].duration",
                value=push["duration"],
                permitted=f"at least one step, {step:g} s; for a pulse, start and duration "
                "multiples of it",
                advice="round them, or give the same impulse over a longer time",
            )


def bad_worlds(columns: Columns) -> NDArray[np.bool_]:
    """Which worlds have a push that `check_steps` refuses."""
    step = columns.numbers("simulation.step")
    bad = np.zeros(columns.count, dtype=bool)
    for k, push in enumerate(columns.scenario.values["push"]):
        times = [columns.numbers(f"push[{k}].{name}") for name in ("start", "duration")]
        bad |= times[1] < (1 - 1e-6) * step
        if push["shape"] == "pulse":
            for time in times:
                off = np.abs(time / step - np.round(time / step))
                bad |= off >= 1e-6 * np.maximum(1.0, time / step)
    return bad


def heights(push: dict[str, Any], time: NDArray[np.float64]) -> NDArray[np.float64]:
    """A push's profile over time, of height 1, for pictures; the core has its own.

    Args:
        push: the normalised table.
        time: s.
    """
    since = time - push["start"]
    inside = (since >= 0.0) & (since < push["duration"])
    if push["shape"] == "half_sine":
        height = np.sin(np.pi * since / push["duration"])
    elif push["shape"] == "sine":
        height = np.sin(2.0 * np.pi * push["frequency"] * since)
    elif push["shape"] == "samples":
        height = np.interp(since, push["sample_times"], push["sample_values"], left=0.0, right=0.0)
    else:
        height = np.ones_like(since)
    return np.asarray(np.where(inside, height, 0.0))
