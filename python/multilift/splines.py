"""Smooth ways through points, as polynomials in time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from multilift import planning
from multilift.errors import MissingExtraError

Array = NDArray[np.float64]
#: When it begins, s, and its coefficients of (t - begin)^0 to ^9 by coordinate.
Piece = tuple[float, list[list[float]]]

#: Of the pieces; higher coefficients are zero.
DEGREE = 7


def least_snap(time: Array, way: Array) -> list[Piece]:
    """Through all points with the least snap, at rest at both ends: a spline of degree 7.

    Args:
        time: of each point, ascending, shape (n,), s.
        way: the points, shape (n, coordinates).

    Returns:
        Pieces: when each begins, s, and its coefficients of (t - begin)^0 to ^9 by coordinate.

    Raises:
        MissingExtraError: without SciPy (``multilift[plan]``).
    """
    try:
        from scipy.interpolate import make_interp_spline  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("scipy", "plan", "this reference") from None
    still = [(order, np.zeros(way.shape[1])) for order in (1, 2, 3)]
    spline = make_interp_spline(time, way, k=DEGREE, bc_type=(still, still))
    begins = np.unique(spline.t)[:-1]
    # The Taylor series at the beginning of each piece, which is all of it.
    rows = np.zeros((planning.DEGREE + 1, len(begins), way.shape[1]))
    for k in range(DEGREE + 1):
        rows[k] = spline(begins, nu=k) / math.factorial(k)
    return [(float(begin), rows[:, k].T.tolist()) for k, begin in enumerate(begins)]


def wait(way: list[Piece]) -> list[Piece]:
    """The way with a rest at its beginning until it starts."""
    if way[0][0] == 0.0:
        return way
    still = [[row[0], *[0.0] * planning.DEGREE] for row in way[0][1]]
    return [(0.0, still), *way]
