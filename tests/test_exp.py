"""The core's exponential function against mpmath's, for every result that a double can hold."""

import math

import numpy as np
import pytest
from core_functions import assert_lanes_agree, doubles, exact, largest_error, same

draw = np.random.default_rng(1).uniform
LOG_2 = math.log(2)
LEAST, GREATEST = -1074 * LOG_2, math.log(np.finfo(float).max)


def around(points):
    """Each point with the doubles beside it."""
    points = np.asarray(points, dtype=float)
    return np.concatenate([np.nextafter(points, -np.inf), points, np.nextafter(points, np.inf)])


arguments = {
    "of_lags": draw(-3.0, 0.0, 20000),  # what lags leave after some time
    "unreduced": draw(-LOG_2 / 2, LOG_2 / 2, 10000),
    "anywhere": draw(-708.0, GREATEST, 20000),
    "subnormal_results": draw(LEAST, -708.3, 5000),
    "tiny": 2.0 ** draw(-1074.0, 0.0, 2000) * np.where(draw(-1, 1, 2000) < 0, -1, 1),
    "beside_folds": around([(k + 0.5) * LOG_2 for k in range(-1070, 1023)]),
    "beside_multiples": around([k * LOG_2 for k in range(-1070, 1024)]),
}


@pytest.mark.parametrize("x", arguments.values(), ids=arguments.keys())
def test_error_is_below_one_last_place(x):
    # The sum of 1 and the rest rounds by half a last place of a result in [1, 2), or by as much
    # and what the rest was rounded by, a quarter, below 1. Largest found in millions: 0.89.
    assert largest_error(doubles("exp", x), map(exact.exp, map(exact.mpf, x.tolist()))) < 1.0


@pytest.mark.parametrize("x", arguments.values(), ids=arguments.keys())
def test_lanes_compute_a_doubles_bits(x):
    assert_lanes_agree("exp", x)


def test_what_no_double_can_hold_and_special_arguments():
    x = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 710.0, 1e308, -746.0, -1e308, 5e-324])
    assert same(doubles("exp", x), [1, 1, np.inf, 0, np.nan, np.inf, np.inf, 0, 0, 1])
    assert_lanes_agree("exp", x)
    ends = np.array([GREATEST, -745.13])
    assert same(doubles("exp", ends), [math.exp(GREATEST), 5e-324])
