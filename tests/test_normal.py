"""The normal draws: what they are made of, that they are normal, and independent of each other."""

import math

import numpy as np
import pytest
from multilift import _core
from multilift.isa import available, kernel
from scipy import stats
from stream_statistics import assert_sound, of_correlation, of_correlations, of_mean

COUNT = 2**18  # pairs
STREAMS = [(0, 0), (1, 0), (0, 1), (2**40, 2**50), (2**64 - 1, 2**64 - 1)]


def normals(seeds, stream, draws, module=_core):
    """Draws of one stream under each seed, shape (seeds, draws, 2)."""
    out = np.empty((len(seeds), len(draws), 2))
    module.normals(np.array(seeds, dtype=np.uint64), stream, np.array(draws, dtype=np.uint64), out)
    return out


@pytest.mark.parametrize(
    ("seed", "stream", "index"),
    [(0, 0, 0), (1, 2, 3), (2**32 + 5, 7 * 2**32 + 11, 13 * 2**32 + 17), (2**64 - 1,) * 3],
)
def test_a_pair_is_box_and_mullers_of_the_block_that_seed_stream_and_index_name(
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
    np.testing.assert_array_equal(
        normals([seed], stream, [index])[0, 0], _core.normal_pair(seed, stream, index)
    )


def test_a_draw_depends_on_seed_stream_and_index_alone():
    def once():
        return [_core.normal_pair(3, stream, index) for stream in (8, 2) for index in (5, 1)]

    first = once()
    _core.normal_pair(99, 99, 99)
    assert once() == first
    assert len(set(map(tuple, first))) == 4


@pytest.mark.parametrize("isa", available())
def test_lanes_draw_a_doubles_bits_whatever_their_company(isa):
    seeds = [0, 1, 2, 2**32 - 1, 2**32, 2**63 + 12345, 2**64 - 1] * 3
    draws = [*range(300), 2**32 - 1, 2**32, 2**64 - 1]
    for stream in (0, 7, 2**33 + 1):
        expected = normals(seeds, stream, draws)
        np.testing.assert_array_equal(normals(seeds, stream, draws, kernel(isa)), expected)
        np.testing.assert_array_equal(
            normals(seeds[4:9], stream, draws, kernel(isa)), expected[4:9]
        )


@pytest.fixture(scope="module", params=STREAMS, ids=str)
def pairs(request):
    seed, stream = request.param
    return normals([seed], stream, range(COUNT))[0]


def test_draws_are_normal(pairs):
    found = []
    for x in pairs.T:
        found.append(stats.kstest(x, "norm").pvalue)
        found.append(stats.cramervonmises(x, "norm").pvalue)
        edges = stats.norm.ppf(np.arange(1, 256) / 256)
        found.append(stats.chisquare(np.bincount(np.searchsorted(edges, x), minlength=256)).pvalue)
        for limit in (3.0, 4.0):  # tails, where 708 and 17 are expected
            beyond = int((np.abs(x) > limit).sum()), 2 * stats.norm.sf(limit)
            found.append(stats.binomtest(beyond[0], len(x), beyond[1]).pvalue)
    assert_sound(found)


def test_the_first_four_moments_are_those_of_the_standard_normal(pairs):
    # E x^2 = 1, E x^4 = 3, E x^6 = 15, E x^8 = 105: so the variances 1, 2, 15 and 96.
    found = [
        of_mean(x**power, expected, variance)
        for x in pairs.T
        for power, expected, variance in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96))
    ]
    assert_sound(found)


def test_the_two_of_a_pair_are_independent(pairs):
    x, y = pairs.T
    found = [of_correlation(x, y), of_correlation(x**2, y**2), of_correlation(np.abs(x), y)]
    edges = stats.norm.ppf(np.arange(1, 16) / 16)
    cells = 16 * np.searchsorted(edges, x) + np.searchsorted(edges, y)
    found.append(stats.chisquare(np.bincount(cells, minlength=256)).pvalue)
    assert_sound(found)


def test_successive_draws_are_independent(pairs):
    found = []
    for lag in (1, 2, 3, 5, 16, 256, 4096):
        for a in range(2):
            for b in range(2):
                ahead, behind = pairs[lag:, a], pairs[:-lag, b]
                found += [of_correlation(ahead, behind), of_correlation(ahead**2, behind**2)]
    assert_sound(found)


def test_the_streams_of_a_world_are_independent():
    # Eight streams carry the 14 measured values of a world; both numbers of each pair.
    together = np.array([normals([1], stream, range(COUNT // 4))[0].T for stream in range(8)])
    rows = together.reshape(16, -1)
    assert_sound([of_correlations(rows), of_correlations(rows**2)])


@pytest.mark.parametrize("spacing", [1, 2**32], ids=["adjacent", "in_the_upper_half"])
def test_worlds_of_neighbouring_seeds_are_independent(spacing):
    worlds = normals([k * spacing for k in range(64)], 0, range(4096))
    rows = worlds[:, :, 0]
    assert_sound([of_correlations(rows), of_correlations(worlds[:, :, 1])])
    assert_sound([of_correlation(rows[:-1].ravel(), rows[1:].ravel())])
    # Nor is one world's stream another's, later.
    for lag in (1, 2, 64):
        late = [of_correlation(rows[k, lag:], rows[k + 1, :-lag]) for k in range(63)]
        early = [of_correlation(rows[k, :-lag], rows[k + 1, lag:]) for k in range(63)]
        assert_sound([late, early])
    # Over worlds, at each instant, draws are normal as well.
    assert_sound([stats.kstest(column, "norm").pvalue for column in rows.T])
