"""Intervals, quantiles and bins against independent computations."""

import math

import numpy as np
import pytest
from multilift.study import binning
from multilift.study.statistics import paired_mean, paired_share, quantiles, wilson
from multilift.study.vary import Target, Vary
from scipy import stats


@pytest.mark.parametrize(("k", "n"), [(0, 1), (1, 1), (0, 50), (3, 50), (25, 50), (50, 50),
                                      (7, 1_000_000), (999_999, 1_000_000)])  # fmt: skip
def test_wilson_is_scipys(k, n):
    ours = wilson(k, n)
    theirs = stats.binomtest(k, n).proportion_ci(0.95, method="wilson")
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), rel=1e-9, abs=1e-15)
    assert ours.estimate == k / n


def test_wilson_of_nothing_is_nothing():
    assert math.isnan(wilson(0, 0).low)


def test_paired_mean_is_the_normal_interval_where_that_holds():
    rng = np.random.default_rng(1)
    for n in (500, 50_000):  # below and above the size from which blocks are resampled
        x = rng.exponential(size=n) - 0.5
        found = paired_mean(x)
        half = 1.96 * x.std(ddof=1) / math.sqrt(n)
        assert found.estimate == pytest.approx(x.mean(), rel=1e-12)
        # 2000 resamples know the ends to about 5 % of the half width.
        assert found.low == pytest.approx(x.mean() - half, abs=0.15 * half)
        assert found.high == pytest.approx(x.mean() + half, abs=0.15 * half)
        assert paired_mean(x) == found


def test_paired_share_is_the_normal_interval_where_that_holds():
    a, b, rest = 300, 200, 1500
    n = a + b + rest
    found = paired_share(a, b, rest)
    p, q = a / n, b / n
    half = 1.96 * math.sqrt((p + q - (p - q) ** 2) / n)
    assert found.estimate == pytest.approx(p - q)
    assert found.low == pytest.approx(p - q - half, abs=0.1 * half)
    assert found.high == pytest.approx(p - q + half, abs=0.1 * half)


def test_quantiles_count_no_value_as_greater_than_every_value():
    assert quantiles(np.array([3.0, 1.0, 2.0]), (0.0, 0.5, 1.0)) == [1.0, 2.0, 3.0]
    median, most = quantiles(np.array([1.0, math.nan, 2.0]), (0.5, 0.9))
    assert median == 2.0
    assert math.isnan(most)
    assert all(map(math.isnan, quantiles(np.array([]), (0.5,))))


def number(distribution, values=(), low=0.0, high=1.0):
    return Vary("x", "x", "", (Target("plant.bar_mass"),), "set", distribution, values, low, high)


def test_bins_of_a_list_are_its_values():
    x = np.array([3.0, 1.0, 3.0, 2.0])
    found = binning.bins(number("list", (1.0, 2.0, 3.0)), x, 10)
    assert found.centres.tolist() == [1.0, 2.0, 3.0]
    assert found.index.tolist() == [2, 0, 2, 1]
    assert found.edges.tolist() == [0.5, 1.5, 2.5, 3.5]


@pytest.mark.parametrize("distribution", ["uniform", "log_uniform"])
def test_bins_of_drawn_numbers_hold_them_all(distribution):
    x = np.random.default_rng(0).uniform(0.1, 5.0, 1000)
    found = binning.bins(number(distribution, low=0.1, high=5.0), x, 7)
    inside = (found.edges[found.index] <= x) & (x <= found.edges[found.index + 1])
    assert inside.all()
    assert len(found) == 7
    worlds, met = binning.shares(found.index, len(found), x > 1.0)
    assert worlds.sum() == 1000
    assert met.sum() == (x > 1.0).sum()


def test_quantiles_by_bin_are_each_bins_own():
    rng = np.random.default_rng(0)
    index, x = rng.integers(0, 4, 1000), rng.normal(size=1000)
    x[::50] = np.nan
    found = binning.grouped_quantiles(index, 5, x, (0.1, 0.5))
    for k in range(4):
        assert found[k].tolist() == quantiles(x[index == k], (0.1, 0.5))
    assert np.isnan(found[4]).all()
