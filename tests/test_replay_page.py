"""The replay page: complete, self-contained, and alive in a browser."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
import replay_scenes as scenes
from multilift import replay
from multilift.replay import cables, page


class Document(HTMLParser):
    """Elements with attributes, and the page's data."""

    def __init__(self, html):
        super().__init__()
        self.elements, self.texts, self._data, self._reading = [], "", "", False
        self.feed(html)
        self.data = json.loads(self._data)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self._reading = dict(attrs).get("id") == "replay-data"

    def handle_data(self, data):
        if self._reading:
            self._data += data
        else:
            self.texts += data

    def handle_endtag(self, tag):
        self._reading = False


def decode(packed):
    if "c" in packed:
        return np.full(packed["n"], packed["c"])
    if "v" in packed:
        return np.array([np.nan if x is None else x for x in packed["v"]])
    return np.cumsum(packed["d"]) / 10.0 ** packed["p"]


@pytest.fixture(scope="module")
def scene():
    return replay.scene_of(scenes.cut())


@pytest.fixture(scope="module")
def html(scene):
    return page.render(scene)


def test_loads_nothing_from_anywhere(html):
    for tag, attrs in Document(html).elements:
        for name in ("src", "href", "srcset", "poster", "action"):
            address = attrs.get(name)
            assert address is None or address.startswith("data:"), (tag, address)
    assert not re.search(r"https?:|@import|url\(|fetch\(|XMLHttpRequest|import\(", html)
    (policy,) = [a["content"] for _, a in Document(html).elements if a.get("http-equiv")]
    assert "default-src 'none'" in policy


def test_carries_all_of_the_run(scene, html):
    shown = Document(html).data
    columns = shown["columns"]

    def same(packed, exact):
        exact = np.asarray(exact)
        found = decode(packed)
        np.testing.assert_allclose(
            found, exact, rtol=0, atol=1e-5 * max(np.nanmax(np.abs(exact)), 1e-300)
        )

    same(columns["t"], scene.t)
    for k, axis in enumerate(columns["payload"]):
        same(axis, scene.payload_position[:, k])
    for k, vehicle in enumerate(scene.vehicles):
        for name in ("position", "attitude", "target", "thrust"):
            for axis, packed in enumerate(columns["vehicles"][k][name]):
                same(packed, getattr(vehicle, name)[:, axis])
        same(columns["cables"][k]["tension"], scene.cables[k].tension)
    same(columns["cables"][0]["swing"], scene.cables[0].swing)
    assert [e["text"] for e in shown["events"]] == [e.text for e in scene.events]
    assert shown["cables"][1]["cut"] == 1.0
    assert scene.title in Document(html).texts


def test_the_same_scene_gives_the_same_page_and_few_points_a_smaller_one(scene, html):
    assert page.render(scene) == html
    assert len(page.render(scene, max_points=60)) < 0.6 * len(html)


def test_hostile_texts_stay_text():
    hostile = '</script><script>alert(1)</script><img src=x onerror="alert(2)">$title'
    scene = scenes.scene("exp1_1_quadrotors", title=hostile)
    document = Document(page.render(scene))
    assert not [a for _, a in document.elements if "onerror" in a]
    assert hostile in document.texts


# Frames by the clock of timers, which a browser without a screen may run ahead of its frames.
FRAMES = """<script>
requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);
cancelAnimationFrame = clearTimeout;
</script></head>"""

