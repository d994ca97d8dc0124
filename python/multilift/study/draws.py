"""What world k draws: a function of the study and of k alone, whatever the chunk or machine.

World k lies in cell ``k mod cells`` of the crossed lists and grids and takes draw ``k // cells``,
so that every cell meets the same draws, and a greater count adds worlds behind the others.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import MissingExtraError
from multilift.study.spec import Study
from multilift.study.vary import Array, Vary

SEED = "simulation.seed"


def draw(study: Study, start: int, stop: int) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
    """The numbers that worlds `start` to `stop` draw, by the name of what varies.

    Args:
        study: what varies.
        start: first world.
        stop: the one after the last.

    Returns:
        One array of ``stop - start`` numbers for each entry of ``study.vary``, and the noise's
        seeds as ``simulation.seed`` where worlds differ in it.

    Raises:
        MissingExtraError: if a method or distribution needs SciPy and it is not installed.
    """
    start, stop = int(start), int(stop)
    worlds = np.arange(start, stop, dtype=np.int64)
    cells, samples = worlds % study.cells, worlds // study.cells
    first, last = start // study.cells, (stop - 1) // study.cells + 1
    result: dict[str, NDArray[np.float64] | NDArray[np.int64]] = {}
    places = np.unravel_index(cells, [len(v.values) for v in study.crossed] or [1])
    for varied, place in zip(study.crossed, places, strict=False):
        result[varied.name] = np.array(varied.values)[place]
    if study.sampled:
        unit = _unit_draws(study, first, last)
        for k, varied in enumerate(study.sampled):
            result[varied.name] = transform(varied, unit[:, k])[samples - first]
    if study.draws_noise:
        raw = _stream(study.seed, SEED, first, last)
        result[SEED] = (raw >> np.uint64(33)).astype(np.int64)[samples - first]
    return {v.name: result[v.name] for v in study.vary} | (
        {SEED: result[SEED]} if SEED in result else {}
    )


def _unit_draws(study: Study, first: int, last: int) -> Array:
    """Numbers inside (0, 1), one row a draw, one column for each sampled entry."""
    if study.method == "random":
        columns = [_stream(study.seed, v.name, first, last) for v in study.sampled]
        # 52 bits and a half, without rounding: neither 0 nor 1 can be drawn.
        return np.stack([((raw >> np.uint64(12)) + 0.5) * 2.0**-52 for raw in columns], axis=1)
    if study.method == "sobol":
        points = sobol(len(study.sampled), study.seed, first, last)
    else:
        points = _latin_hypercube(len(study.sampled), study.count, study.seed)[first:last]
    return np.asarray(np.clip(points, 2.0**-54, 1.0 - 2.0**-53), dtype=float)


def _stream(seed: int, name: str, first: int, last: int) -> NDArray[np.uint64]:
    """Numbers `first` to `last` of the counter-based stream that belongs to a name."""
    key = int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "little")
    block = first // 4  # the generator makes four numbers for each count
    generator = np.random.Philox(key=np.array([seed, key], dtype=np.uint64), counter=block)
    raw = generator.random_raw(last - 4 * block)
    return np.asarray(raw[first - 4 * block :], dtype=np.uint64)


def sobol(dimensions: int, seed: int, first: int, last: int) -> Array:
    """Scrambled Sobol points `first` to `last`, shape (last - first, dimensions).

    Raises:
        MissingExtraError: without SciPy.
    """
    qmc = _scipy("stats.qmc", "Sobol sequences")
    with warnings.catch_warnings():  # counts that are no power of two are the user's choice
        warnings.simplefilter("ignore", UserWarning)
        sequence = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
        if first:
            sequence.fast_forward(first)
        return np.asarray(sequence.random(last - first), dtype=float)


@lru_cache(maxsize=1)
def _latin_hypercube(dimensions: int, count: int, seed: int) -> Array:
    qmc = _scipy("stats.qmc", "Latin hypercubes")
    rng = np.random.default_rng(seed)
    return np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(count), dtype=float)


def transform(varied: Vary, u: Array) -> Array:
    """From (0, 1) to the entry's distribution, by the inverse of its distribution function."""
    if varied.distribution == "uniform":
        return np.asarray(varied.low + (varied.high - varied.low) * u, dtype=float)
    if varied.distribution == "log_uniform":
        low, span = math.log(varied.low), math.log(varied.high / varied.low)
        # One by one: NumPy's exp may round differently by processor.
        x = np.array([math.exp(low + span * float(p)) for p in u])
        return np.asarray(np.clip(x, varied.low, varied.high), dtype=float)
    special = _scipy("special", "normal distributions")
    below = special.ndtr((varied.low - varied.mean) / varied.std)
    above = special.ndtr((varied.high - varied.mean) / varied.std)
    x = varied.mean + varied.std * special.ndtri(below + (above - below) * u)
    return np.asarray(np.clip(x, varied.low, varied.high), dtype=float)


def _scipy(module: str, purpose: str) -> Any:
    try:
        return import_module(f"scipy.{module}")
    except ImportError:
        raise MissingExtraError("scipy", "study", purpose) from None
