"""The core's inverse tangents against mpmath's, and their signs as IEC 60559 has them."""

import itertools
import math

import numpy as np
import pytest
from core_functions import assert_lanes_agree, doubles, exact, largest_error, same

draw = np.random.default_rng(1).uniform
EPS = np.finfo(float).eps


def points(radius, angle):
    return radius * np.sin(angle), radius * np.cos(angle)


def beside(angles):
    """Points within some roundings of directions."""
    y, x = points(1.0, np.repeat(angles, 500))
    return y + EPS * draw(-9, 9, len(y)), x + EPS * draw(-9, 9, len(x))


quotients = {  # y, x
    "thrusts": (draw(-12.0, 12.0, 20000), draw(0.0, 30.0, 20000)),
    "all_round": points(2.0 ** draw(-30, 30, 20000), draw(-math.pi, math.pi, 20000)),
    "beside_axes": beside(np.arange(-2, 3) * math.pi / 2),
    "beside_diagonals": beside(np.arange(-3, 4, 2) * math.pi / 4),
    "unlike_sizes": (2.0 ** draw(-500, 500, 5000), -(2.0 ** draw(-500, 500, 5000))),
    # Where the result is just above a power of two or the quotient just below, so that a last
    # place of the one is small against the other's.
    "where_errors_are_greatest": (draw(0.50, 0.56, 20000), 1 + draw(0.0, 0.01, 20000)),
}
numbers = {
    "unreduced": draw(-1.0, 1.0, 20000),
    "steep": draw(1.0, 4.0, 20000),
    "anywhere": 2.0 ** draw(-1000, 1000, 5000),
    "beside_one": 1 + EPS * np.arange(-500, 500),
}


@pytest.mark.parametrize(("y", "x"), quotients.values(), ids=quotients.keys())
def test_error_of_a_quotients_angle_is_below_two_last_places(y, x):
    # The quotient is rounded by half its last place, which is a whole one of the result where that
    # lies in the binade below; the last two sums round by half a place each, the first of them
    # less where it counts. Largest found in millions: 1.67.
    found = doubles("atan2", y, x)
    truth = (exact.atan2(exact.mpf(b), exact.mpf(a)) for b, a in zip(y, x, strict=True))
    assert largest_error(found, truth) < 2.0
    # Adding a whole turn's parts is the same work on either side.
    assert same(doubles("atan2", -y, x), -found)


@pytest.mark.parametrize("x", numbers.values(), ids=numbers.keys())
def test_error_of_a_numbers_angle_is_below_two_last_places(x):
    # As above, without the quotient's rounding up to 1. Largest found in millions: 1.41.
    found = doubles("atan", x)
    assert largest_error(found, map(exact.atan, map(exact.mpf, x.tolist()))) < 2.0
    assert same(doubles("atan", -x), -found)


@pytest.mark.parametrize(("y", "x"), quotients.values(), ids=quotients.keys())
def test_lanes_compute_a_doubles_bits(y, x):
    assert_lanes_agree("atan2", y, x)
    assert_lanes_agree("atan", y)


def test_zeros_infinities_and_no_numbers_are_as_the_standard_says():
    special = [0.0, 1.0, 5e-324, 1e308, np.inf, np.nan]
    signed = [sign * size for size in special for sign in (1.0, -1.0)]
    y, x = np.array(list(itertools.product(signed, signed))).T
    regular = ~((np.abs(y) > 0) & (np.abs(y) < 1) & (np.abs(x) == 1e308))  # y/x is 0 or subnormal
    # NumPy asks the C library, which for these is exact.
    assert same(doubles("atan2", y, x)[regular], np.arctan2(y, x)[regular])
    assert same(doubles("atan", signed), np.arctan(signed))
    assert_lanes_agree("atan2", y, x)


@pytest.mark.parametrize("size", [1.0, 0.5, 1 / math.tan(0.5)])
def test_an_angle_does_not_fall_where_the_octants_meet(size):
    # Each reduction is monotonic but for roundings; across a border the next double may not step
    # back by more than those: one last place.
    x = size * (1 + EPS * np.arange(-2000, 2000))
    assert np.diff(doubles("atan", x)).min() >= -math.ulp(math.atan(size))
