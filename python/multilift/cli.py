"""The command line: ``multilift run | view | study | compare | fly | twin | sitl | ...``."""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

import multilift as ml
from multilift import library, storage
from multilift.cli_compare import compare
from multilift.cli_fly import fly, twin
from multilift.cli_limit import limit
from multilift.cli_replay import replay
from multilift.cli_sitl import sitl
from multilift.cli_view import view
from multilift.errors import MultiliftError, ScenarioError
from multilift.limit.output import read_time
from multilift.options import ControllerOption, ForceOption, SetOption, load_changed
from multilift.run import Run

#: When the process began, as good as: until now it has done nothing but load packages.
_BEGUN = time.perf_counter() - time.process_time()

EXIT_BAD_INPUT = 2
EXIT_ENDED_EARLY = 3
EXIT_INTERRUPTED = 130

_EPILOG = (
    "Exit codes: 0 done; 1 a failure of multilift itself; 2 bad input, or output that cannot be "
    "written; 3 a run ended early (slack cable, swing limit, divergence) and what it had is kept; "
    "130 interrupted."
)

app = typer.Typer(
    name="multilift",
    help="Multirotors that carry one load together on cables: simulate, audit, reproduce.",
    epilog=_EPILOG,
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
_out = Console()
_err = Console(stderr=True)

ScenarioArgument = Annotated[
    str, typer.Argument(help="A scenario file, or the name of a shipped one.", metavar="SCENARIO")
]


def _version(wanted: bool) -> None:
    if wanted:
        _out.print(f"multilift {ml.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command(
    epilog="Examples:  multilift run sim1  |  multilift run scenarios/sim1.toml -o out/sim1 "
    "--set controller.k_lambda=0.8  |  multilift run exp2 --controller my_law.py:MyLaw"
)
def run(
    scenario: ScenarioArgument,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for trajectory, metrics, scenario, figures."),
    ] = None,
    changes: SetOption = None,
    controller: ControllerOption = None,
    bound: Annotated[
        Path | None,
        typer.Option(
            help="Folder of this move's bound, of multilift limit: the settling time is "
            "then shown as a multiple of it."
        ),
    ] = None,
    force: ForceOption = False,
) -> None:
    """Simulate one scenario; print its metrics and energy audit."""
    if output is not None:
        storage.check_target(output, force=force)
    chosen = load_changed(scenario, changes)
    least = None if bound is None else read_time(bound, chosen.name)
    result = ml.simulate(chosen, controller)
    if least is not None:
        result.compare_with(least)
    _print_run(result)
    if output is not None:
        result.save(output, force=force)
        _out.print(f"\nWritten to [bold]{escape(str(output))}[/]", soft_wrap=True)
    if not result.finished:
        _err.print(f"[bold yellow]ended early:[/] {escape(result.ending)}")
        raise typer.Exit(EXIT_ENDED_EARLY)


app.command(
    epilog="Examples:  multilift view platform_turn  |  multilift view out/run --page run.html  |  "
    "multilift view cable_cut --gif cut.gif --save cut.rrd"
)(view)

app.command(
    epilog="Examples:  multilift sitl --px4 ~/PX4-Autopilot  |  multilift sitl --ardupilot "
    "~/ardupilot --speed 0 --logs out/sitl  |  multilift sitl my.toml --px4 PATH --no-vision"
)(sitl)

app.command(
    epilog="Examples:  multilift fly  |  multilift fly LAB.toml --log first.mcap. Keys: Enter go, "
    "Space hold, l land all, k kill (asks), q land and leave."
)(fly)

app.command(
    epilog="Examples:  multilift twin  |  multilift twin LAB.toml --speed 2  |  "
    "multilift twin --yes"
)(twin)

app.command(
    epilog="Examples:  multilift replay flight.mcap  |  multilift replay flight.mcap -o out/flight "
    "--ulog left.ulg --ulog right.ulg"
)(replay)


