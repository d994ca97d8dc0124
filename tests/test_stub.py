"""The type stub of the extension module says what the module has."""

from importlib import resources

import multilift._core
from nanobind.stubgen import StubGen


def test_stub_is_current():
    generator = StubGen(multilift._core, quiet=True)
    generator.put(multilift._core)
    committed = resources.files("multilift").joinpath("_core.pyi").read_text()
    assert committed == generator.get(), "run 'make format' to write it anew"
