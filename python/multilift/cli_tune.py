"""The command ``multilift tune``."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

import multilift as ml
from multilift import library
from multilift.errors import ScenarioError
from multilift.limit.output import read_time
from multilift.options import ForceOption, SetOption, load_changed

_out = Console()
_err = Console(stderr=True)

_WHERE = "multilift tune"


def tune(
    scenario: Annotated[
        str | None,
        typer.Argument(help="A scenario file, or a shipped name.", metavar="SCENARIO"),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for tuned scenario and report.")
    ] = None,
    tuning: Annotated[
        str | None,
        typer.Option(
            "--tuning",
            metavar="FILE",
            help="A tuning file, or a shipped one: variables, "
            "objectives, constraints, draws. Left out: 'settle', or --vary and --minimise.",
        ),
    ] = None,
    controller: Annotated[
        str | None, typer.Option("--controller", "-c", help="Compiled law to tune.")
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH", help="A number to tune; ':log' for its logarithm."),
    ] = None,
    minimise: Annotated[
        list[str] | None, typer.Option(metavar="METRIC", help="Most important first.")
    ] = None,
    maximise: Annotated[
        list[str] | None, typer.Option(metavar="METRIC", help="After those of --minimise.")
    ] = None,
    keep: Annotated[
        list[str] | None,
        typer.Option(metavar="METRIC<X", help="A constraint: METRIC<X or METRIC>X."),
    ] = None,
    front: Annotated[
        bool, typer.Option("--front", help="All compromises between two or three objectives.")
    ] = False,
    over: Annotated[
        str | None,
        typer.Option(metavar="STUDY", help="Tune over a study's draws instead of one flight."),
    ] = None,
    statistic: Annotated[
        str | None, typer.Option(help="Over draws: quantile, worst or mean.")
    ] = None,
    budget: Annotated[int | None, typer.Option(help="Sets of numbers to fly: 4096.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of the search: 1.")] = None,
    threads: Annotated[int | None, typer.Option(min=1, help="Threads; one a processor.")] = None,
    bound: Annotated[
        Path | None,
        typer.Option(help="Folder of this move's bound, of multilift limit, to compare with."),
    ] = None,
    changes: SetOption = None,
    force: ForceOption = False,
    shipped: Annotated[bool, typer.Option("--list", help="List the tunings that ship.")] = False,
    show: Annotated[
        str | None, typer.Option("--show", help="Print one shipped tuning's file.")
    ] = None,
) -> None:
    """Choose gains, or any numbers of a scenario, so that its metrics become best."""
    if show is not None:
        sys.stdout.write(library.find_tuning(show).read_text(encoding="utf-8"))
        return
    if shipped:
        _list()
        return
    if output is None or (scenario is None and tuning is None):
        missing = "argument 'SCENARIO'" if output is not None else "option '--output' / '-o'"
        raise typer.BadParameter(f"Missing {missing}, or --list.")
    from multilift import tune as job  # noqa: PLC0415 - the shorter start for other commands
    from multilift.tune import run as runner  # noqa: PLC0415

    runner.check_folder(output)
    given = {
        "controller": controller, "budget": budget, "seed": seed, "statistic": statistic,
        "variable": [_variable(text) for text in vary or []],
        "objective": [*({"metric": m} for m in minimise or []),
                      *({"metric": m, "sense": "maximise"} for m in maximise or [])],
        "constraint": [_constraint(text) for text in keep or []],
        "combine": "front" if front else None, "over": {"study": over} if over else None,
    }  # fmt: skip
    content: dict[str, Any] = {k: v for k, v in given.items() if v not in (None, [])}
    base = None if scenario is None else load_changed(scenario, changes)
    if base is None and changes:
        raise ScenarioError("needs a scenario", where=_WHERE, key="--set",
                            advice="name one, or use [set] in the tuning")  # fmt: skip
    if tuning is None and "variable" not in content:
        tuning = _standard(base)
    plan = (
        job.load(tuning, base=base, **content)
        if tuning is not None
        else job.parse(content, _WHERE, Path(), base=base)
    )
    least = None if bound is None else read_time(bound, plan.scenario.name)
    with _Meter(plan) as meter:
        try:
            result = runner.run(plan, output, threads=threads, force=force, least_time=least,
                                progress=meter.show)  # fmt: skip
        except KeyboardInterrupt:
            _err.print("every finished generation is kept: the same command goes on behind them")
            raise
    _print(result)


def _standard(base: ml.Scenario | None) -> str:
    assert base is not None
    return "settle" if base.model.name == "planar" else "settle_space"


def _variable(text: str) -> dict[str, Any]:
    key, equals, bounds = text.partition("=")
    low, colon, rest = bounds.partition(":")
    high, log, scale = rest.partition(":")
    try:
        if not (equals and colon) or (log and scale != "log"):
            raise ValueError
        return {"key": key.strip(), "low": float(low), "high": float(high),
                "scale": "log" if log else "linear"}  # fmt: skip
    except ValueError:
        raise ScenarioError(
            "is not KEY=LOW:HIGH", where=_WHERE, key="--vary", value=text,
            permitted="such as controller.k_lambda=0.1:3 or controller.k_lambda=0.1:3:log",
        ) from None  # fmt: skip


def _constraint(text: str) -> dict[str, Any]:
    for sign, name in (("<", "below"), (">", "above")):
        metric, found, bound = text.partition(sign)
        if found:
            try:
                return {"metric": metric.strip(), name: float(bound)}
            except ValueError:
                break
    raise ScenarioError("is not METRIC<X or METRIC>X", where=_WHERE, key="--keep", value=text,
                        permitted="such as peak_tilt<20")  # fmt: skip


class _Meter:
    """The progress of a search: sets flown, and the best so far."""

    def __init__(self, plan: Any) -> None:
        self._plan = plan
        self._progress = Progress(
            TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(),
            TextColumn("{task.fields[best]}"), TimeRemainingColumn(), console=_err,
        )  # fmt: skip
        self._task = self._progress.add_task("tuning", total=plan.budget, best="")

    def __enter__(self) -> _Meter:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def show(self, found: Any) -> None:
        values = found.values(found.best)
        goal = self._plan.goal
        # Of objectives in order the first says how far it is; a line holds no more.
        shown = goal.objectives[: 1 if goal.combine == "lexicographic" else None]
        text = ", ".join(
            f"{o.metric} {values[o.metric]:.4g} {o.unit}".rstrip()
            for o in shown
            if math.isfinite(values[o.metric])
        )
        self._progress.update(self._task, completed=len(found.points),
                              best=f"best {text}" if text else "nothing settled")  # fmt: skip


def _list() -> None:
    from multilift.tune.spec import titles  # noqa: PLC0415

    table = Table("name", "title", box=None, header_style="bold")
    for name, title in titles():
        table.add_row(name, escape(title))
    _out.print(table)
    _out.print("\nStart your own:  multilift tune --show settle > my_tuning.toml")


def _print(result: Any) -> None:
    tuning = result.found.tuning
    title = escape(tuning.scenario.title)
    _out.print(f"[bold]{title}[/], {tuning.scenario.law}\n", highlight=False)
    table = Table("number", "before", "tuned", "may lie from", "to", box=None,
                  header_style="bold")  # fmt: skip
    for v, s in zip(tuning.space.varied, result.slices, strict=True):
        numbers = (result.before.numbers[v.name], result.after.numbers[v.name], s.low, s.high)
        table.add_row(escape(v.label), *(f"{x:.4g}" for x in numbers))
    table.add_section()
    for o in tuning.goal.objectives:
        values = (result.before.judged[o.metric], result.after.judged[o.metric])
        name = f"{o.metric} ({o.unit})" if o.unit else o.metric
        table.add_row(name, *(f"{x:.4g}" if math.isfinite(x) else "-" for x in values))
    _out.print(table, highlight=False)
    if result.after.violation > 0:
        _err.print("[bold yellow]no set of numbers was found that keeps every constraint[/]")
    _out.print(f"\nTuned: [bold]{escape(str(result.folder / 'tuned.toml'))}[/]", soft_wrap=True)
    _out.print(f"Report: [bold]{escape(str(result.report))}[/]", soft_wrap=True)
    _out.print(f"Check it: {escape(result.check)}", soft_wrap=True, highlight=False)
