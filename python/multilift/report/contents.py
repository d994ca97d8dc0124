"""What a report shows, as data.

All lengths, times and forces are SI and all angles radians; the page converts to degrees where it
shows them. Texts are plain: they are escaped, a blank line starts a new paragraph, and `backticks`
set code.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Series = Mapping[str, NDArray[np.float64]]
"""Columns of a run by name, each as long as `t`.

The page's model says which are needed and which are shown where they are there, see `View`. Of the
planar one needed are t, y1, z1, y2, z2, theta1 and theta2; shown: theta3, the rates (`*_dot`),
u1..u4, u1_applied..u4_applied, tension1, tension2, d_hat_y1, d_hat_z1, d_hat_y2, d_hat_z2, storage,
bar_y, bar_z, thrust1, thrust2 (N), attitude1 and attitude2 (rad, positive towards +y).
"""

Body = Literal["bar", "vehicle_1", "vehicle_2"]
PushShape = Literal["pulse", "half_sine", "sine", "samples"]
Verdict = Literal["holds", "holds in part", "does not hold", "cannot be checked"]


@dataclass(frozen=True, kw_only=True)
class View:
    """What the page shows of the runs of a model; each model has one.

    Attributes:
        animated: columns that the animation needs of every run; "t" is the first.
        traced: columns that it draws where a run has them, and that have no curve.
        curves: what the interactive curves can show: groups of panels, as charts.js reads them.
        applied: columns of what acts, by the column of what was commanded; left out where all runs
            of a test act as commanded.
        ranges: by the name that the animation knows, columns whose common range scales it.
        player: the script that animates.
    """

    animated: tuple[str, ...]
    traced: tuple[str, ...]
    curves: Sequence[Mapping[str, Any]]
    applied: Mapping[str, str]
    ranges: Mapping[str, tuple[str, ...]]
    player: str


DEFAULT_AUDIT_NOTE = (
    "The storage function is the quantity that the stability proof says can only fall. Its change "
    "over a run must equal the sum of the works listed here; what is left over is the error of the "
    "numerical integration."
)


@dataclass(frozen=True, kw_only=True)
class Geometry:
    """Lengths of the planar system, m: bar, cables, and how far the bar's centre hangs low."""

    l0: float
    l1: float
    l2: float
    l3: float


@dataclass(frozen=True, kw_only=True)
class Push:
    """An outside force on a body; `force` is (y, z) in N, its peak where the shape varies."""

    body: Body
    force: tuple[float, float]
    start: float
    duration: float
    shape: PushShape = "pulse"
    frequency: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A still figure. `png` holds the image file's bytes; `number` is, for example, "Fig. 2"."""

    number: str
    caption: str
    alt: str
    png: bytes


@dataclass(frozen=True, kw_only=True)
class RunView:
    """One law in one test.

    Attributes:
        law: Name of the law; the same name has the same colour and line on the whole page.
        title: The law as readers should see it.
        status: "finished" for a run that lasted its full duration, else why it ended.
        status_sentence: The same as a sentence.
        series: The run's records.
        metrics: Values by metric name; None or NaN where there is none.
        audit: Energy audit entries by name, J.
    """

    law: str
    title: str
    status: str
    status_sentence: str
    series: Series
    metrics: Mapping[str, float | None]
    audit: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class PaperTest:
    """One test of the paper and what each law did in it.

    Attributes:
        key: Short unique name, used in addresses within the page.
        title: For example "Simulation test 1".
        source: Where in the paper, for example "Figs. 2 and 3".
        description: Sentences that say what is asked of the system.
        geometry: Lengths of the system.
        start: y1, z1, y2, z2 at the start, m.
        goal: y1, z1, y2, z2 to reach, m.
        runs: One per law, the baseline first.
        pushes: Outside forces.
        figures: Still figures.
        command: The command line that runs this test again.
        assumptions: What the paper does not give and was chosen here.
        short: Label for the navigation; the title if empty.
    """

    key: str
    title: str
    source: str
    description: Sequence[str]
    geometry: Geometry
    start: Sequence[float]
    goal: Sequence[float]
    runs: Sequence[RunView]
    pushes: Sequence[Push] = ()
    figures: Sequence[Figure] = ()
    command: str = ""
    assumptions: Sequence[str] = ()
    short: str = ""


@dataclass(frozen=True, kw_only=True)
class MetricInfo:
    """How to show a metric or an audit entry.

    Attributes:
        name: Key in `RunView.metrics` or `RunView.audit`.
        label: What readers see.
        unit: Unit, empty for none.
        doc: What it is, in a line.
        digits: Decimals.
        lower_is_better: None where neither direction is better.
        headline: Whether the table at the top of the page shows it.
        missing: What it means that there is no value.
    """

    name: str
    label: str
    unit: str
    doc: str = ""
    digits: int = 2
    lower_is_better: bool | None = True
    headline: bool = False
    missing: str = "no value: not reached before the end of the run"


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A statement of the paper and what was found."""

    statement: str
    where: str
    verdict: Verdict
    evidence: str


@dataclass(frozen=True, kw_only=True)
class Discrepancy:
    """Something that does not hold as printed."""

    title: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """A table of how results change with an assumption."""

    title: str
    intro: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Command:
    """A command line and what it does."""

    what: str
    line: str


@dataclass(frozen=True, kw_only=True)
class FileInfo:
    """A file written beside the page; `path` is relative to it."""

    path: str
    what: str


@dataclass(frozen=True, kw_only=True)
class Page:
    """The whole report.

    Attributes:
        title: Main heading.
        subtitle: A line under it.
        reference: The paper, as one cites it.
        summary: Sentences of the opening paragraph: the answer.
        tests: Tests, in order; the first is the one that plays at the top.
        metrics: The metrics to show, in order.
        claims: Statements of the paper with verdicts.
        discrepancies: What does not hold as printed.
        sensitivity: Tables of how results change with the assumptions.
        audit: The audit entries to show, in order; all of them, by name, if empty.
        audit_note: The line that explains the audit tables.
        commands: How to run everything again; each test's own command is added.
        provenance: (label, value) pairs.
        files: Files beside the page.
        model: Whose runs these are; it says what the animation and the curves show.
    """

    title: str
    subtitle: str
    summary: Sequence[str]
    tests: Sequence[PaperTest]
    metrics: Sequence[MetricInfo]
    reference: str = ""
    claims: Sequence[Claim] = ()
    discrepancies: Sequence[Discrepancy] = ()
    sensitivity: Sequence[Sensitivity] = ()
    audit: Sequence[MetricInfo] = ()
    audit_note: str = DEFAULT_AUDIT_NOTE
    commands: Sequence[Command] = ()
    provenance: Sequence[tuple[str, str]] = ()
    files: Sequence[FileInfo] = ()
    model: str = "planar"
