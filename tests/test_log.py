"""The core's natural logarithm against mpmath's, for every positive normal double."""

import math

import numpy as np
import pytest
from core_functions import assert_lanes_agree, doubles, exact, largest_error, same

generator = np.random.default_rng(1)
draw = generator.uniform
LEAST, GREATEST = np.finfo(float).tiny, np.finfo(float).max
FOLD = math.sqrt(0.5)  # times powers of two: where the fraction changes sides


def around(points):
    """Each point with 50 doubles to either side."""
    return np.concatenate(
        [np.asarray(points) * (1 + k * 2.0**-52) for k in range(-50, 51)], dtype=float
    )


arguments = {
    "of_box_and_muller": (generator.integers(0, 2**32, 20000) + 0.5) * 2.0**-32,
    "unreduced": draw(FOLD, 2 * FOLD, 20000),
    "beside_one": 1 + draw(-1, 1, 10000) * 2.0 ** draw(-53, -2, 10000),
    "anywhere": 2.0 ** draw(-1022, 1023.99, 20000),
    "beside_folds": around([FOLD * 2.0**k for k in (-1021, -500, -2, -1, 0, 1, 2, 3, 700)]),
    "beside_powers": around([2.0**k for k in (-1021, -33, -2, -1, 0, 1, 2, 52, 1022)]),
    "where_errors_are_greatest": draw(0.700, 0.704, 10000),
    "ends": np.array([LEAST, np.nextafter(LEAST, 1), np.nextafter(GREATEST, 0), GREATEST]),
}


@pytest.mark.parametrize("x", arguments.values(), ids=arguments.keys())
def test_error_is_below_one_last_place(x):
    # Half a last place of the final sum; of the roundings of s, of s (f - p) and of the sum inside
    # less than another half where results are smallest against f. Largest found in millions: 0.96.
    assert largest_error(doubles("log", x), map(exact.log, map(exact.mpf, x.tolist()))) < 1.0


@pytest.mark.parametrize("x", arguments.values(), ids=arguments.keys())
def test_lanes_compute_a_doubles_bits(x):
    assert_lanes_agree("log", x)


def test_one_has_zero_and_what_is_not_positive_and_normal_has_none():
    assert same(doubles("log", [1.0]), [0.0])
    x = np.array([0.0, -0.0, -1.0, np.inf, -np.inf, np.nan, 5e-324, np.nextafter(LEAST, 0)])
    assert np.isnan(doubles("log", x)).all()
    assert_lanes_agree("log", np.append(x, 1.0))
