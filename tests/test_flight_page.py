"""The page of a run: complete, offline, and its replay alive."""

import json
import re

import pytest
import replay_scenes as scenes

pytest.importorskip("jinja2")
pytest.importorskip("plotly")
pytest.importorskip("matplotlib")

HOSTILE = '</script><script>alert(1)</script><img src=x onerror="alert(2)">'


@pytest.fixture(scope="module")
def run():
    return scenes.cut()


@pytest.fixture(scope="module")
def html(run, tmp_path_factory):
    return (run.save(tmp_path_factory.mktemp("run") / "out") / "report.html").read_text("utf-8")


def test_holds_every_number_and_loads_nothing(run, html):
    for name in (*run.metrics, *run.audit, *run.residuals):
        assert f"<code>{name}</code>" in html
    assert run.scenario.title in html
    assert run.ending in html
    addresses = re.findall(r"""(?:src|href)=["']([^"']*)["']""", html)
    assert all(a.startswith(("data:", "#")) for a in addresses)
    code = html.replace("http://www.w3.org/2000/svg", "")  # the name of SVG elements, no address
    assert not re.search(r"https?:|@import|url\(|XMLHttpRequest|import\(", code)


def test_hostile_texts_stay_text(tmp_path):
    hostile = scenes.run("exp1_1_quadrotors", title=HOSTILE, description=HOSTILE)
    assert HOSTILE not in (hostile.save(tmp_path / "out") / "report.html").read_text("utf-8")


# The page's own script asks the replay inside it, which shares its origin.
PROBE = """<script>
addEventListener("load", () => setTimeout(() => {
  const { replay } = document.querySelector("iframe").contentDocument.querySelector(".replay");
  replay.seek(1.25);
  document.title = JSON.stringify({ end: replay.track.end, time: replay.track.time });
}, 500));
</script></body>"""


def test_the_replay_inside_works_in_a_browser(run, html, tmp_path):
    # Its own end is the last; the replay's is inside the frame's source.
    head, _, tail = html.rpartition("</body>")
    (tmp_path / "page.html").write_text(f"{head}{PROBE}{tail}", encoding="utf-8")
    shown = scenes.look((tmp_path / "page.html").as_uri(), tmp_path, "--dump-dom")
    title = re.search(r"<title>(.*?)</title>", shown, re.DOTALL).group(1)
    assert json.loads(title) == {"end": run.t[-1], "time": 1.25}
