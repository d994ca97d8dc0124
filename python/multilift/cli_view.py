"""The command ``multilift view``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

import multilift as ml
from multilift import saved
from multilift.errors import ScenarioError
from multilift.options import ControllerOption, ForceOption, SetOption, load_changed

_out = Console()


def view(
    run: Annotated[
        str,
        typer.Argument(
            help="Folder of a saved run, scenario file, or shipped name.", metavar="RUN"
        ),
    ],
    page: Annotated[
        Path | None, typer.Option(help="Write one HTML page that turns and plays offline.")
    ] = None,
    gif: Annotated[Path | None, typer.Option(help="Write a short animation.")] = None,
    save: Annotated[Path | None, typer.Option(help="Write a Rerun recording, FILE.rrd.")] = None,
    spawn: Annotated[
        bool, typer.Option("--spawn", help="Open Rerun's viewer; done where nothing is written.")
    ] = False,
    changes: SetOption = None,
    controller: ControllerOption = None,
    force: ForceOption = False,
) -> None:
    """Replay a run in space: in Rerun's viewer, as an offline page, as a GIF."""
    from multilift import replay  # noqa: PLC0415 - the shorter start for other commands
    from multilift.replay import recording  # noqa: PLC0415

    written = [file for file in (page, gif, save) if file is not None]
    for file in written:
        replay.check(file, force=force)
    spawn = spawn or not written
    if spawn or save is not None:
        recording.need_rerun()
    if saved.is_saved(run):
        if changes or controller:
            raise ScenarioError(
                "is a run that is over", where=run,
                advice="leave out --set and --controller, or name a scenario",
            )  # fmt: skip
        shown = saved.read(run)
    else:
        shown = ml.simulate(load_changed(run, changes), controller)
    replay.write(shown, save=save, page=page, gif=gif, spawn=spawn)
    for file in written:
        _out.print(f"Written: [bold]{escape(str(file))}[/]", soft_wrap=True)
