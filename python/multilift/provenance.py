"""What made a result: version, compiler, machine. Stored beside every run."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import version

import numpy as np

from multilift import _core, isa


def describe() -> dict[str, str]:
    """Versions, commit where known, compiler, instruction set of batches, platform; as texts."""
    build = _core.build_info()
    return {
        "multilift": version("multilift"),
        "commit": str(build["commit"]) or "unknown",
        "compiler": str(build["compiler"]),
        "isa": isa.chosen(),
        "platform": platform.platform(),
        "machine": platform.machine(),
        "python": sys.version.split()[0],
        "numpy": np.__version__,
    }