@app.command(
    epilog="Examples:  multilift study robustness_sim1 -o out/robust  |  multilift study my.toml "
    "-o out/mine --count 100000  |  multilift study my.toml -o out/mine --engine ray  |  "
    "multilift study --list. After an interruption, of whatever kind, the same command goes on."
)
def study(
    file: Annotated[
        str | None,
        typer.Argument(help="A study file, or the name of a shipped one.", metavar="STUDY"),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for rows, summary and report.")
    ] = None,
    engine: Annotated[
        str, typer.Option(help="local: all threads of this machine; ray: a Ray cluster.")
    ] = "local",
    threads: Annotated[
        int | None, typer.Option(min=1, help="Threads; with ray, processors a task (then 1).")
    ] = None,
    count: Annotated[
        int | None, typer.Option(min=1, help="Draws for each cell, instead of the file's.")
    ] = None,
    chunk: Annotated[
        int | None, typer.Option(min=1, help="Worlds a part, the most that a kill can cost: 8192.")
    ] = None,
    force: ForceOption = False,
    shipped: Annotated[bool, typer.Option("--list", help="List the studies that ship.")] = False,
    show: Annotated[
        str | None, typer.Option("--show", help="Print one shipped study's file.")
    ] = None,
) -> None:
    """Simulate many worlds of a scenario under one or more laws: rows, summary, report.html."""
    if show is not None:
        sys.stdout.write(library.find_study(show).read_text(encoding="utf-8"))
        return
    from multilift import study as job  # noqa: PLC0415 - the shorter start for other commands

    if shipped:
        _list_studies(job)
        return
    if file is None or output is None:
        missing = "argument 'STUDY'" if file is None else "option '--output' / '-o'"
        raise typer.BadParameter(f"Missing {missing}, or --list.")
    plan = job.load(file, count=count)
    from multilift.study import run as runner  # noqa: PLC0415 - loads the plotting packages

    try:
        result = runner.run(plan, output, engine=engine, threads=threads, chunk=chunk, force=force,
                            console=_err, begun=_BEGUN)  # fmt: skip
    except KeyboardInterrupt:
        _err.print("finished chunks are kept: the same command goes on behind them")
        raise
    _print_study(result, local=engine == "local")


def _list_studies(job: Any) -> None:
    table = Table("name", "worlds", "laws", "title", box=None, header_style="bold")
    for path in library.studies():
        plan = job.load(path)
        table.add_row(plan.name, f"{plan.worlds:,}", str(len(plan.controllers)), plan.title)
    _out.print(table)
    _out.print("\nStart your own:  multilift study --show robustness_sim1 > my_study.toml")


def _print_study(result: Any, *, local: bool) -> None:
    summary, cost = result.summary, result.cost
    table = Table("law", "success", "95 % interval", "worlds", "ended early", box=None,
                  header_style="bold")  # fmt: skip
    for law in summary.laws:
        rate = law.success
        table.add_row(law.law, f"{100 * rate.estimate:.2f} %",
                      f"{100 * rate.low:.2f} to {100 * rate.high:.2f} %" if summary.study.sampled
                      else "-", f"{summary.study.worlds:,}",
                      f"{summary.study.worlds - law.outcomes['finished']:,}")  # fmt: skip
    _out.print(table, highlight=False)
    if cost.runs:
        outside = f"{100 * cost.outside:.1f} % of the time outside the compiled kernel; " * local
        _out.print(
            f"\n{cost.runs:,} runs ({cost.simulated_seconds:,.4g} simulated s) in "
            f"{cost.wall_seconds:.1f} s: {cost.rate:,.4g} simulated seconds a second; {outside}a "
            f"million such runs take {cost.wall_seconds / cost.runs * 1e6 / 3600:,.3g} h at this "
            "rate",
            highlight=False,
            soft_wrap=True,
        )
    _out.print(f"Report: [bold]{escape(str(result.report))}[/]", soft_wrap=True)


app.command(
    epilog="Examples:  multilift limit sim1  |  multilift limit exp1_1 -o out/limit --beside pd "
    "--beside energy_coupled  |  multilift limit sim2 --least swing --time 3 --forces 5,6"
)(limit)

app.command(
    epilog="Examples:  multilift compare -o out/compare  |  multilift compare uneven_four my.toml "
    "-o out/mine --draws 64"
)(compare)


