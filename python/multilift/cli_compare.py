"""The command ``multilift compare``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from multilift import storage
from multilift.options import ForceOption

_out = Console()
_err = Console(stderr=True)


def compare(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")],
    tasks: Annotated[
        list[str] | None,
        typer.Argument(help="Spatial scenarios; left out: the shipped ones.", metavar="[TASK]..."),
    ] = None,
    draws: Annotated[
        int | None, typer.Option(min=1, help="Sets of gains for each law on each task: 256.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Of the draws, and of the noise while tuning: 2.")
    ] = None,
    threads: Annotated[int | None, typer.Option(min=1, help="Threads; one a processor.")] = None,
    force: ForceOption = False,
) -> None:
    """Tune all spatial laws with the same effort, on the same tasks: tables, figures, a report."""
    storage.check_target(output, force=force)
    from multilift import compare as job  # noqa: PLC0415 - loads the plotting packages
    from multilift.compare import tables  # noqa: PLC0415

    result = job.compare(
        tasks or job.TASKS, output, draws=job.DRAWS if draws is None else draws,
        seed=job.SEED if seed is None else seed, threads=threads, force=force, console=_err,
    )  # fmt: skip
    for name, entries in result.to_json()["tasks"].items():
        table = Table(box=None, header_style="bold", title=name, title_justify="left")
        table.add_column("law", no_wrap=True)
        for head in tables.heads():
            table.add_column(head, justify="right")
        for law, entry in entries.items():
            table.add_row(tables.LABELS.get(law, law), *tables.cells(entry, result.draws))
        _out.print(table, highlight=False)
    _out.print(f"\n{tables.LEGEND}", highlight=False)
    _out.print(f"\nReport: [bold]{escape(str(result.report))}[/]", soft_wrap=True)
