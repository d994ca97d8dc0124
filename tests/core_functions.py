"""The core's functions over arrays, as doubles and as lanes of each instruction set have them."""

import math

import mpmath
import numpy as np
from multilift import _core
from multilift.isa import available, kernel

exact = mpmath.mp.clone()
exact.prec = 150  # 53 bits of a result and ample more


def doubles(name, x, y=None):
    return _evaluated(_core, name, x, y)


def _evaluated(module, name, x, y):
    x = np.ascontiguousarray(x, dtype=float)
    y = x if y is None else np.ascontiguousarray(y, dtype=float)
    out = np.empty(len(x))
    module.evaluate(name, x, y, out)
    return out


def assert_lanes_agree(name, x, y=None):
    """Lanes of every instruction set here have a double's bits."""
    expected = doubles(name, x, y).view(np.uint64)
    for isa in available():
        found = _evaluated(kernel(isa), name, x, y).view(np.uint64)
        np.testing.assert_array_equal(found, expected, err_msg=f"{name} on {isa}")


def largest_error(found, truth):
    """The largest error in units in the last place of the truth, an iterable of mpmath's."""
    return max(
        float(abs(exact.mpf(float(a)) - b) / exact.mpf(math.ulp(float(b))))
        for a, b in zip(found, truth, strict=True)
    )


def same(found, expected):
    """Equal doubles, the sign of zero included; NaN equals NaN."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    both_nan = np.isnan(found) & np.isnan(expected)
    return bool(np.all(both_nan | (found.view(np.uint64) == expected.view(np.uint64))))
