"""Meshes of intervals over a move, on a grid that halves, so that a fixed step can replay them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Mesh:
    """Intervals by their widths in cells; all cells of a move last equally long.

    Attributes:
        widths: of the intervals, cells, shape (intervals,).
    """

    widths: NDArray[np.int64]

    @classmethod
    def even(cls, intervals: int, cells: int) -> Mesh:
        """Intervals of the same width."""
        return cls(np.full(intervals, cells, dtype=np.int64))

    @property
    def cells(self) -> int:
        """Of the whole move."""
        return int(self.widths.sum())

    @property
    def fractions(self) -> NDArray[np.float64]:
        """Each interval's part of the move, shape (intervals,)."""
        return np.asarray(self.widths / self.cells)

    @property
    def edges(self) -> NDArray[np.float64]:
        """Where intervals begin and end, as parts of the move, shape (intervals + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.widths) / self.cells])

    def split(self, chosen: NDArray[np.bool_]) -> Mesh:
        """Halves the chosen intervals; those of one cell stay."""
        parts = [
            [w // 2, w - w // 2] if halve and w > 1 else [w]
            for w, halve in zip(self.widths.tolist(), chosen, strict=True)
        ]
        return Mesh(np.concatenate(parts).astype(np.int64))

    def owner(self, part: NDArray[np.float64]) -> NDArray[np.intp]:
        """The interval that holds each part of the move in [0, 1]."""
        found = np.searchsorted(self.edges, part, side="right") - 1
        return np.clip(found, 0, len(self.widths) - 1)


def jumps(mesh: Mesh, inputs: NDArray[np.float64], scale: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Intervals beside a jump of the inputs, where a narrower one would serve better.

    Args:
        mesh: of the inputs.
        inputs: held in each interval, shape (intervals, inputs).
        scale: what a whole jump measures, shape (inputs,).
    """
    jump = (np.abs(np.diff(inputs, axis=0)) > 0.05 * scale).any(axis=1)
    beside = np.zeros(len(mesh.widths), dtype=bool)
    beside[:-1] |= jump
    beside[1:] |= jump
    return beside
