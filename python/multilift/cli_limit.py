"""The command ``multilift limit``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

import multilift as ml
from multilift import limit as job
from multilift import storage
from multilift.errors import ScenarioError
from multilift.limit import output as files
from multilift.models.planar.scenario import planar_only
from multilift.options import ForceOption, SetOption, load_changed

_out = Console()


def limit(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file, or a shipped name.", metavar="SCENARIO")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for the bound, its run, table and figure."),
    ] = None,
    least: Annotated[
        str, typer.Option(help="What to make least: time; or effort or swing, with --time.")
    ] = "time",
    time: Annotated[
        float | None, typer.Option(help="How long the move lasts, s, for effort and swing.")
    ] = None,
    forces: Annotated[
        str,
        typer.Option(
            "--forces",
            metavar="LIMIT",
            help="Greatest control force of a vehicle: 'law', what the scenario's law commands; "
            "'scenario', its limits of thrust and tilt alone; or numbers, N, along each axis, "
            "such as 5,2.",
        ),
    ] = "law",
    speed: Annotated[float, typer.Option(help="Greatest speed of a vehicle, m/s.")] = math.inf,
    swing: Annotated[float, typer.Option(help="Greatest angle of the load, deg.")] = 89.0,
    tension: Annotated[float, typer.Option(help="Least tension of a cable, N.")] = 0.0,
    push: Annotated[
        int | None,
        typer.Option(
            help="The way back from this push, counted from 1, through which the "
            "vehicles hovered; planar."
        ),
    ] = None,
    intervals: Annotated[int, typer.Option(help="Intervals of the first mesh.")] = 24,
    beside: Annotated[
        list[str] | None,
        typer.Option("--beside", metavar="LAW", help="Laws to compare; left out: the scenario's."),
    ] = None,
    changes: SetOption = None,
    force: ForceOption = False,
) -> None:
    """The physical bound of a move: how fast, or with how little, any law could fly it."""
    if output is not None:
        storage.check_target(output, force=force)
    given = load_changed(scenario, changes)
    if push is not None:
        from multilift.models.planar.move import after_push  # noqa: PLC0415 - few ask for it

        given = after_push(planar_only(given, "--push"), push)
    wanted = job.Limits(_forces(forces, given), speed, math.radians(swing), tension)
    bound = job.find(given, wanted, least=least, time=time, intervals=intervals)
    laws: list[str | None] = [*beside] if beside else [None]
    runs = [ml.simulate(given, law) for law in laws]
    _print(bound, runs)
    if output is not None:
        files.save(bound, output, runs, force=force)
        _out.print(f"\nWritten to [bold]{escape(str(output))}[/]; replay it with: multilift view "
                   f"{escape(str(output / 'run'))}", soft_wrap=True)  # fmt: skip


def _forces(text: str, scenario: ml.Scenario) -> tuple[float, ...] | None:
    if text == "law":
        return None
    if text == "scenario":
        return job.of_the_scenario(scenario)
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ScenarioError(
            "is no limit of force", where="multilift limit", key="--forces", value=text,
            permitted="law, scenario, or positive numbers with commas between, N",
        ) from None  # fmt: skip


def _print(bound: job.Bound, runs: list[ml.Run]) -> None:
    last = bound.solutions[-1]
    unit = {"time": "s", "effort": "N^2 s", "swing": "rad^2 s"}[bound.least]
    force = [f for f in bound.limits.force or () if math.isfinite(f)]
    axes = " x ".join(f"{f:.3g}" for f in force)
    _out.print(f"[bold]{escape(bound.scenario.title)}[/]: least {bound.least}", highlight=False)
    _out.print(
        f"{last.objective:.4g} {unit}"
        + ("" if bound.least == "time" else f" in {bound.time:.4g} s")
        + (
            f", with forces up to {axes} N along the axes\n"
            if force
            else ", within the scenario's limits of thrust and tilt\n"
        ),
        highlight=False,
    )
    table = Table("mesh", f"least {bound.least} ({unit})", "iterations", box=None,
                  header_style="bold")  # fmt: skip
    for s in bound.solutions:
        table.add_row(f"{len(s.inputs)}", f"{s.objective:.5g}", str(s.iterations))
    _out.print(table, highlight=False)
    arrival = bound.arrival
    _out.print(
        f"\nFlown on the plant, the move ends {arrival['position']:.1e} m, {arrival['speed']:.1e} "
        f"m/s and {arrival['swing']:.1e} deg from rest at the goal.\n",
        highlight=False,
        soft_wrap=True,
    )
    table = Table("", "combined settling (s)", "times the move", "ended", box=None,
                  header_style="bold")  # fmt: skip
    for run in [bound.run, *runs]:
        settled, multiple = run.metrics["combined_settling"], bound.multiple(run)
        found = math.isfinite(settled)
        table.add_row(escape(run.controller_title), f"{settled:.2f}" if found else "-",
                      f"{multiple:.2f}" if found else "-", run.status)  # fmt: skip
    _out.print(table, highlight=False)
