"""What the tables [reference] of all models share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ScenarioError

Array = NDArray[np.float64]

_COUNTS = {2: "two", 4: "four"}


def needed(reference: Mapping[str, Any], key: str, where: str) -> Any:
    """A value that this kind of reference cannot do without.

    Args:
        reference: the table.
        key: in it.
        where: the scenario, for the error.

    Raises:
        ScenarioError: if it is missing or empty.
    """
    value = reference[key]
    if value is None or value == []:
        raise ScenarioError(
            "is missing",
            where=where,
            key=f"reference.{key}",
            advice=f"a reference of kind {reference['kind']!r} needs it",
        )
    return value


def waypoints(
    reference: Mapping[str, Any], start: Array, goal: Array, names: str, where: str
) -> tuple[Array, Array]:
    """The points of a reference of waypoints, checked, with the start before them.

    Args:
        reference: the table.
        start: relative to the goal, shape (coordinates,).
        goal: shape (coordinates,).
        names: of the coordinates, for the error.
        where: the scenario, for the error.

    Returns:
        When each is passed, s, shape (points + 1,), and each relative to the goal, shape
        (points + 1, coordinates).

    Raises:
        ScenarioError: if points or times are missing, do not fit each other or end elsewhere.
    """
    times = np.array(needed(reference, "times", where))
    points = np.array(needed(reference, "points", where))
    count = len(goal)
    if points.size != count * times.size or (np.diff(times, prepend=0.0) <= 0).any():
        raise ScenarioError(
            f"has {points.size} numbers for {times.size} times",
            where=where,
            key="reference.points",
            value=points.tolist(),
            permitted=f"{_COUNTS[count]} numbers, {names}, for each of the ascending times above 0",
        )
    way = np.vstack([start, points.reshape(-1, count) - goal])
    if np.abs(way[-1]).max() > 1e-9:
        raise ScenarioError(
            "does not end at the goal",
            where=where,
            key="reference.points",
            value=points[-count:].tolist(),
            permitted=f"the last {_COUNTS[count]} numbers: {goal.tolist()}",
        )
    return np.append(0.0, times), way
