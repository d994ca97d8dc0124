"""The core's own tests, built without Python and run under the address and UB sanitizers."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def run(*command):
    """A command's output, shown where it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.mark.skipif(shutil.which("cmake") is None, reason="needs cmake")
@pytest.mark.skipif(
    not any(map(shutil.which, [os.environ.get("CXX", "g++"), "clang++"])),
    reason="needs a C++ compiler",
)
def test_core_passes_its_own_tests_under_sanitizers(tmp_path):
    build = str(tmp_path)
    run("cmake", "-S", str(ROOT), "-B", build, "-DMULTILIFT_CORE_TESTS=ON")
    run("cmake", "--build", build, "--parallel", "2")
    report = run("ctest", "--test-dir", build, "--output-on-failure")
    assert "100% tests passed" in report
