"""Lab files that nobody should write: keys, values and whole texts gone wrong.

``python tests/fuzz_lab.py 2000000 1`` reads so many, from a seed. Each is a lab that can be flown,
or one clear error that names the file; nothing else, and in no time worth telling.
"""

import contextlib
import functools
import math
import random
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import tomli_w
from multilift.errors import ScenarioError
from multilift.flight import lab
from multilift.flight.lab_tables import TABLES

WHERE = "fuzzed.toml"
#: A scenario takes 10 ms to read; more than a hundred of these is stuck, s.
STUCK = 10.0

REAL = {
    "title": "Two craft and a bar",
    "scenario": "exp1_1_quadrotors",
    "vehicle": [
        {"system": 11, "address": "udpin:127.0.0.1:14541", "hover_thrust": 0.48,
         "battery_voltage": 15.2, "body": "left"},
        {"system": 12, "address": "udpout:127.0.0.1:14542", "firmware": "ardupilot",
         "hover_thrust": 0.46, "thrust_curve": 0.3, "body": "right"},
    ],
    "motion_capture": {"system": "qualisys", "host": "192.168.1.20", "payload": "bar"},
    "rates": {"setpoints": 80.0, "pose": 40, "pose_message": "odometry"},
    "limits": {"fence_low": [-3.0, -2.0, -0.1], "fence_high": [3.0, 2.0, 3.5], "tilt": "35 deg"},
    "security": {"key_file": "signing.key", "system": 254},
}  # fmt: skip
TWIN = {"scenario": "exp1_1_quadrotors"}

NUMBERS = (0, -1, 1, 251, 256, 2**31, 2**63, -(2**63), 10**30, 0.0, -0.0, 0.5, 1e308, -1e308,
           5e-324, math.inf, -math.inf, math.nan)  # fmt: skip
TEXTS = ("", " ", "x", "\0", "../..", "/", "é\U0001f681", "a" * 5000, "udpin:0.0.0.0:0",
         "udpin:::1:1", "udpin:127.0.0.1:99999", "udpout:256.1.1.1:1", "udpin:127.0.0.1:14541",
         "35 deg", "1e999 m", "3 parsec", "px4", "twin", "qualisys", "vicon", "vehicle_1",
         "payload", "nan", "true", "٣")  # fmt: skip
OTHERS = {"schema", "name", "title", "scenario", "", "ﬁeld", "plant", "__class__"}
KEYS = tuple(sorted({f.name for t in TABLES.values() for f in t.fields} | set(TABLES) | OTHERS))
MARKS = (b"[", b"]", b'"', b"=", b"[[", b"\n", b"#", b"{", b"1e", b"-")


def value(draw, depth=0):
    """Anything that TOML can hold."""
    simple = (
        lambda: draw.choice(NUMBERS),
        lambda: draw.choice(TEXTS),
        lambda: draw.random() < 0.5,
        lambda: draw.uniform(-10.0, 10.0),
        lambda: draw.randrange(-5, 300),
    )
    nested = (
        lambda: [value(draw, depth + 1) for _ in range(draw.randrange(5))],
        lambda: [draw.uniform(-5.0, 5.0) for _ in range(3)],
        lambda: {draw.choice(KEYS): value(draw, depth + 1) for _ in range(draw.randrange(4))},
    )
    return draw.choice((*simple, *nested) if depth < 3 else simple)()


def copied(node):
    if isinstance(node, dict):
        return {k: copied(v) for k, v in node.items()}
    return [copied(v) for v in node] if isinstance(node, list) else node


