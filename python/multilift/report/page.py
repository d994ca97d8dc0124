"""The page made of a report's contents: one file that needs nothing but itself."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import quote

from markupsafe import Markup
from plotly.offline import get_plotlyjs

from multilift import models
from multilift.packed import resource, safe_json, script
from multilift.report import html
from multilift.report.contents import Claim, Figure, Page, PaperTest
from multilift.report.embed import drawn_note, page_data
from multilift.report.tables import Row, audit_rows, key_table, metric_row, missing_notes
from multilift.report.text import inline, listed, paragraphs
from multilift.styles import law_styles

_HERE = "multilift.report"
_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"

# By verdict: its name in the style sheet and how its count reads for one claim and for more.
_VERDICTS = {
    "holds": ("yes", "holds", "hold"),
    "holds in part": ("part", "holds in part", "hold in part"),
    "does not hold": ("no", "does not hold", "do not hold"),
    "cannot be checked": ("open", "cannot be checked", "cannot be checked"),
}


@dataclass(frozen=True)
class _TestView:
    test: PaperTest
    id: str
    short: str
    images: list[tuple[Figure, html.Image]]
    metrics: list[Row]
    missing: list[str]
    audit: list[Row]
    drawn: str


def _image(figure: Figure) -> html.Image:
    if figure.png[:8] != _PNG_SIGNATURE or len(figure.png) < 24:
        raise ValueError(f"{figure.number}: the figure's bytes are not a PNG file")
    return html.image(figure.png)


def _test_view(page: Page, test: PaperTest, max_points: int) -> _TestView:
    metrics = [metric_row(info, test) for info in page.metrics]
    return _TestView(
        test,
        "test-" + re.sub(r"[^a-z0-9]+", "-", test.key.lower()).strip("-"),
        test.short or test.title,
        [(figure, _image(figure)) for figure in test.figures],
        metrics,
        missing_notes(metrics),
        audit_rows(page, test),
        drawn_note(test, max_points),
    )


def _verdict_counts(claims: Sequence[Claim]) -> str:
    parts = []
    for verdict, (_, one, many) in _VERDICTS.items():
        count = sum(claim.verdict == verdict for claim in claims)
        if count:
            parts.append(f"{count} {one if count == 1 else many}")
    return listed(parts)


def _relative(path: str) -> str:
    """A path as an address within this page's folder."""
    return "./" + quote(path.replace("\\", "/"))


def _check(page: Page, views: Sequence[_TestView]) -> None:
    for claim in page.claims:
        if claim.verdict not in _VERDICTS:
            raise ValueError(f"no verdict is called {claim.verdict!r}; {listed(list(_VERDICTS))}")
    ids = [view.id for view in views]
    if len(set(ids)) != len(ids):
        raise ValueError(f"two tests have the same address on the page: {listed(ids)}")
    for table in page.sensitivity:
        if any(len(row) != len(table.heads) for row in table.rows):
            raise ValueError(f"{table.title}: a row is not as long as the table's head")


def render(page: Page, *, max_points: int = 1500) -> str:
    """Makes the page.

    Args:
        page: What to show.
        max_points: About how many records of each run the animation and the curves draw; figures
            and tables are the caller's and show whatever they were made of.

    Returns:
        A complete HTML document that loads nothing. The same contents give the same text.

    Raises:
        ValueError: A series lacks a column the animation needs or has columns of unequal length, a
            figure is not a PNG file, a verdict is unknown, a sensitivity table is ragged, or two
            tests share a key.
    """
    if max_points < 2:
        raise ValueError("max_points must be at least 2")
    view = models.by_name(page.model).view()
    views = [_test_view(page, test, max_points) for test in page.tests]
    _check(page, views)
    environment = html.environment(
        {"inline": inline, "paragraphs": paragraphs, "relative": _relative},
        keep_trailing_newline=True,
    )
    return environment.from_string(resource(_HERE, "template.html.j2")).render(
        page=page,
        views=views,
        key=key_table(page),
        styles=law_styles([run.law for test in page.tests for run in test.runs]),
        verdicts={name: entry[0] for name, entry in _VERDICTS.items()},
        verdict_counts=_verdict_counts(page.claims),
        style=Markup(resource(_HERE, "style.css")),
        scripts=[
            Markup(script(resource(package, name)))
            for package, name in (
                ("multilift", "packed.js"),
                (_HERE, "page.js"),
                (_HERE, view.player),
                (_HERE, "charts.js"),
            )
        ],
        data=Markup(safe_json(page_data(page.tests, view, max_points))),
        plotly=Markup(script(get_plotlyjs())),
    )