# A page that works its own controls as a reader would, and says in its title what came of it.
PROBE = """<script>
addEventListener("load", () => {
  const { replay } = document.querySelector(".replay"), said = {};
  const canvas = document.querySelector("[data-stage]");
  const key = (key, more = {}) => document.body.dispatchEvent(
    new KeyboardEvent("keydown", { key, bubbles: true, ...more }));
  const pointer = (type, x, y, more = {}) => canvas.dispatchEvent(
    new PointerEvent(type, { pointerId: 1, clientX: x, clientY: y, buttons: 1, ...more }));
  canvas.setPointerCapture = () => {};
  said.shared = replay.track.time;
  const slider = document.querySelector("[data-time]");
  slider.value = 1.25;
  slider.dispatchEvent(new Event("input"));
  said.scrubbed = replay.track.time;
  key("ArrowRight");
  said.stepped = replay.track.time;
  key("ArrowLeft", { shiftKey: true });
  said.back = replay.track.time;
  key("End");
  said.end = replay.track.time;
  const { camera } = replay, yaw = camera.yaw, target = camera.target, far = camera.distance;
  pointer("pointerdown", 300, 300);
  pointer("pointermove", 400, 300);
  pointer("pointerup", 400, 300);
  said.turned = camera.yaw - yaw;
  pointer("pointerdown", 300, 300);
  pointer("pointermove", 360, 300, { shiftKey: true });
  pointer("pointerup", 360, 300);
  said.moved = Vec.norm(Vec.sub(camera.target, target));
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -300, cancelable: true }));
  said.zoomed = camera.distance / far;
  camera.look("corner");
  const fingers = (apart) => [1, 2].map((id) => [id, 300 + (id === 1 ? -apart : apart)]);
  const near = camera.distance;
  for (const [id, x] of fingers(50)) pointer("pointerdown", x, 300, { pointerId: id });
  for (const [id, x] of fingers(100)) pointer("pointermove", x, 300, { pointerId: id });
  for (const [id, x] of fingers(100)) pointer("pointerup", x, 300, { pointerId: id });
  said.pinched = camera.distance / near;
  document.querySelector("[data-view=top]").click();
  said.above = camera.pitch;
  said.pressed = document.querySelectorAll("[data-view][aria-pressed=true]").length;
  said.sag = Cable.sagging([0, 0, 0], [0.3, 0.4, 0.2], 1.1);
  said.events = document.querySelectorAll("[data-events] button").length;
  replay.seek(0);
  key(" ");
  said.playing = replay.playing;
  const start = performance.now();
  const wait = () => {
    if (replay.track.time > 0.2 || performance.now() - start > 3000) {
      said.played = replay.track.time;
      key(" ");
      said.paused = !replay.playing;
      replay.seek(replay.track.end);
      const until = performance.now() + 2000;
      const look = () => {
        said.cursor = parseFloat(replay.plots[0].cursor.style.left);
        if (said.cursor > 200 || performance.now() > until) document.title = JSON.stringify(said);
        else setTimeout(look, 50);
      };
      look();
    } else setTimeout(wait, 50);
  };
  wait();
});
addEventListener("error", (event) => (document.title = "error: " + event.message));
</script></body>"""


def test_works_in_a_browser(scene, html, tmp_path):
    file = tmp_path / "probe.html"
    file.write_text(html.replace("</head>", FRAMES).replace("</body>", PROBE), encoding="utf-8")
    shown = scenes.look(f"{file.as_uri()}#t=0.5", tmp_path, "--dump-dom")
    title = re.search(r"<title>(.*?)</title>", shown, re.DOTALL).group(1)
    assert not title.startswith("error"), title
    said = json.loads(title)
    end = float(scene.t[-1])
    assert said["shared"] == 0.5  # an address may name a time
    assert said["scrubbed"] == 1.25
    assert said["stepped"] == pytest.approx(1.35)
    assert said["back"] == pytest.approx(0.35)
    assert said["end"] == end
    assert said["cursor"] > 200  # at the right of its plot
    assert abs(said["turned"]) > 0.3
    assert said["moved"] > 0.05
    assert said["zoomed"] < 0.8
    assert said["pinched"] == pytest.approx(0.5, rel=1e-6)
    assert said["above"] > 1.5
    assert said["pressed"] == 1
    assert said["events"] == len(scene.events) == 3
    assert said["playing"] is said["paused"] is True
    assert 0.2 < said["played"] < end
    same = cables.sagging(np.zeros(3), np.array([0.3, 0.4, 0.2]), 1.1)
    np.testing.assert_allclose(said["sag"], same, atol=1e-12)


@pytest.mark.parametrize("dark", [False, True])
def test_draws_in_light_and_dark_and_on_phones(html, tmp_path, dark):
    images = pytest.importorskip("PIL.Image")
    (tmp_path / "page.html").write_text(html, encoding="utf-8")
    for width, height in ((1280, 860), (500, 900)):
        file = tmp_path / f"{width}.png"
        options = [f"--screenshot={file}", *(["--force-dark-mode"] if dark else [])]
        address = (tmp_path / "page.html").as_uri() + "#t=1.5"
        scenes.look(address, tmp_path, *options, width=width, height=height)
        with images.open(file) as image:
            seen = np.asarray(image.convert("RGB")).astype(int)
        ground = seen[-1, 0]
        assert (ground < 60).all() if dark else (ground > 250).all()
        # Every vehicle's colour is somewhere in the picture, and a cable's amber or purple.
        for colour in ("#1f83c9", "#d55e00", "#009e73", "#cc79a7"):
            wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
            assert (np.abs(seen - wanted).max(axis=2) < 6).sum() > 20, colour