def changed(draw):
    """A good lab with some places changed, added or taken away."""
    tables = copied(draw.choice((REAL, REAL, TWIN)))
    for _ in range(draw.choice((0, 1, 1, 1, 2, 3, 6))):
        node = tables
        while True:
            inner = [v for v in (node.values() if isinstance(node, dict) else node)
                     if isinstance(v, (dict, list)) and v]  # fmt: skip
            if not inner or draw.random() < 0.4:
                break
            node = draw.choice(inner)
        places = list(node) if isinstance(node, dict) else list(range(len(node)))
        how = draw.randrange(4)
        if isinstance(node, list):
            if how == 0:
                node.append(value(draw))
            elif how == 1 and places:
                del node[draw.choice(places)]
            elif places:
                node[draw.choice(places)] = value(draw)
        elif how == 0 or not places:
            node[draw.choice(KEYS)] = value(draw)
        elif how == 1:
            del node[draw.choice(places)]
        else:
            node[draw.choice(places)] = value(draw)
    # Reading a scenario is what takes time: seldom another one than that which all have.
    if isinstance(tables.get("scenario"), str) and draw.random() < 0.9:
        tables["scenario"] = "exp1_1_quadrotors"
    return tables


def spoilt(draw):
    """The bytes of a lab file, some changed."""
    text = bytearray(tomli_w.dumps(draw.choice((REAL, TWIN))).encode())
    for _ in range(draw.randrange(1, 6)):
        at = draw.randrange(len(text) + 1)
        how = draw.randrange(4)
        if how == 0:
            text[at : at + draw.randrange(20)] = b""
        elif how == 1:
            text[at:at] = draw.choice(MARKS)
        elif how == 2:
            text[at : at + 1] = draw.randbytes(1)
        else:
            text[at:at] = text[draw.randrange(len(text) + 1) :][: draw.randrange(60)]
    return bytes(text)


def check_clear(error, where):
    """One error that a person can act upon: file, what is wrong, and what is permitted or to do."""
    text = str(error)
    assert text.startswith(f"{where}: "), text[:200]
    assert 0 < len(text.splitlines()) <= 6, text[:500]
    assert len(text) < 20_000, len(text)
    assert error.__cause__ is None


def parsed(tables, folder):
    """Whether tables are a lab that can be flown."""
    try:
        made = lab.parse(tables, WHERE, folder)
    except ScenarioError as error:
        check_clear(error, WHERE)
        return False
    assert len(made.vehicles) == made.scenario.count
    assert len({v.system for v in made.vehicles}) == len(made.vehicles)
    assert all(0.05 <= v.hover_thrust <= 0.8 for v in made.vehicles)
    fence = (*made.limits.fence_low, *made.limits.fence_high)
    numbers = [x for x in vars(made.limits).values() if isinstance(x, float)]
    assert all(map(math.isfinite, (*numbers, *fence)))
    if not made.is_twin and made.key_file is None and not made.security["allow_unsigned"]:
        assert all(v.address.is_local for v in made.vehicles)
    return True


def loaded(content, folder):
    """Whether the bytes of a file are such a lab."""
    file = folder / WHERE
    file.write_bytes(content)
    try:
        lab.load(file)
    except ScenarioError as error:
        check_clear(error, str(file))
        return False
    return True


def fuzz(count, seed):
    """Reads ``count`` labs: of every ten, nine as tables and one as the bytes of a file."""
    draw = random.Random(seed)
    good = 0
    with tempfile.TemporaryDirectory() as name, scenarios_once():
        folder = Path(name)
        for k in range(count):
            tables = content = None
            begun = time.process_time()
            try:
                if k % 10 == 9:
                    content = spoilt(draw)
                    good += loaded(content, folder)
                else:
                    tables = changed(draw)
                    good += parsed(tables, folder)
            except Exception as error:
                raise AssertionError(f"input {k} of seed {seed}: {content or tables}") from error
            assert time.process_time() - begun < STUCK, (k, seed)
    return good


@contextlib.contextmanager
def scenarios_once():
    """Reads every scenario once: they are what takes time, and are not what is tried here."""
    module = lab.scenario
    lab.scenario = SimpleNamespace(load=functools.cache(module.load))
    try:
        yield
    finally:
        lab.scenario = module


if __name__ == "__main__":
    asked, from_seed = map(int, sys.argv[1:])
    print(f"{asked} lab files, {fuzz(asked, from_seed)} of them good")
