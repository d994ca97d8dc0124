"""The flight pages show what flies."""

import importlib.util
import re
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from multilift.flight import lab
from multilift.flight.lab_tables import TABLES
from multilift.flight.link.firmware import BY_NAME
from multilift.flight.replay.ulog import MEANINGS
from multilift.flight.sitl import parameters
from multilift.flight.supervisor.states import TRANSITIONS, State
from multilift.models import by_name

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
GUIDE = DOCS / "first-flight.md"

#: Read off an autopilot, not set by us.
TOLD = {"MPC_THR_HOVER", "MOT_THST_HOVER"}


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


def column(text, head):
    """The first cells of the table with this head."""
    table = text[text.index(head) :].split("\n\n")[0]
    return [line.split("|")[1].strip() for line in table.splitlines()[2:]]


def test_the_guide_explains_every_state():
    assert column(GUIDE.read_text(encoding="utf-8"), "| state |") == [s.value for s in State]


def test_the_guide_s_parameters_are_those_that_we_set():
    known = TOLD | {name for firmware in BY_NAME for name in parameters.shipped(firmware)}
    known |= {f.system_parameter for f in BY_NAME.values()}
    for firmware in BY_NAME.values():
        known |= {s.name for s in firmware.settings}
    told = set(re.findall(r"`([A-Z][A-Z0-9]*_[A-Z0-9_]+)`", GUIDE.read_text(encoding="utf-8")))
    assert told - {"VISO_DELAY_MS"} <= known
    for name, firmware in BY_NAME.items():
        shipped = parameters.shipped(name)
        # Set for the twin's battery and for sticks alone, not on the page's list of failsafes.
        missing = {s.name for s in firmware.settings} - told
        assert missing <= {"FS_EKF_ACTION"}, missing
        wrong = [s.name for s in firmware.settings if shipped.get(s.name, s.value) != s.value]
        assert not wrong


def test_the_guide_s_lab_file_is_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = GUIDE.read_text(encoding="utf-8")
    [python] = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    exec(python, {})  # writes the scenario
    [block] = re.findall(r"^```\{code-block\} toml\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    made = lab.parse(tomllib.loads(block), "LAB.toml", tmp_path)
    assert not made.is_twin
    assert made.scenario.name == "our_bar"


def test_what_the_guide_quotes_is_said():
    sources = "".join(
        p.read_text(encoding="utf-8") for p in (ROOT / "python/multilift/flight").rglob("*.py")
    )
    for cell in column(GUIDE.read_text(encoding="utf-8"), "| it says |"):
        for words in re.findall(r"`([^`]+)`", cell):
            for part in words.removeprefix("motion capture: ").split("`"):
                assert part in sources, part


def test_what_the_guide_and_the_replay_page_name_is_there():
    described = by_name("spatial").described
    known = set(described.metrics) | set(described.audit) | set(MEANINGS)
    page = (DOCS / "flight-replay.md").read_text(encoding="utf-8")
    for name in ("peak_swing", "payload_error_rms", "largest_integration_error", "storage_start",
                 "attitude_rms", "set_point_delay"):  # fmt: skip
        assert name in known and f"`{name}`" in GUIDE.read_text(encoding="utf-8")
    assert all(f"`{name}`" in page for name in MEANINGS if name not in _IN_WORDS)


#: Said in words there.
_IN_WORDS = {"offset", "correlation", "set_points_arrived"}


def test_the_guide_s_drawing_is_its_script_s():
    spec = importlib.util.spec_from_file_location("first_flight", DOCS / "first_flight.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (DOCS / "_static" / "first-flight.svg").read_text(encoding="utf-8") == module.svg()
    ET.fromstring(module.svg())


def test_every_generated_file_is_on_a_page(generated):
    text = "".join(page.read_text(encoding="utf-8") for page in DOCS.glob("*.md"))
    assert all(f"generated/{name}" in text for name in generated)
