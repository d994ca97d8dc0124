"""The page cannot disturb the flight, says how old it is, and obeys nobody who lacks the token."""

import itertools
import os
import signal
import socket
import time

import numpy as np
import pytest
from flight_snapshots import snapshot, vehicle
from multilift.errors import MissingExtraError, MultiliftError, ScenarioError
from multilift.flight import lab as labs
from multilift.flight.snapshot import Happening
from multilift.flight.supervisor import State, Word
from multilift.flight.web import words
from multilift.flight.web.address import WebAddress
from multilift.flight.web.gate import Gate, new_token
from multilift.flight.web.history import SPAN, History
from multilift.flight.web.page import Page, Press
from multilift.flight.web.stage import Stage, stage_of

#: How long something that must happen is waited for, s: only a failure takes so long.
PATIENCE = 60.0

ANY = WebAddress("127.0.0.1", 0)


@pytest.fixture(scope="module")
def lab():
    return labs.load(labs.DEFAULT)


@pytest.fixture(scope="module")
def page(lab):
    with Page(lab, ANY, "a test") as page:
        yield page
    assert page._process.returncode == 0
    with pytest.raises(OSError):
        socket.create_connection((page.address.host, page.address.port), 5.0)


def wait_for(what):
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_the_token_alone_opens_and_all_else_is_counted():
    token = new_token()
    gate = Gate(token)
    wrong = ["", "x", token[:-1], token + "a", token.replace("-", ""), "é", token[::-1] + "!"]
    assert not any(gate.opens(text) for text in wrong)
    assert gate.refused == len(wrong)
    assert gate.opens(f" {token.upper()} ")
    assert gate.refused == len(wrong)


def test_tokens_are_never_the_same():
    assert len({new_token() for _ in range(1000)}) == 1000


@pytest.mark.parametrize(
    "text",
    ["", "8080", ":8080", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "0.0.0.0:1",
     "256.1.1.1:80", "host:80", "[::1]:80", "127.0.0.1:80 ", "1.2.3.4:٣"],
)  # fmt: skip
def test_what_is_no_address_is_said_to_be_none(text):
    with pytest.raises(ScenarioError, match=r"--web-address.*\n.*permitted.*\n.*what to do"):
        WebAddress.parse(text, "multilift twin")


def test_an_address_is_what_it_says():
    for text, local in (("127.0.0.1:80", True), ("127.3.2.1:0", True), ("192.168.1.5:8080", False)):
        found = WebAddress.parse(text, "")
        assert str(found) == text
        assert found.is_local is local
        assert found.url in found.origins
    assert str(WebAddress.parse("localhost:81", "")) == "127.0.0.1:81"


def test_a_port_that_is_taken_is_one_clear_error(lab):
    with socket.create_server(("127.0.0.1", 0)) as other:
        taken = WebAddress("127.0.0.1", other.getsockname()[1])
        with pytest.raises(ScenarioError, match=f"{taken}.*cannot be had.*\n.*another"):
            Page(lab, taken, "multilift twin")


def test_an_address_of_another_machine_cannot_be_had(lab):
    with pytest.raises(ScenarioError, match="cannot be had"):
        Page(lab, WebAddress("192.0.2.1", 0), "multilift twin")


@pytest.mark.parametrize("command", ["fly", "twin"])
def test_without_its_packages_the_page_says_what_to_install(command, monkeypatch):
    from multilift import cli_fly
    from multilift.cli import app
    from typer.testing import CliRunner

    monkeypatch.setattr(cli_fly, "find_spec", lambda name: None)
    found = CliRunner().invoke(app, [command, "--yes", "--web"])
    assert isinstance(found.exception, MissingExtraError)
    assert "multilift[web]" in str(found.exception)


@pytest.mark.parametrize("command", ["fly", "twin"])
def test_a_bad_address_is_refused_before_anything_begins(command, tmp_path):
    from multilift.cli import app
    from typer.testing import CliRunner

    log = tmp_path / "one.mcap"
    words = [command, "--yes", "--log", str(log), "--web-address", "everywhere"]
    found = CliRunner().invoke(app, words)
    assert isinstance(found.exception, ScenarioError)
    assert f"multilift {command}" in str(found.exception)
    assert not log.exists()


def test_what_stops_always_counts_and_what_begins_only_while_nothing_has_changed():
    every = tuple(word.value for word in Word)
    for word, before, now in itertools.product(Word, State, State):
        for age in (0.1, 10.0):
            begins = word in (Word.START, Word.GO)
            press = Press(word, before.value, 100.0)
            counts = press.counts(snapshot(state=now.value, words=every), 100.0 + age)
            assert counts is (not begins or (before is now and age < 1.0))
            assert not press.counts(snapshot(state=now.value, words=()), 100.0 + age)


def test_history_keeps_its_span_and_trails_hang_together():
    kept = History()
    for k in range(1000):
        place = (0.1 * k, 0.0, 1.0)
        kept.add(snapshot(time=0.1 * k, vehicles=(vehicle(0, position=place), vehicle(1))))
    ago = kept.ago
    assert ago[-1] == 0.0
    assert (np.diff(ago) > 0.0).all()
    assert -SPAN <= ago[0] < -SPAN + 0.11
    trail = kept.trail(lambda s: s.vehicles[0].position)
    assert trail.shape == (len(ago) - 1, 2, 3)
    assert np.array_equal(trail[1:, 0], trail[:-1, 1])
    kept.add(snapshot(time=0.0))
    assert kept.ago.tolist() == [0.0]


def test_what_is_not_known_is_a_gap_and_no_zero():
    from multilift.flight.web.plots import curves

    kept = History()
    kept.add(snapshot(vehicles=(vehicle(0, swing=None), vehicle(1, swing=0.0))))
    first, second = curves(kept)["swing of the cables, °"].values
    assert np.isnan(first).all()
    assert (second == 0.0).all()


