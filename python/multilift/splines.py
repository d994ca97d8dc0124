"""Smooth ways through points, as polynomials in time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from multilift.errors import MissingExtraError

Array = NDArray[np.float64]

#: Of the pieces.
DEGREE = 7


def least_snap(time: Array, way: Array) -> list[tuple[float, list[list[float]]]]:
    """Through all points with the least snap, at rest at both ends: a spline of degree 7.

    Args:
        time: of each point, ascending, shape (n,), s.
        way: the points, shape (n, coordinates).

    Returns:
        Pieces: when each begins, s, and its coefficients of (t - begin)^0 to ^7 by coordinate.

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
    rows = np.array([spline(begins, nu=k) / math.factorial(k) for k in range(DEGREE + 1)])
    return [(float(begin), rows[:, k].T.tolist()) for k, begin in enumerate(begins)]
