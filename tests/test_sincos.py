"""The core's sine and cosine against mpmath's, throughout their range |x| < 1e5."""

import math
import random

import mpmath
import numpy as np
import pytest
from core_functions import assert_lanes_agree, doubles, same
from multilift import _core

LIMIT = 1e5
mp = mpmath.mp.clone()
mp.prec = 150  # 53 bits of a result, as many that cancel next to its zeros, and some to spare
quarter = mp.pi / 2


def around_multiples(offset):
    """Doubles on and beside (k + offset) pi/2, for k in all of the range."""
    for k in range(0, int(LIMIT / quarter), 20):
        x = float((k + offset) * quarter)
        yield from (math.nextafter(x, 0.0), x, math.nextafter(x, math.inf))


def drawn(count, draw):
    generator = random.Random(1)
    return [draw(generator) for _ in range(count)]


arguments = {
    "anywhere": drawn(10000, lambda r: r.uniform(0, LIMIT)),
    "unreduced": drawn(5000, lambda r: r.uniform(0, math.pi / 4)),
    "beside_zeros": list(around_multiples(0)),
    "beside_folds": list(around_multiples(0.5)),  # where the reduced argument changes sides
    "below_binades": [  # where a sine is next to 1/2 or 1/4 and its last place the smallest
        x for angle in (1 / 2, 1 / 4) for x in around_multiples(1.01 * angle / float(quarter))
    ],
    "tiny": drawn(2000, lambda r: 2.0 ** r.uniform(-1074, -1)),
    "ends": [0.0, math.nextafter(LIMIT, 0.0)],
}
everywhere = pytest.mark.parametrize("xs", arguments.values(), ids=arguments.keys())


@everywhere
def test_error_is_below_one_last_place_of_one_and_three_of_the_result(xs):
    # Reduction rounds the argument r twice, by one last place of r in all, which is two of a sine
    # in the binade below; the polynomial and the final sum stay within another. Largest found:
    # 0.73 last places of 1 and 2.4 of the result.
    for x in xs:
        cosine, sine = mp.cos_sin(mp.mpf(x))
        for found, exact in zip(_core.sincos(x), (sine, cosine), strict=True):
            error = abs(mp.mpf(found) - exact)
            assert error < math.ulp(1.0), x
            assert error <= 3 * math.ulp(float(exact)), x


@everywhere
def test_sine_is_odd_and_cosine_even_to_the_last_bit(xs):
    for x in xs:
        sine, cosine = _core.sincos(x)
        assert _core.sincos(-x) == (-sine, cosine)


@everywhere
def test_lanes_compute_a_doubles_bits(xs):
    for signed in (np.array(xs), -np.array(xs)):
        assert_lanes_agree("sin", signed)
        assert_lanes_agree("cos", signed)
        assert same(doubles("sin", signed), [_core.sincos(x)[0] for x in signed])


def test_no_number_gives_no_number():
    nothing = np.array([math.inf, -math.inf, math.nan])
    assert np.isnan(doubles("sin", nothing)).all()
    assert np.isnan(doubles("cos", nothing)).all()
    assert_lanes_agree("sin", nothing)
