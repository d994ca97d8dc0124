"""Which compiled batch kernel runs: the widest the processor has, or the one that is asked for."""

from __future__ import annotations

import importlib
import os
from types import ModuleType

from multilift import _core
from multilift.errors import MultiliftError

#: Environment variable that forces an instruction set: avx512, avx2 or baseline.
VARIABLE = "MULTILIFT_ISA"


def available() -> list[str]:
    """Instruction sets whose kernel this processor can run, widest first."""
    return [str(name) for name in _core.instruction_sets()]


def chosen(name: str | None = None) -> str:
    """The instruction set that would be used.

    Args:
        name: None for what ``MULTILIFT_ISA`` says or, failing that, the widest.

    Raises:
        MultiliftError: if the processor lacks what is asked for.
    """
    sets = available()
    wanted = name or os.environ.get(VARIABLE) or sets[0]
    if wanted not in sets:
        source = "isa" if name else VARIABLE
        raise MultiliftError(
            f"{source} = {wanted!r}: this processor has no such instruction set\n"
            f"  permitted: {', '.join(sets)}"
        )
    return wanted


def kernel(name: str | None = None) -> ModuleType:
    """The batch kernel for an instruction set.

    Results are the same to the last bit whichever runs; they differ in speed.

    Args:
        name: as for ``chosen``.

    Raises:
        MultiliftError: if the processor lacks what is asked for.
    """
    return importlib.import_module(f"multilift._batch_{chosen(name)}")
