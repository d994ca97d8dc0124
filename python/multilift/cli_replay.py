"""The command ``multilift replay``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from multilift import storage
from multilift.errors import MissingExtraError, OutputError
from multilift.options import ForceOption

if TYPE_CHECKING:
    from multilift.flight.replay.beside import Replay

_out = Console()


def replay(
    flight: Annotated[Path, typer.Argument(help="A flight's log.", metavar="FLIGHT.mcap")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for report, trajectories and metrics."),
    ] = None,
    ulog: Annotated[
        list[Path] | None,
        typer.Option(help="What vehicle_1's autopilot recorded; again for vehicle_2, ..."),
    ] = None,
    force: ForceOption = False,
) -> None:
    """Show a flight again, beside its simulation and what the autopilots recorded."""
    if output is not None:
        storage.check_target(output, force=force)
    try:
        from multilift.flight.replay import beside, flown  # noqa: PLC0415 - an extra's packages
        from multilift.flight.replay import ulog as recordings  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise MissingExtraError(str(error.name), "fly", "multilift replay") from None
    found = flown.read(flight)
    files = ulog or []
    if len(files) > found.scenario.count:
        raise OutputError(
            f"--ulog is given {len(files)} times\n"
            f"  permitted: {found.scenario.count} times, once for each vehicle of {flight}"
        )
    compared = {k + 1: recordings.compare(found, k, recordings.read(file), str(file))
                for k, file in enumerate(files)}  # fmt: skip
    result = beside.Replay(found, compared)
    _print(result)
    if output is not None:
        result.save(output, force=force)
        _out.print(f"\nWritten to [bold]{escape(str(output))}[/]", soft_wrap=True)


def _print(result: Replay) -> None:
    flown, flight, simulation = result.flown, result.flight, result.simulation
    lasted = f"{flown.t[-1]:.1f} s, {len(flown.t)} ticks"
    _out.print(f"[bold]{escape(flown.scenario.title)}[/], {lasted}", highlight=False)
    for change in flown.changes:
        wrong = f": {'; '.join(change.problems)}" if change.problems else ""
        _out.print(f"{change.time:9.2f} s  {change.state}{wrong}", highlight=False, markup=False)
    _out.print(f"the scenario's course: {flight.ending}\n", highlight=False, markup=False)
    table = Table("metric", "flight", "simulation", "unit", "meaning", box=None,
                  header_style="bold")  # fmt: skip
    for name, quantity in flight.quantities.metrics.items():
        table.add_row(name, _number(flight.metrics[name]), _number(simulation.metrics[name]),
                      quantity.unit, quantity.doc)  # fmt: skip
    table.add_section()
    for name, quantity in flight.quantities.audit.items():
        table.add_row(name, _number(flight.audit[name]), _number(simulation.audit[name]),
                      quantity.unit, quantity.doc)  # fmt: skip
    for difference in result.differences:
        _out.print(
            f"{difference.name}: {100 * difference.rms:.1f} cm from its simulation (root mean "
            f"square), {100 * difference.most:.1f} cm at most",
            highlight=False,
        )
    _out.print(table, highlight=False)
    for k, compared in result.compared.items():
        told = ", ".join(f"{name} {_number(x)}" for name, x in compared.numbers.items())
        _out.print(f"recording of vehicle {k}: {told}", highlight=False)


def _number(x: float) -> str:
    return f"{x:.4g}" if math.isfinite(x) else "-"
