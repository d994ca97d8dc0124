"""Judging random streams whose draws are fixed: p-values, and the level that all must stand above.

The draws do not change from run to run, so a test here passes always or never; seeds were written
down before anything was drawn from them. Together the p-values of one assertion fall below LEVEL
for a sound generator with one choice of seeds in a million, while a defect worth the name gives
p-values that are zero for all purposes at these sample sizes.
"""

import numpy as np
from scipy import stats

LEVEL = 1e-6


def assert_sound(p_values):
    """None of the p-values is too small, with Bonferroni's correction for their number."""
    p = np.ravel(p_values)
    assert np.isfinite(p).all()
    assert p.min() * len(p) > LEVEL, f"the smallest of {len(p)} p-values is {p.min():.2g}"


def of_proportion(successes, trials):
    """p-values of counts that a fair coin should give."""
    less = stats.binom.cdf(successes, trials, 0.5)
    more = stats.binom.sf(np.asarray(successes) - 1, trials, 0.5)
    return np.minimum(1.0, 2 * np.minimum(less, more))


def of_correlation(a, b):
    """p-value of Pearson's correlation of two columns, 0 where they are independent."""
    r = np.corrcoef(a, b)[0, 1]
    return 2 * stats.norm.sf(abs(r) * np.sqrt(len(a)))


def of_correlations(rows):
    """p-values of the correlation of every two of several rows."""
    r = np.corrcoef(rows)
    return 2 * stats.norm.sf(np.abs(r[np.tril_indices(len(r), -1)]) * np.sqrt(rows.shape[1]))


def of_mean(values, expected, variance):
    """p-value of a sample's mean; samples here are large enough for the central limit."""
    return 2 * stats.norm.sf(abs(np.mean(values) - expected) * np.sqrt(len(values) / variance))
