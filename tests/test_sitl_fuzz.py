"""A sample of the decoders' fuzzing; `make fuzz` gives them millions."""

import fuzz_sitl
import pytest


@pytest.mark.parametrize("seed", range(4))
def test_rubbish_neither_breaks_nor_fools_the_decoders(seed):
    fuzz_sitl.fuzz(3000, seed)
