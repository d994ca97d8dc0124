"""The counter-based random numbers: published answers, and the statistics of normal draws."""

import math

import numpy as np
import pytest
from multilift import _core
from scipy import stats

COUNT = 50000
# Every statistic below is a fixed number, since the draws are; a sound generator exceeds this
# level for one seed in a thousand, and the seeds were not selected.
LEVEL = 1e-3


def words(text):
    return [int(word, 16) for word in text.split()]


@pytest.mark.parametrize(
    ("counter", "key", "answer"),
    [  # philox4x32, 10 rounds, in kat_vectors of Random123
        (
            "00000000 00000000 00000000 00000000",
            "00000000 00000000",
            "6627e8d5 e169c58d bc57ac4c 9b00dbd8",
        ),
        (
            "ffffffff ffffffff ffffffff ffffffff",
            "ffffffff ffffffff",
            "408f276d 41c83b0e a20bc7c6 6d5451fd",
        ),
        (
            "243f6a88 85a308d3 13198a2e 03707344",
            "a4093822 299f31d0",
            "d16cfe09 94fdcceb 5001e420 24126ea1",
        ),
    ],
)
def test_block_is_the_published_one(counter, key, answer):
    assert list(_core.philox(words(counter), words(key))) == words(answer)


def draws(seed, stream, count=COUNT):
    return np.array([_core.normal_pair(seed, stream, index) for index in range(count)])


@pytest.mark.parametrize(
    ("seed", "stream", "index"),
    [(0, 0, 0), (1, 2, 3), (2**32 + 5, 7 * 2**32 + 11, 13 * 2**32 + 17), (2**64 - 1,) * 3],
)
def test_normal_pair_is_box_and_mullers_of_the_block_that_seed_stream_and_index_name(
    seed, stream, index
):
    def halves(number):
        return [number % 2**32, number // 2**32]

    block = _core.philox([*halves(index), *halves(stream)], halves(seed))
    radius = math.sqrt(-2 * math.log((block[0] + 0.5) / 2**32))
    angle = 2 * math.pi * (block[1] + 0.5) / 2**32
    expected = (radius * math.cos(angle), radius * math.sin(angle))
    # An angle up to 2 pi is rounded by 4 EPS, a radius up to 7 by its last place.
    assert _core.normal_pair(seed, stream, index) == pytest.approx(expected, rel=0, abs=1e-14)


def test_a_draw_depends_on_seed_stream_and_index_alone():
    def once():
        return [_core.normal_pair(3, stream, index) for stream in (8, 2) for index in (5, 1)]

    first = once()
    _core.normal_pair(99, 99, 99)
    assert once() == first
    assert len(set(map(tuple, first))) == 4


@pytest.mark.parametrize(("seed", "stream"), [(0, 0), (1, 0), (0, 1), (2**40, 2**50)])
def test_draws_are_standard_normal_and_the_two_of_a_pair_independent(seed, stream):
    pairs = draws(seed, stream)
    for numbers in pairs.T:
        assert stats.kstest(numbers, "norm").pvalue > LEVEL
        assert stats.ttest_1samp(numbers, 0).pvalue > LEVEL
        assert stats.chi2(COUNT).sf((numbers**2).sum()) > LEVEL / 2
        assert stats.chi2(COUNT).cdf((numbers**2).sum()) > LEVEL / 2
    assert stats.pearsonr(*pairs.T).pvalue > LEVEL
    assert stats.pearsonr(*(pairs**2).T).pvalue > LEVEL


@pytest.mark.parametrize("other", [(0, 1), (1, 0), (2**32, 0), (0, 2**32)])
def test_streams_and_seeds_are_independent(other):
    ours, theirs = draws(0, 0).ravel(), draws(*other).ravel()
    assert stats.pearsonr(ours, theirs).pvalue > LEVEL
    assert stats.pearsonr(ours**2, theirs**2).pvalue > LEVEL


def test_successive_draws_are_independent():
    numbers = draws(0, 0)[:, 0]
    for lag in (1, 2, 16, 256):
        assert stats.pearsonr(numbers[lag:], numbers[:-lag]).pvalue > LEVEL
