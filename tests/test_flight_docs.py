"""The flight pages show what flies."""

import importlib.util
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from multilift.flight.lab_tables import TABLES
from multilift.flight.supervisor.states import TRANSITIONS, State

DOCS = Path(__file__).resolve().parents[1] / "docs"


@pytest.fixture(scope="module")
def generated():
    """What the documentation's build writes, by file name."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(DOCS / "_ext"))
        spec = importlib.util.spec_from_file_location(
            "flight_reference", DOCS / "_ext" / "flight_reference.py"
        )
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module.pages()
    sys.modules.pop("scenario_reference", None)


def test_every_state_and_every_way_is_drawn(generated):
    drawn = ET.fromstring(generated["flight/supervisor.svg"])
    name = "{http://www.w3.org/2000/svg}"
    boxes = [t.text for t in drawn.iter(f"{name}text")]
    assert {s.value for s in State} <= set(boxes)
    titles = [t.text for t in drawn.iter(f"{name}title")]
    for t in TRANSITIONS:
        line = f"{t.start.value} → {t.end.value}: "
        assert any(x.startswith(line) and t.event.value in x for x in titles), t


def test_every_key_of_a_lab_file_is_listed(generated):
    text = generated["flight/lab-tables.md"]
    for table in TABLES.values():
        assert all(f"| `{field.name}` |" in text for field in table.fields)


def test_every_generated_file_is_on_a_page(generated):
    text = "".join(page.read_text(encoding="utf-8") for page in DOCS.glob("*.md"))
    assert all(f"generated/{name}" in text for name in generated)
