"""Random moves to plan, and how fast ways get."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from multilift import planning
from multilift.planning import Limits


def random_moves(
    count: int, seed: int, part: float
) -> Iterator[tuple[np.ndarray, np.ndarray, Limits, Any]]:
    """Random limits, goals at rest or moving; starts at rest or with this part of each limit."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        limits = Limits(*rng.uniform([0.5, 0.5, 2.0, 10.0], [4.0, 6.0, 40.0, 400.0]))
        start = np.zeros((2, 5))
        start[:, 0] = rng.normal(0.0, 3.0, 2)
        kind = rng.integers(3)
        if kind:
            start[:, 1:] = part * rng.uniform(-0.7, 0.7, (2, 4)) * limits.numbers
        moving = rng.uniform(-0.3, 0.3, 2) * limits.speed if kind == 2 else None
        yield start, rng.normal(0.0, 3.0, 2), limits, moving


def greatest(ways: list[planning.Way], count: int = 16) -> np.ndarray:
    """Greatest sizes of velocity to snap of each way, shape (ways, 4), by sampling its pieces."""
    owner, span, rows = [], [], []
    for k, way in enumerate(ways):
        pieces = way.pieces
        ends = [*(begin for begin, _ in pieces[1:]), way.end]
        for (begin, coefficients), end in zip(pieces, ends, strict=True):
            owner.append(k)
            span.append(min(end - begin, 1.0))  # behind a goal that moves nothing changes
            rows.append(coefficients)
    t = np.linspace(0.0, 1.0, count)[None, :, None] * np.array(span)[:, None, None]
    c = np.array(rows)
    top = np.zeros((len(ways), 4))
    for order in range(4):
        c = c[:, :, 1:] * np.arange(1, c.shape[2])
        value = np.zeros((len(span), count, c.shape[1]))
        for k in range(c.shape[2] - 1, -1, -1):
            value = value * t + c[:, None, :, k]
        np.maximum.at(top[:, order], owner, np.linalg.norm(value, axis=2).max(axis=1))
    return top
