"""A study's figures and its one offline page."""

from __future__ import annotations

import math
from importlib import resources

from markupsafe import Markup

from multilift import provenance
from multilift.report import html, law_styles
from multilift.report.text import inline, listed, number
from multilift.study import figures
from multilift.study.figures import Drawing
from multilift.study.statistics import Interval
from multilift.study.store import Store, write_whole
from multilift.study.summary import PROBABILITIES, Summary, toml_inline
from multilift.study.vary import Vary


def write(store: Store, summary: Summary) -> None:
    """Writes ``figures/*.png`` and ``report.html`` into the store's folder.

    Raises:
        OutputError: if they cannot be written.
    """
    folder = store.folder / "figures"
    folder.mkdir(exist_ok=True)
    drawings = figures.draw_all(store, summary)
    for drawing in drawings:
        write_whole(folder / f"{drawing.stem}.png", drawing.png)
    write_whole(store.folder / "report.html", render(store, summary, drawings).encode("utf-8"))


def render(store: Store, summary: Summary, drawings: list[Drawing]) -> str:
    """The page; it loads nothing from anywhere."""
    study = store.study
    environment = html.environment({
        "inline": inline, "percent": percent, "interval": interval, "value": value,
        "signed": signed, "toml": toml_inline,
    })  # fmt: skip
    laws = list(study.controllers)
    return environment.from_string(_text("multilift.study", "page.html.j2")).render(
        study=study,
        summary=summary,
        images=[(d, html.image(d.png)) for d in drawings],
        lead=lead(summary),
        styles=law_styles(laws),
        labels={law: figures.style(laws, law).label for law in laws},
        varied=[(v, distribution(v)) for v in study.vary],
        criteria=[c.sentence() for c in study.success],
        quantity={name: study.quantity(name) for name in study.metrics},
        probabilities=[f"{100 * p:g} %" for p in PROBABILITIES],
        outcomes=study.outcomes,
        kinds=list(dict.fromkeys(w.kind for w in summary.worst)),
        sampled=bool(study.sampled),
        provenance=list(provenance.describe().items()),
        command_line=f"multilift study {study.where} -o {store.folder} --count {study.count}",
        style=Markup(_text("multilift.report", "style.css")),
        script=Markup(_text("multilift.report", "page.js")),
    )


def lead(summary: Summary) -> list[str]:
    """The conclusion in sentences."""
    study = summary.study
    names = {law.law: figures.style(study.controllers, law.law).label for law in summary.laws}
    sentences = []
    for law in summary.laws:
        text = f"Under {names[law.law]}, {percent(law.success.estimate)} of "
        text += f"{study.worlds:,} worlds succeed"
        if study.sampled:
            text += f" (95 % interval {interval(law.success)})"
        early = study.worlds - law.outcomes["finished"]
        sentences.append(text + (f"; {early:,} ended early." if early else "; none ended early."))
    for pair in summary.pairs:
        sentences.append(
            f"Of the same worlds, {pair.only_first:,} succeed under {names[pair.first]} alone and "
            f"{pair.only_second:,} under {names[pair.second]} alone."
        )
    return sentences


def distribution(v: Vary) -> str:
    """What is drawn, in words."""
    if v.distribution == "list":
        return "each of " + listed([f"{x:g}" for x in v.values])
    if v.distribution == "grid":
        return f"{len(v.values)} values from {v.values[0]:g} to {v.values[-1]:g}"
    if v.distribution == "normal":
        text = f"normal, mean {v.mean:g}, standard deviation {v.std:g}"
        bounds = [f"above {v.low:g}"] * math.isfinite(v.low)
        bounds += [f"below {v.high:g}"] * math.isfinite(v.high)
        return ", ".join([text, *bounds])
    return f"{v.distribution.replace('_', '-')} from {v.low:g} to {v.high:g}"


def percent(share: float) -> str:
    """A share as a percentage with the digits that matter near 0 and 1."""
    if math.isnan(share):
        return "–"
    away = min(share, 1.0 - share)
    digits = 1 if away >= 0.01 or away == 0.0 else 2 if away >= 0.001 else 4
    return f"{100 * share:.{digits}f} %"


def interval(i: Interval) -> str:
    """An interval of shares."""
    return "–" if math.isnan(i.low) else f"{percent(i.low)} to {percent(i.high)}"


def value(x: float) -> str:
    """A number with about four digits, a dash where there is none."""
    if not math.isfinite(x) or x == 0.0:
        return "–" if not math.isfinite(x) else "0"
    return number(x, max(0, 3 - math.floor(math.log10(abs(x)))) if abs(x) >= 1e-4 else 1)


def signed(x: float) -> str:
    """As `value`, with its sign."""
    return ("+" if x > 0 else "") + value(x)


def _text(package: str, name: str) -> str:
    return resources.files(package).joinpath(name).read_text("utf-8")