def test_an_axis_reaches_above_its_curves_and_a_limit_that_is_near():
    from multilift.flight.web.plots import Curves, top

    draw = np.random.default_rng(1)
    for size, part in zip(10.0 ** draw.uniform(-3, 4, 300), draw.uniform(0, 1, 300), strict=True):
        found = Curves([np.array([size, np.nan])], size / max(part, 0.3), 1e-3)
        assert found.limit < top(found) < 3.0 * found.limit
        far = Curves(found.values, 100.0 * size, 1e-3)
        assert size <= top(far) <= 2.0 * size


def test_a_stage_survives_its_way_to_the_page(lab):
    stage = stage_of(lab)
    assert Stage.from_dict(stage.to_dict()) == stage
    weight = lab.scenario.values["plant"]["payload_mass"] * lab.scenario.values["plant"]["gravity"]
    assert sum(stage.pulls) >= weight


def test_cables_hang_on_the_payload_however_it_is_turned(lab):
    from multilift.flight.web.space import feet

    points = stage_of(lab).attachments
    draw = np.random.default_rng(2)
    for q in draw.normal(size=(50, 4)):
        turned = feet((1.0, 2.0, 3.0), tuple(q / np.linalg.norm(q)), points)
        apart = np.linalg.norm(np.diff(turned, axis=0), axis=1)
        assert np.allclose(apart, np.linalg.norm(np.diff(points, axis=0), axis=1))
    assert np.allclose(feet((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), points), points + np.r_[1, 2, 3])


def test_a_box_has_its_edges_and_a_plate_is_closed():
    from multilift.flight.web.space import edges, plate

    box = edges([-1.0, -2.0, 0.0], [1.0, 2.0, 3.0])
    lengths = np.linalg.norm(box[:, 1] - box[:, 0], axis=1)
    assert sorted(lengths.round(9)) == [2.0] * 4 + [3.0] * 4 + [4.0] * 4
    angle = np.linspace(0.0, 2.0 * np.pi, 7)[:-1]
    outline = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    vertices, faces = plate(outline, 0.1)
    # Closed: each edge has two triangles, which run along it in opposite directions.
    ways = [(f[i], f[(i + 1) % 3]) for f in faces.tolist() for i in range(3)]
    assert sorted(ways) == sorted((b, a) for a, b in ways)
    corners = vertices[faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(0.2 * 1.5 * np.sqrt(3.0))


@pytest.mark.parametrize("state", list(State))
@pytest.mark.parametrize("age", [0.0, 0.9, 1.1, 100.0])
def test_old_data_are_called_old_and_trouble_trouble(state, age):
    text = words.head(snapshot(state=state.value), age)
    assert f"<b>{state.value}</b>" in text
    assert ("No data for" in text) is (age > 1.0)
    assert ('class="ml-state old"' in text) is (age > 1.0)
    bad = state in (State.HOLD, State.LAND_APART, State.KILL)
    assert ('class="ml-state bad"' in text) is (bad and age < 1.0)


def test_each_text_differs_from_the_last_so_that_the_browser_sees_that_it_came():
    shown = snapshot()
    assert words.rest(shown, 0.1) != words.rest(shown, 0.35)
    assert words.head(shown, 0.1) != words.head(shown, 0.35)


def test_nothing_from_outside_is_markup():
    evil = "<img src=x onerror=alert(1)>"
    shown = snapshot(
        scenario=evil, state=evil, problems=(evil,), checks=((evil, False),),
        vehicles=(vehicle(0, name=evil, mode=evil, order=evil, said=(evil,), firmware=evil),),
        happenings=(Happening(1.0, evil, True),),
    )  # fmt: skip
    text = words.head(shown, 0.0) + words.rest(shown, 0.0)
    assert "<img" not in text
    assert text.count("&lt;img") >= 8


def connected(page, origin):
    """A client of the page's socket, as a browser opens it for a page of some origin."""
    import viser
    from websockets.sync.client import connect

    return connect(
        f"ws://{page.address}", origin=origin, subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None, open_timeout=PATIENCE,
    )  # fmt: skip


def test_pages_of_others_in_the_same_browser_see_nothing(page):
    from websockets.exceptions import InvalidStatus

    for origin in ("http://elsewhere.test", f"http://elsewhere.test:{page.address.port}", None):
        with pytest.raises(InvalidStatus, match="403"):
            connected(page, origin)
    with connected(page, page.address.url) as ours:
        assert ours.recv(PATIENCE)


def test_nothing_else_listens(page):
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", page.address.port), 5.0):
        pass


def test_a_page_that_is_stuck_holds_nobody_up(page):
    os.kill(page._process.pid, signal.SIGSTOP)
    # Far more than any socket holds: what does not fit is dropped, not waited for.
    for k in range(3000):
        page.show(snapshot(time=float(k)))
    assert page.words() == []
    os.kill(page._process.pid, signal.SIGCONT)
    assert "token" in page.note


def test_a_page_that_is_dead_holds_nobody_up(lab):
    with Page(lab, ANY, "a test") as page:
        page._process.kill()
        wait_for(lambda: page.words() == [] and page.trouble)
        for k in range(3000):
            page.show(snapshot(time=float(k)))
        assert "gone" in page.note


def test_a_page_that_cannot_begin_says_why(lab, monkeypatch):
    from multilift.flight.web import server

    monkeypatch.setattr(server.Order, "to_json", lambda self: "{}")
    with pytest.raises(MultiliftError, match="did not begin"):
        Page(lab, ANY, "a test")
