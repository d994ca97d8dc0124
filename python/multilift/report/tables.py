"""The page's tables of metrics and energy audits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from multilift.report.contents import MetricInfo, Page, PaperTest, RunView
from multilift.report.text import change, is_value, number


@dataclass(frozen=True)
class Cell:
    """A value of one law: its text, whether it is the best, and its change from the baseline."""

    text: str
    best: bool = False
    change: str = ""
    missing: bool = False


@dataclass(frozen=True)
class Row:
    """A metric or audit entry with a cell for each run of a test."""

    info: MetricInfo
    cells: list[Cell]


@dataclass(frozen=True)
class KeyGroup:
    """A test in the table at the top: each run with a cell for each headline metric."""

    lines: list[tuple[RunView, list[Cell]]]


@dataclass(frozen=True)
class KeyTable:
    """The table at the top of the page and what its marks mean."""

    infos: list[MetricInfo]
    groups: list[KeyGroup]
    notes: list[str]
    has_best: bool
    has_changes: bool


def _best(
    info: MetricInfo, values: Sequence[float | None], comparable: Sequence[bool]
) -> list[int]:
    """Which values are best among the comparable ones; none if all look alike."""
    if info.lower_is_better is None or sum(comparable) < 2:
        return []
    candidates = [
        (k, x) for k, x in enumerate(values) if comparable[k] and x is not None and is_value(x)
    ]
    if not candidates:
        return []
    pick = min if info.lower_is_better else max
    shown = number(pick(x for _, x in candidates), info.digits)
    best = [k for k, x in candidates if number(x, info.digits) == shown]
    return [] if len(best) == sum(comparable) else best


def metric_row(info: MetricInfo, test: PaperTest) -> Row:
    """Compares the runs of a test that lasted their full duration; only shows the others."""
    values = [run.metrics.get(info.name) for run in test.runs]
    comparable = [run.status == "finished" for run in test.runs]
    best = _best(info, values, comparable)
    cells = []
    for k, x in enumerate(values):
        compare = k > 0 and comparable[0] and comparable[k]
        cells.append(
            Cell(
                number(x, info.digits),
                k in best,
                change(x, values[0], info.digits) if compare else "",
                not is_value(x),
            )
        )
    return Row(info, cells)


def missing_notes(rows: Sequence[Row]) -> list[str]:
    """Why cells are empty: a line for each metric with an empty cell."""
    return [
        f"{row.info.label}: {row.info.missing}."
        for row in rows
        if any(cell.missing for cell in row.cells)
    ]


def key_table(page: Page) -> KeyTable:
    """The headline metrics of all tests; the first four metrics if none is marked so."""
    infos = [info for info in page.metrics if info.headline] or list(page.metrics[:4])
    groups: list[KeyGroup] = []
    rows: list[Row] = []
    for test in page.tests:
        test_rows = [metric_row(info, test) for info in infos]
        rows += test_rows
        groups.append(
            KeyGroup(
                [(run, [row.cells[k] for row in test_rows]) for k, run in enumerate(test.runs)]
            )
        )
    cells = [cell for row in rows for cell in row.cells]
    return KeyTable(
        infos,
        groups,
        list(dict.fromkeys(missing_notes(rows))),
        any(cell.best for cell in cells),
        any(cell.change for cell in cells),
    )


def audit_rows(page: Page, test: PaperTest) -> list[Row]:
    """The energy audit of a test's runs, as the page describes its entries."""
    names = {name: None for run in test.runs for name in run.audit}  # a dict keeps the order
    infos = [info for info in page.audit if info.name in names] or [
        MetricInfo(name=name, label=name.replace("_", " "), unit="J", digits=6) for name in names
    ]
    return [
        Row(info, [Cell(number(run.audit.get(info.name), info.digits)) for run in test.runs])
        for info in infos
    ]
