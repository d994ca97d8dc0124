"""Lab files: what is accepted means what it says; every mistake gives one clear error."""

import functools
import tomllib

import multilift as ml
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift.flight import lab
from multilift.flight.lab_tables import TABLES
from multilift.flight.link.address import Address


@pytest.fixture(scope="module")
def scenarios_read_once():
    """Reading the scenario is nearly all the time that reading a lab takes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lab.scenario, "load", functools.cache(lab.scenario.load))
        yield


TWIN = 'scenario = "exp1_1_quadrotors"\n'

REAL = """
schema = 1
title = "Two craft and a bar"
scenario = "exp1_1_quadrotors"

[[vehicle]]
system = 11
address = "udpin:127.0.0.1:14541"
hover_thrust = 0.48
battery_voltage = 14.8

[[vehicle]]
system = 12
address = "udpin:127.0.0.1:14542"
firmware = "ardupilot"
hover_thrust = 0.5
body = "right"

[motion_capture]
system = "qualisys"
host = "192.168.1.20"
payload = "bar"

[limits]
fence_low = [-3.0, -2.0, -0.1]
fence_high = [3.0, 2.0, 3.5]
tilt = "35 deg"
swing = "40 deg"
mocap_age = "120 ms"
"""


def parsed(tmp_path, text=REAL, **changes):
    """The lab of a text with dotted keys changed; None drops one."""
    raw = tomllib.loads(text)
    for key, value in changes.items():
        *tables, last = [int(p) if p.isdigit() else p for p in key.split("__")]
        node = raw
        for part in tables:
            node = node[part] if isinstance(part, int) else node.setdefault(part, {})
        if value is None:
            node.pop(last)
        else:
            node[last] = value
    return lab.parse(raw, "here.toml", tmp_path)


def test_without_hardware_it_is_a_twin(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(TWIN)
    twin = lab.load(file)
    assert twin.is_twin
    assert twin.name == "mine"
    assert [v.system for v in twin.vehicles] == [1, 2]
    flown = ml.load("exp1_1_quadrotors")
    most = 4 * flown.vehicle.thrust_coefficient * flown.vehicle.rotor_speed_max**2
    for vehicle, full in zip(twin.vehicles, most, strict=True):
        assert vehicle.hover_thrust * full == pytest.approx(vehicle.mass * 9.8, rel=1e-12)
    assert twin.limits.fence_low[0] < -1.5 < 1.2 < twin.limits.fence_high[0]


def test_what_the_file_says(tmp_path):
    real = parsed(tmp_path)
    assert not real.is_twin
    assert real.vehicles[0].address == Address(True, "127.0.0.1", 14541)
    assert [v.firmware for v in real.vehicles] == ["px4", "ardupilot"]
    assert [v.body for v in real.vehicles] == ["vehicle_1", "right"]
    assert real.vehicles[0].battery_voltage == 14.8
    assert real.limits.tilt == pytest.approx(0.6108652, abs=1e-7)
    assert real.limits.mocap_age == pytest.approx(0.12)
    assert real.key_file is None


def test_a_scenario_and_a_key_beside_the_lab_are_found(tmp_path):
    (tmp_path / "own.toml").write_text(ml.load("exp1_1_quadrotors").to_toml())
    real = parsed(tmp_path, scenario="own.toml", security__key_file="secret")
    assert real.scenario.where == str(tmp_path / "own.toml")
    assert real.key_file == tmp_path / "secret"


OUTSIDE = "udpout:192.168.1.30:14540"

MISTAKES = [
    ({"scenario": None}, "scenario", "exp1"),
    ({"scenario": "sim1"}, "scenario", "spatial"),
    ({"scenario": "exp9"}, "scenario", "sim1"),
    ({"scenario": "\0"}, "scenario", "exp1_1"),
    ({"vehicles": 3}, "vehicles", "vehicle"),
    ({"vehicle": []}, "motion_capture.system", "twin"),
    ({"vehicle": {}}, "vehicle", "[[vehicle]]"),
    ({"vehicle": [{"system": 1}]}, "vehicle", "2"),
    ({"vehicle__0__system": 12}, "vehicle[1].system", "own"),
    ({"vehicle__1__system": 255}, "vehicle[1].system", "250"),
    ({"vehicle__1__system": 0}, "vehicle[1].system", "1 to 250"),
    ({"security__system": 11}, "vehicle[0].system", "taken"),
    ({"vehicle__0__address": "serial:/dev/tty"}, "vehicle[0].address", "mavlink-router"),
    ({"vehicle__0__address": "udpin:127.0.0.1:99999"}, "vehicle[0].address", "udpin"),
    ({"vehicle__0__address": "udpin:127.0.0.1:14542"}, "vehicle[1].address", "taken"),
    ({"vehicle__0__address": None}, "vehicle[1].address", "every vehicle"),
    ({"vehicle__1__address": OUTSIDE}, "vehicle[1].address", "key_file"),
    ({"vehicle__0__firmware": "px5"}, "vehicle[0].firmware", "px4"),
    ({"vehicle__0__hover_thrust": None}, "vehicle[0].hover_thrust", "MPC_THR_HOVER"),
    ({"vehicle__0__hover_thrust": 0.95}, "vehicle[0].hover_thrust", "0.8"),
    ({"vehicle__0__thrust_curve": 1.5}, "vehicle[0].thrust_curve", "0 to 1"),
    ({"vehicle__0__body": "bar"}, "vehicle[0].body", "its own"),
    ({"motion_capture__system": "twin"}, "motion_capture.system", "simulated"),
    ({"motion_capture__host": None}, "motion_capture.host", "server"),
    ({"motion_capture__system": "motioncapture"}, "motion_capture.kind", "missing"),
    ({"motion_capture__kind": "vicon"}, "motion_capture.kind", "motioncapture"),
    ({"rates__setpoints": 20}, "rates.setpoints", "50 to 100"),
    ({"rates__pose": 100}, "rates.pose", "30 to 50"),
    ({"limits__fence_low": None}, "limits.fence_low", "room"),
    ({"limits__fence_high": [3.0, 2.0, 1.0]}, "limits.fence_high", "outside"),
    ({"limits__separation": 1.6}, "limits.separation", "1.5"),
    ({"limits__tilt": 2.0}, "limits.tilt", "1.4"),
    ({"limits__state_age": 1.0}, "limits.state_age", "0.3"),
    ({"limits__mocap_age": "10 ms"}, "limits.mocap_age", "0.1"),
    ({"limits__link_age": 0.1}, "limits.link_age", "1 to 10"),
    ({"limits__tlit": 0.1}, "limits.tlit", "tilt"),
    ({"schema": 2}, "schema", "1"),
    ({"limits": 3}, "limits", "table"),
]


@pytest.mark.parametrize(("changes", "key", "words"), MISTAKES)
def test_a_mistake_gives_one_error_that_names_file_and_key(tmp_path, changes, key, words):
    with pytest.raises(ml.ScenarioError) as caught:
        parsed(tmp_path, **changes)
    assert caught.value.key == key
    assert words in str(caught.value)
    if key:
        assert caught.value.where == "here.toml"


def test_beyond_this_machine_by_a_key_or_by_choice(tmp_path):
    for said in ({"security__key_file": "secret"}, {"security__allow_unsigned": True}):
        real = parsed(tmp_path, vehicle__1__address=OUTSIDE, **said)
        assert not real.vehicles[1].address.is_local


def test_unreadable_files_are_named(tmp_path):
    (tmp_path / "broken.toml").write_text("a = = 1")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    (tmp_path / "deep.toml").write_text("a = " + "[" * 100_000)
    for name in ("broken.toml", "binary.toml", "deep.toml", "missing.toml"):
        with pytest.raises(ml.ScenarioError, match=name):
            lab.load(tmp_path / name)


NUMBERS = st.floats() | st.integers() | st.sampled_from([0, 1, -1, 0.5, 10**400])
TEXTS = st.text(max_size=8) | st.sampled_from(["1 m", "px4", "udpin:1.1.1.1:1"])
VALUES = st.recursive(
    NUMBERS | st.booleans() | TEXTS,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=2)
    ),
    max_leaves=5,
)
NAMES = sorted({f.name for t in TABLES.values() for f in t.fields})
KEYS = st.sampled_from([*NAMES, *TABLES, "scenario", "schema", "title"]) | st.text(max_size=6)


@settings(max_examples=300, deadline=None)
@given(
    raw=st.dictionaries(KEYS, VALUES, max_size=4),
    tables=st.dictionaries(
        st.sampled_from(list(TABLES)),
        st.dictionaries(KEYS, VALUES, max_size=4)
        | st.lists(st.dictionaries(KEYS, VALUES, max_size=4), max_size=3),
        max_size=3,
    ),
    inside=st.sampled_from(["top", "vehicle"]),
)
def test_whatever_it_holds_it_is_a_lab_or_one_clear_error(
    tmp_path_factory, scenarios_read_once, raw, tables, inside
):
    whole = tomllib.loads(REAL)
    if inside == "vehicle":
        whole["vehicle"][0] |= raw
    else:
        whole |= raw
    for name, values in tables.items():
        both = isinstance(values, dict) and isinstance(whole.get(name), dict)
        whole[name] = whole[name] | values if both else values
    folder = tmp_path_factory.getbasetemp()
    try:
        made = lab.parse(whole, "here.toml", folder)
    except ml.ScenarioError as error:
        # Problem, permitted, what to do; a key may itself hold line breaks.
        assert str(error).replace(error.key, "key").count("\n") <= 2
    else:
        assert len(made.vehicles) == made.scenario.count


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_whatever_the_file_holds_it_is_one_clear_error(tmp_path_factory, content):
    file = tmp_path_factory.getbasetemp() / "fuzz.toml"
    file.write_bytes(content)
    with pytest.raises(ml.ScenarioError):
        lab.load(file)
