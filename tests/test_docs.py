"""The documentation holds: snippets run, messages are the real ones, tables are complete."""

import importlib.util
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import multilift as ml
import pytest
from multilift import models

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]


def blocks(page, language):
    """The fenced code blocks of a page in one language."""
    fence = rf"^```{re.escape(language)}\n(.*?)^```$"
    return re.findall(fence, page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def named(page):
    return page.name


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "python")], ids=named)
def test_python_blocks_run_in_order(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    namespace = {"__name__": page.stem}
    for block in blocks(page, "python"):
        exec(compile(block, page.name, "exec"), namespace)


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "toml")], ids=named)
def test_scenarios_run_and_their_mistakes_get_the_printed_answers(page, tmp_path, monkeypatch):
    # The first TOML block of a page is a whole scenario, saved under its name; each further one is
    # a part of it with a mistake, and the text block with it is the answer.
    monkeypatch.chdir(tmp_path)
    whole, *parts = blocks(page, "toml")
    file = Path(tomllib.loads(whole)["name"] + ".toml")
    file.write_text(whole, encoding="utf-8")
    scenario = ml.load(file)
    assert ml.simulate(scenario).finished
    for part, answer in zip(parts, blocks(page, "text"), strict=True):
        changes = {
            f"{table}.{key}": value
            for table, keys in tomllib.loads(part).items()
            for key, value in keys.items()
        }
        with pytest.raises(ml.ScenarioError) as error:
            scenario.with_values(changes)
        assert f"{error.value}\n" == answer


def test_compiled_law_of_the_how_to_is_a_control_law(tmp_path):
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("no C++ compiler")
    header, line = blocks(DOCS / "add-a-controller.md", "c++")
    (tmp_path / "law.hpp").write_text(header, encoding="utf-8")
    (tmp_path / "law.cpp").write_text(
        '#include "law.hpp"\n'
        '#include "multilift/multilift.hpp"\n'
        "using namespace multilift;\n"
        "template class planar::LeaningPd<double>;\n"
        "template class planar::LeaningPd<Lanes<2>>;\n"
        "static_assert(planar::ControlLaw<planar::LeaningPd<double>, double>);\n",
        encoding="utf-8",
    )
    include = ROOT / "core" / "include"
    flags = ["-std=c++20", "-Wall", "-Wextra", "-Werror", "-I", include]
    subprocess.run([compiler, *flags, "-c", "law.cpp"], cwd=tmp_path, check=True)
    # The line to change is still there to be changed.
    laws = (include / "multilift" / "control" / "planar" / "laws.hpp").read_text(encoding="utf-8")
    assert line.strip().replace(", LeaningPd<R>", "") in laws


@pytest.fixture(scope="module")
def generated():
    """What the documentation's build writes, by file name."""
    file = DOCS / "_ext" / "scenario_reference.py"
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.pages()


def rows(text):
    """The first cells of all tables."""
    return set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))


def test_scenario_reference_has_every_key(generated):
    reference = (DOCS / "scenario-reference.md").read_text(encoding="utf-8")
    values = ml.load("sim1").values
    assert {"schema", *(k for k, v in values.items() if isinstance(v, str))} <= rows(reference)

    model = models.by_name("planar")
    in_tables = rows(generated["planar/scenario-tables.md"])
    for name in (k for k, v in values.items() if isinstance(v, (dict, list))):
        assert f"[{name}]" in generated["planar/scenario-tables.md"] + reference
        if isinstance(values[name], dict) and name != "controller":
            assert set(values[name]) <= in_tables
    assert {f.name for f in model.tables["push"].fields} <= in_tables
    for law in model.laws:
        assert {f.name for f in model.controller_table(law).fields} <= rows(
            generated["planar/law-tables.md"]
        )


def test_reference_has_every_column_metric_and_audit_entry(generated):
    for name in models.names():
        described = models.by_name(name).described
        assert rows(generated[f"{name}/columns.md"]) == set(described.columns)
        assert rows(generated[f"{name}/metrics.md"]) == set(described.metrics)
        assert rows(generated[f"{name}/audit.md"]) == set(described.audit)


def test_every_generated_file_is_on_a_page(generated):
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert all(f"generated/{name}" in text for name in generated)
