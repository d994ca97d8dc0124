"""The report page: complete, self-contained, and true to the data it was given."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import struct
import zlib
from html.parser import HTMLParser
from importlib import resources

import numpy as np
import pytest

pytest.importorskip("jinja2")
pytest.importorskip("plotly")

from multilift import report

HOSTILE = '</script><script>alert(1)</script><img src=x onerror="alert(2)"> & <!-- \u2028'


def png(width=4, height=3):
    def chunk(kind, body):
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    rows = b"".join(b"\x00" + b"\xff" * width for _ in range(height))
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def series(decay=0.3, records=401, d_hat=True):
    t = np.linspace(0.0, 4.0, records)
    swing = 0.12 * np.exp(-decay * t) * np.sin(2.3 * t)
    columns = {
        "t": t,
        "y1": 0.8 + 0.4 * (1 - np.exp(-t)),
        "z1": 2.0 + 1.5 * (1 - np.exp(-t)),
        "theta1": swing,
        "theta2": -swing,
        "theta3": np.zeros_like(t),
        "theta1_dot": np.gradient(swing, t),
        "u1": np.cos(t),
        "u1_applied": np.cos(t),
        "tension1": 3.9 + swing,
        "tension2": 3.9 - swing,
        "thrust1": 23.5 + swing,
        "attitude1": 0.3 * swing,
        "storage": 15.0 * np.exp(-t),
    }
    columns |= {"y2": columns["y1"] + 1.8, "z2": columns["z1"]}
    if d_hat:
        columns["d_hat_y1"] = -0.06 * (1 - np.exp(-t))
    return columns


def run(law="pd", title="PD", peak=3.74, settling=10.2, **changes):
    values = {
        "law": law,
        "title": title,
        "status": "finished",
        "status_sentence": "Ran its full 4 s.",
        "series": series(),
        "metrics": {"peak_swing_1": peak, "swing_settling_time": settling, "least": 3.6},
        "audit": {"storage_start": 15.0, "integration_error": -9.1e-14},
    }
    return report.RunView(**(values | changes))


def one_test(key="sim1", **changes):
    values = {
        "key": key,
        "title": f"Test called {key}",
        "source": "Figs. 2 and 3",
        "description": ["Lift by 1.5 m."],
        "geometry": report.Geometry(l0=1.8, l1=1.8, l2=1.8, l3=0.03),
        "start": [0.8, 2.0, 2.6, 2.0],
        "goal": [1.2, 3.5, 3.0, 3.5],
        "runs": [run(), run("energy_coupled", "Proposed", 1.78, 5.4, series=series(0.6))],
        "pushes": [report.Push(body="bar", force=(2.5, 0.0), start=1.0, duration=0.3)],
        "figures": [report.Figure(number="Fig. 2", caption="Positions.", alt="Curves", png=png())],
        "command": f"multilift run {key}",
        "assumptions": ["Drag of 0.1 N s/m."],
    }
    return report.PaperTest(**(values | changes))


def one_page(**changes):
    values = {
        "title": "A paper, reproduced",
        "subtitle": "Two tests",
        "summary": ["It holds."],
        "tests": [one_test(), one_test("sim2")],
        "metrics": [
            report.MetricInfo(
                name="peak_swing_1", label="Peak |θ₁|", unit="°", headline=True, doc="greatest |θ₁|"
            ),
            report.MetricInfo(
                name="swing_settling_time",
                label="Swing settles",
                unit="s",
                headline=True,
                missing="still swinging at the end",
            ),
            report.MetricInfo(name="least", label="Least tension", unit="N", lower_is_better=None),
        ],
        "claims": [
            report.Claim(
                statement=f"Claim that {verdict}",
                where="Section 5",
                verdict=verdict,
                evidence="5 s",
            )
            for verdict in ("holds", "holds in part", "does not hold", "cannot be checked")
        ],
        "discrepancies": [report.Discrepancy(title="M is singular", text="`rank M` is 6.\n\nSo.")],
        "sensitivity": [
            report.Sensitivity(
                title="Drag", intro="Other drag.", heads=["d", "peak"], rows=[["0", "4"]]
            )
        ],
        "commands": [report.Command(what="Everything:", line="multilift reproduce")],
        "provenance": [("Seed", "1")],
        "files": [report.FileInfo(path="data/sim 1.parquet", what="trajectory")],
    }
    return report.Page(**(values | changes))


class Document(HTMLParser):
    """Elements with attributes, and text by the element it stands in."""

    def __init__(self, html):
        super().__init__()
        self.elements = []
        self.scripts = []
        self.styles = []
        self.text = ""
        self._inside = None
        self.feed(html)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside = tag
            (self.scripts if tag == "script" else self.styles).append([dict(attrs), ""])

    def handle_endtag(self, tag):
        if tag == self._inside:
            self._inside = None

    def handle_data(self, data):
        if self._inside is None:
            self.text += data
        else:
            (self.scripts if self._inside == "script" else self.styles)[-1][1] += data

    def data(self):
        (text,) = [t for attrs, t in self.scripts if attrs.get("id") == "report-data"]
        return json.loads(text)


def decode(packed):
    if "c" in packed:
        return np.full(packed["n"], packed["c"])
    if "v" in packed:
        return np.array([math.nan if x is None else x for x in packed["v"]])
    return np.cumsum(packed["d"]) / 10.0 ** packed["p"]


@pytest.fixture(scope="module")
def html():
    return report.render(one_page())


def test_loads_nothing_from_anywhere(html):
    document = Document(html)
    for tag, attrs in document.elements:
        for name in (
            "src",
            "href",
            "srcset",
            "poster",
            "data",
            "action",
            "xlink:href",
            "background",
        ):
            address = attrs.get(name)
            assert address is None or address.startswith(("data:", "#", "./")), (tag, address)
    (style,) = document.styles
    assert not re.search(r"@import|url\(", style[1])
    (policy,) = [a["content"] for t, a in document.elements if a.get("http-equiv")]
    assert "default-src 'none'" in policy  # the browser enforces it
    assert "http" not in policy
    charts = resources.files("multilift.report").joinpath("charts.js").read_text("utf-8")
    assert 'plotlyServerURL: ""' in charts
    assert "sendChartToCloud" not in charts


def test_shows_everything_it_is_given(html):
    page = one_page()
    text = " ".join(Document(html).text.split())
    for test in page.tests:
        for part in (test.title, test.source, test.command, *test.description, *test.assumptions):
            assert part in text
    for info in page.metrics:
        assert info.label in text
    for claim in page.claims:
        assert claim.statement in text
        assert claim.evidence in text
        assert claim.where in text
    for part in (
        "M is singular",
        "rank M is 6.",
        "Other drag.",
        "Everything:",
        "multilift reproduce",
    ):
        assert part in text
    for part in ("Seed", "data/sim 1.parquet", "storage start", "−9.1×10⁻¹⁴", "Fig. 2 Positions."):
        assert part in text
    assert "Of 4 claims, 1 holds, 1 holds in part, 1 does not hold and 1 cannot be checked." in text
    assert html.count('<img src="data:image/png;base64,') == 2


def test_every_link_within_the_page_leads_somewhere(html):
    elements = Document(html).elements
    ids = [attrs["id"] for _, attrs in elements if "id" in attrs]
    assert len(set(ids)) == len(ids)
    for _, attrs in elements:
        if attrs.get("href", "").startswith("#"):
            assert attrs["href"][1:] in ids


@pytest.mark.parametrize("max_points", [1500, 57])
def test_embedded_data_are_the_input_to_six_digits(max_points):
    page = one_page()
    data = Document(report.render(page, max_points=max_points)).data()
    stride = math.ceil(400 / max_points)
    picked = sorted({*range(0, 401, stride), 400})
    for test, shown in zip(page.tests, data["tests"], strict=True):
        assert shown["goal"] == list(test.goal)
        assert shown["pushes"][0]["force"] == [2.5, 0.0]
        for one, embedded in zip(test.runs, shown["runs"], strict=True):
            for name in embedded["columns"]:
                exact = np.asarray(one.series[name])[picked]
                found = decode(embedded["columns"][name])
                assert found.shape == exact.shape
                assert np.max(np.abs(found - exact)) <= 0.5e-5 * np.max(np.abs(exact)) + 1e-300
            assert {"t", "y1", "theta2", "storage"} <= set(embedded["columns"])


def test_says_which_records_it_draws():
    assert "Drawn at every record," in report.render(one_page())
    assert "every 8th record and the last one" in report.render(one_page(), max_points=57)


def test_commands_that_act_as_given_are_not_embedded_twice():
    plain = Document(report.render(one_page())).data()["tests"][0]["runs"]
    assert all("u1_applied" not in r["columns"] for r in plain)
    columns = series()
    columns["u1_applied"] = columns["u1"] * 0.9
    late = one_page(tests=[one_test(runs=[run(), run("odd", series=columns)])])
    embedded = Document(report.render(late)).data()["tests"][0]["runs"]
    assert all("u1_applied" in r["columns"] for r in embedded)


def test_hostile_texts_stay_text(html):
    page = one_page(
        title=HOSTILE,
        subtitle=HOSTILE,
        reference=HOSTILE,
        summary=[HOSTILE],
        tests=[
            one_test(
                title=HOSTILE,
                short=HOSTILE,
                source=HOSTILE,
                description=[HOSTILE],
                runs=[run(title=HOSTILE, law=HOSTILE, status="slack", status_sentence=HOSTILE)],
                figures=[report.Figure(number=HOSTILE, caption=HOSTILE, alt=HOSTILE, png=png())],
                command=HOSTILE,
                assumptions=[HOSTILE + " `" + HOSTILE + "`"],
            ),
            one_test("sim2"),
        ],
        claims=[report.Claim(statement=HOSTILE, where=HOSTILE, verdict="holds", evidence=HOSTILE)],
        discrepancies=[report.Discrepancy(title=HOSTILE, text=HOSTILE)],
        sensitivity=[
            report.Sensitivity(title=HOSTILE, intro=HOSTILE, heads=[HOSTILE], rows=[[HOSTILE]])
        ],
        provenance=[(HOSTILE, HOSTILE)],
        files=[report.FileInfo(path="javascript:alert(3)", what=HOSTILE)],
    )
    document = Document(report.render(page))
    assert len(document.scripts) == len(Document(html).scripts)
    assert not [attrs for _, attrs in document.elements if "onerror" in attrs]
    assert not [attrs for _, attrs in document.elements if attrs.get("src") == "x"]
    (link,) = [a["href"] for _, a in document.elements if "alert%283%29" in a.get("href", "")]
    assert link.startswith("./javascript%3A")
    assert document.text.count(HOSTILE) > 15
    assert document.data()["tests"][0]["runs"][0]["title"] == HOSTILE


def test_columns_that_a_law_lacks_are_left_out():
    needed = ("t", "y1", "z1", "y2", "z2", "theta1", "theta2")
    bare = {name: series()[name] for name in needed}
    page = one_page(tests=[one_test(runs=[run(), run("own", series=bare)])])
    runs = Document(report.render(page)).data()["tests"][0]["runs"]
    assert "d_hat_y1" in runs[0]["columns"]
    assert set(runs[1]["columns"]) == set(needed)


@pytest.mark.parametrize("nothing", [None, math.nan])
def test_a_missing_value_is_a_dash_with_its_reason(nothing):
    page = one_page(tests=[one_test(runs=[run(settling=nothing), run("own")])])
    document = Document(report.render(page))
    text = " ".join(document.text.split())
    assert text.count("Swing settles: still swinging at the end.") == 2  # both tables
    assert "Swing settles: still" not in Document(report.render(one_page())).text
    assert "nan" not in text.lower().split()
    assert "None" not in text


def test_marks_the_better_of_the_laws_that_ran_to_the_end():
    marked = '<strong class="best">{}<span'
    html = report.render(one_page(tests=[one_test()]))
    assert html.count(marked.format("1.78")) == 2
    assert marked.format("3.74") not in html
    assert "−52 %" in html
    assert marked.format("3.60") not in html  # neither direction is better
    short = run("own", "Short", 1.0, status="slack", status_sentence="Cable 2 went slack at 3 s.")
    html = report.render(one_page(tests=[one_test(runs=[run(), short])]))
    assert '<strong class="best">' not in html
    assert "Cable 2 went slack at 3 s." in html
    equal = one_test(runs=[run(), run("own", "Equal", 3.741)])
    assert '<strong class="best">' not in report.render(one_page(tests=[equal]))


def test_a_diverged_run_keeps_its_beginning():
    columns = series()
    columns["y1"] = columns["y1"].copy()
    columns["y1"][-2:] = 4e7, math.nan
    diverged = run("own", status="diverged", status_sentence="Diverged.", series=columns)
    page = one_page(tests=[one_test(runs=[run(), diverged])])
    found = decode(Document(report.render(page)).data()["tests"][0]["runs"][1]["columns"]["y1"])
    np.testing.assert_allclose(found, columns["y1"], rtol=1e-5)


def test_the_same_contents_give_the_same_page(html):
    assert report.render(one_page()) == html


def test_a_page_of_almost_nothing():
    empty = report.Page(title="Nothing", subtitle="", summary=["None."], tests=[], metrics=[])
    assert Document(report.render(empty)).data()["tests"] == []


def broken(**changes):
    return one_page(tests=[dataclasses.replace(one_test(), **changes)])


def without(name):
    return {key: column for key, column in series().items() if key != name}


@pytest.mark.parametrize(
    ("page", "message"),
    [
        (broken(runs=[run(series=without("theta2"))]), "lacks theta2"),
        (broken(runs=[run(series=series() | {"y1": np.zeros(3)})]), "y1 has shape"),
        (broken(runs=[run(series=series() | {"t": -series()["t"]})]), "must not decrease"),
        (
            broken(figures=[report.Figure(number="Fig. 9", caption="", alt="", png=b"GIF89a")]),
            "Fig. 9.*not a PNG",
        ),
        (one_page(tests=[one_test("Sim 1"), one_test("sim-1")]), "same address"),
        (
            one_page(claims=[report.Claim(statement="", where="", verdict="maybe", evidence="")]),
            "no verdict is called 'maybe'",
        ),
        (
            one_page(
                sensitivity=[report.Sensitivity(title="Drag", intro="", heads=["d"], rows=[[]])]
            ),
            "Drag: a row",
        ),
    ],
)
def test_says_what_is_wrong_with_its_input(page, message):
    with pytest.raises(ValueError, match=message):
        report.render(page)


def test_styles_of_laws():
    styles = report.law_styles(["pd", "mine", "energy_coupled", "mine", "yours"])
    assert list(styles) == ["pd", "mine", "energy_coupled", "yours"]
    assert styles["pd"].color == "#D55E00"
    assert styles["pd"].dashes
    assert styles["energy_coupled"] == report.LawStyle("#0072B2", ())
    assert styles["mine"].color == "#009E73"
    assert styles["yours"].color == "#CC79A7"
