"""The counter-based random bits: published answers, and the statistics of their words."""

import numpy as np
import pytest
from multilift import _core
from scipy import stats
from stream_statistics import assert_sound, of_correlation, of_proportion

COUNT = 2**15  # blocks of 4 words


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


def blocks(place, start=0, count=COUNT):
    """Blocks as one word of counter (0 to 3) or key (4, 5) counts up, shape (count, 4)."""
    taken = []
    for number in range(start, start + count):
        argument = [0] * 6
        argument[place] = number
        taken.append(_core.philox(argument[:4], argument[4:]))
    return np.array(taken, dtype=np.uint32)


@pytest.fixture(scope="module", params=[0, 2, 4], ids=["draws", "streams", "seeds"])
def counted(request):
    return blocks(request.param)


def bits(block):
    """Each bit of rows of words, shape (n, 32 words)."""
    return np.unpackbits(np.ascontiguousarray(block).view(np.uint8), axis=1)


def test_words_are_uniform(counted):
    found = []
    for word in counted.T:
        for shift in (0, 12, 24):  # chi-square over 256 bins of the least, middle and greatest bits
            found.append(stats.chisquare(np.bincount((word >> shift) & 255, minlength=256)).pvalue)
        found.append(stats.kstest((word + 0.5) / 2**32, "uniform").pvalue)
    assert_sound(found)


def test_every_bit_is_fair_and_pairs_of_bits_are_independent(counted):
    each = bits(counted)
    assert_sound(of_proportion(each.sum(axis=0), len(each)))
    same = [(each[:, k] == each[:, j]).sum() for k in range(128) for j in range(k)]
    assert_sound(of_proportion(np.array(same), len(each)))


def test_successive_blocks_are_independent(counted):
    uniform = (counted.astype(float) + 0.5) / 2**32
    found = [
        of_correlation(uniform[lag:, a], uniform[:-lag, b])
        for lag in (1, 2, 3, 16, 256, 4096)
        for a in range(4)
        for b in range(4)
    ]
    assert_sound(found)
    # The same for bits: as many change from one block to the next as do not.
    changed = bits(counted[1:] ^ counted[:-1])
    assert_sound(of_proportion(changed.sum(axis=0), len(changed)))


def test_every_input_bit_flips_half_of_the_output():
    # Avalanche: each bit of counter and key, at 256 arguments drawn once and for all.
    arguments = np.random.default_rng(1).integers(0, 2**32, (256, 6), dtype=np.uint64)
    flips = np.zeros((192, 256, 128), dtype=np.uint8)
    for n, argument in enumerate(arguments):
        row = argument.tolist()
        plain = np.array(_core.philox(row[:4], row[4:]), dtype=np.uint32)
        for bit in range(192):
            other = row.copy()
            other[bit // 32] ^= 1 << bit % 32
            turned = np.array(_core.philox(other[:4], other[4:]), dtype=np.uint32)
            flips[bit, n] = bits((plain ^ turned)[None])[0]
    assert_sound(of_proportion(flips.sum(axis=(1, 2), dtype=int), 256 * 128))  # by input bit
    assert_sound(of_proportion(flips.sum(axis=(0, 1), dtype=int), 192 * 256))  # by output bit
    assert_sound(of_proportion(flips.sum(axis=1, dtype=int).ravel(), 256))  # by both
    # And as many of the 128 as tosses of a coin would: their variance is 32.
    number = flips.sum(axis=2, dtype=int).ravel()
    spread = ((number - 64) ** 2 / 32).sum()
    assert_sound([2 * min(stats.chi2(len(number)).sf(spread), stats.chi2(len(number)).cdf(spread))])