@app.command(
    epilog="Examples:  multilift reproduce -o out/paper  |  multilift reproduce -o out/mine "
    "--with my_law.py:MyLaw"
)
def reproduce(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")],
    beside: Annotated[
        list[str] | None,
        typer.Option(
            "--with", metavar="FILE.py:NAME", help="Your own law, beside the paper's two."
        ),
    ] = None,
    studies: Annotated[
        bool,
        typer.Option("--studies", help="Run the shipped studies at a small size too; a minute."),
    ] = False,
    force: ForceOption = False,
) -> None:
    """Run the paper's five tests under both laws: figures, data, claims, report.html."""
    from multilift import paper as job  # noqa: PLC0415 - loads the plotting packages

    result = job.reproduce(
        output, beside=beside or [], with_studies=studies, force=force, console=_err
    )
    _out.print(job.summary_table(result.runs))
    _out.print(f"\nReport: [bold]{escape(str(result.report))}[/]", soft_wrap=True)
    if not all(r.finished for laws in result.runs.values() for r in laws.values()):
        raise typer.Exit(EXIT_ENDED_EARLY)


@app.command(epilog="Example:  multilift check scenarios/*.toml my_scenario.toml")
def check(
    scenarios: Annotated[list[str], typer.Argument(help="Scenario files or shipped names.")],
    changes: SetOption = None,
) -> None:
    """Check scenarios without running them; report every one that is wrong."""
    failed = False
    for name in scenarios:
        try:
            scenario = load_changed(name, changes)
        except ScenarioError as error:
            failed = True
            _err.print(f"[bold red]wrong[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        else:
            _out.print(f"[green]good[/]  {escape(f'{name}: {scenario.title}')}", highlight=False)
    if failed:
        raise typer.Exit(EXIT_BAD_INPUT)


@app.command()
def scenarios(
    show: Annotated[
        str | None, typer.Option("--show", help="Print one shipped scenario's file.")
    ] = None,
) -> None:
    """List the scenarios that multilift ships, or print one to start from."""
    if show is not None:
        sys.stdout.write(library.find(show).read_text(encoding="utf-8"))
        return
    table = Table("name", "title", "source", box=None, header_style="bold")
    for file in library.files():
        scenario = ml.load(file)
        source = str(scenario.values["source"])
        table.add_row(*map(escape, (scenario.name, scenario.title, source)))
    _out.print(table)
    _out.print("\nStart your own:  multilift scenarios --show sim1 > my_scenario.toml")


@app.command()
def bench(
    repetitions: Annotated[int, typer.Option(min=1, help="Interleaved repetitions.")] = 7,
) -> None:
    """Measure speed: nanoseconds a step, and the ratio to MuJoCo in the same process."""
    from multilift import bench as benchmarks  # noqa: PLC0415 - loads MuJoCo if installed

    benchmarks.print_rows(benchmarks.run_benchmarks(repetitions), _out)


def _print_run(result: Run) -> None:
    title, law = escape(result.scenario.title), escape(result.controller_title)
    _out.print(f"[bold]{title}[/], {law}", highlight=False)
    _out.print(f"{result.ending}\n", highlight=False, markup=False)
    table = Table("metric", "value", "unit", "meaning", box=None, header_style="bold")
    for name, quantity in result.quantities.metrics.items():
        table.add_row(name, _number(result.metrics[name]), quantity.unit, quantity.doc)
    for quantity, value in result.beyond_metrics():
        table.add_row(quantity.name, _number(value), quantity.unit, quantity.doc)
    table.add_section()
    for name, quantity in result.quantities.audit.items():
        table.add_row(name, _number(result.audit[name]), quantity.unit, quantity.doc)
    for name, quantity in result.quantities.residuals.items():
        table.add_row(name, _number(result.residuals[name]), quantity.unit, quantity.doc)
    _out.print(table, highlight=False)


def _number(x: float) -> str:
    return f"{x:.4g}" if math.isfinite(x) else "-"


def main() -> None:
    """Entry point: one clear message and a documented exit code for every foreseen error."""
    try:
        app()
    except MultiliftError as error:
        _err.print(f"[bold red]error:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(EXIT_BAD_INPUT)
    except KeyboardInterrupt:
        _err.print("interrupted")
        sys.exit(EXIT_INTERRUPTED)
