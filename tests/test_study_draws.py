"""What worlds draw: the distribution that is meant, the same whatever the chunks."""

import itertools
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from multilift import study
from multilift.study import spec
from multilift.study.draws import SEED, draw
from scipy import stats
from study_files import SMALL

N = 20_000


def plan(tmp_path, method="random", **vary):
    raw = tomllib.loads(SMALL) | {"method": method, "count": N}
    entry = {"key": "plant.bar_mass", "distribution": "uniform", "low": 0.6, "high": 1.0} | vary
    raw["vary"] = [{k: v for k, v in entry.items() if v is not None}]
    return spec.parse(raw, "here.toml", tmp_path)


DISTRIBUTIONS = [
    ({"low": 0.6, "high": 1.0}, stats.uniform(0.6, 0.4)),
    ({"distribution": "log_uniform", "low": 0.1, "high": 1.0}, stats.loguniform(0.1, 1.0)),
    (
        {"distribution": "normal", "mean": 0.8, "std": 0.05, "low": None, "high": None},
        stats.norm(0.8, 0.05),
    ),
    (
        {"distribution": "normal", "mean": 0.8, "std": 0.2, "low": 0.5, "high": 1.5},
        stats.truncnorm(-1.5, 3.5, 0.8, 0.2),
    ),
    (
        {"distribution": "normal", "mean": 0.8, "std": 0.2, "low": 0.5, "high": None},
        stats.truncnorm(-1.5, math.inf, 0.8, 0.2),
    ),
]


@pytest.mark.parametrize("method", spec.METHODS)
@pytest.mark.parametrize(("entry", "law"), DISTRIBUTIONS)
def test_draws_follow_the_distribution(tmp_path, method, entry, law):
    x = draw(plan(tmp_path, method, **entry), 0, N)["plant.bar_mass"]
    distance = stats.kstest(x, law.cdf).statistic
    # The seed is fixed: the bound is Kolmogorov's 0.1 % point; even sequences lie far below.
    assert distance < (1.95 if method == "random" else 0.1) / math.sqrt(N)


def test_numbers_are_independent_of_each_other_and_of_their_neighbours():
    base = study.load("robustness_sim1")
    drawn = draw(replace(base, method="random", count=N), 0, N)
    columns = np.array([drawn[v.name] for v in base.vary])
    ranks = stats.rankdata(columns, axis=1)
    correlation = np.corrcoef(ranks) - np.eye(len(ranks))
    assert np.abs(correlation).max() < 4 / math.sqrt(N)
    for row in ranks:
        assert abs(np.corrcoef(row[1:], row[:-1])[0, 1]) < 4 / math.sqrt(N)


@pytest.mark.parametrize("method", spec.METHODS)
def test_a_world_draws_the_same_whatever_the_chunks(method):
    base = replace(study.load("robustness_exp1_1"), method=method, count=1000)
    whole = draw(base, 0, 1000)
    assert SEED in whole
    rng = np.random.default_rng(0)
    for _ in range(5):
        cuts = [0, *sorted(rng.choice(np.arange(1, 1000), 6, replace=False)), 1000]
        pieces = [draw(base, a, b) for a, b in itertools.pairwise(cuts)]
        for name, values in whole.items():
            assert np.array_equal(np.concatenate([p[name] for p in pieces]), values)


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_more_worlds_leave_the_first_ones_as_they_were(method):
    base = replace(study.load("robustness_sim1"), method=method)
    fewer, more = draw(replace(base, count=64), 0, 64), draw(replace(base, count=256), 0, 64)
    assert all(np.array_equal(fewer[k], more[k]) for k in fewer)


def test_a_new_number_leaves_the_others_as_they_were(tmp_path):
    one = plan(tmp_path)
    two = replace(one, vary=(*study.load("robustness_sim1").vary[1:2], *one.vary))
    a, b = draw(one, 0, 100), draw(two, 0, 100)
    assert np.array_equal(a["plant.bar_mass"], b["plant.bar_mass"])


def test_another_seed_draws_other_numbers(tmp_path):
    base = plan(tmp_path)
    for method in spec.METHODS:
        a = draw(replace(base, method=method), 0, 100)["plant.bar_mass"]
        b = draw(replace(base, method=method, seed=6), 0, 100)["plant.bar_mass"]
        assert not np.isin(a, b).any()


def test_lists_and_grids_are_crossed_and_every_cell_meets_the_same_draws(tmp_path):
    raw = tomllib.loads(SMALL) | {"count": 4}
    raw["vary"] += [{"key": "plant.cable_length", "distribution": "grid", "low": 1.7,
                     "high": 1.9, "points": 3}]  # fmt: skip
    base = spec.parse(raw, "here.toml", tmp_path)
    assert (base.cells, base.worlds) == (6, 24)
    drawn = draw(base, 0, 24)
    cells = set(zip(drawn["controller.k_lambda"], drawn["plant.cable_length"], strict=True))
    assert len(cells) == 6
    for cell in cells:
        there = (drawn["controller.k_lambda"] == cell[0]) & (drawn["plant.cable_length"] == cell[1])
        assert np.array_equal(drawn["plant.bar_mass"][there], drawn["plant.bar_mass"][::6])


def test_log_spaced_grids(tmp_path):
    base = plan(tmp_path, distribution="grid", low=0.1, high=1.0, points=3, spacing="log")
    assert base.vary[0].values == pytest.approx((0.1, math.sqrt(0.1), 1.0))


def test_the_seed_of_the_noise_is_drawn_only_where_there_is_noise(tmp_path):
    assert SEED not in draw(plan(tmp_path), 0, 10)
    seeds = draw(study.load("robustness_exp1_1"), 0, 1000)[SEED]
    assert len(set(seeds.tolist())) == 1000
    assert seeds.min() >= 0
