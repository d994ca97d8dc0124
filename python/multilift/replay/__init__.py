"""Replays of runs in space: an offline page, a Rerun recording, a GIF; see ``docs/replay``."""

from __future__ import annotations

from pathlib import Path

from multilift.errors import OutputError
from multilift.replay import gif as animation
from multilift.replay import page as pages
from multilift.replay import recording
from multilift.replay.scene import Scene
from multilift.run import Run


def scene_of(run: Run) -> Scene:
    """What a run looks like, for `multilift.replay.page.render` and the like.

    Raises:
        ScenarioError: if its model has no shape.
    """
    return run.scenario.model.scene(run)


def check(file: Path | None, *, force: bool) -> None:
    """Refuses a file that is taken or has no folder, before any work is done.

    Raises:
        OutputError: naming it.
    """
    if file is None:
        return
    if file.is_dir() or not file.parent.is_dir():
        raise OutputError(f"{file} cannot be written: no file can be there")
    if file.exists() and not force:
        raise OutputError(
            f"{file} is there already\n  what to do: choose another, or replace it with --force"
        )


def write(
    run: Run,
    *,
    save: Path | None = None,
    page: Path | None = None,
    gif: Path | None = None,
    spawn: bool = False,
) -> None:
    """Writes and opens replays of a run; files that are there are replaced.

    Args:
        run: of a model that has a shape.
        save: Rerun recording to write.
        page: self-contained page to write.
        gif: animation to write.
        spawn: open Rerun's viewer.

    Raises:
        MissingExtraError: if a package for one of them is not installed.
        OutputError: if a file cannot be written, or the viewer not opened.
    """
    shown = scene_of(run)
    if page is not None:
        try:
            page.write_text(pages.render(shown), encoding="utf-8")
        except OSError as error:
            raise OutputError(f"{page} cannot be written: {error.strerror}") from error
    if gif is not None:
        animation.write(shown, gif)
    if save is not None:
        recording.write(shown, save)
    if spawn:
        recording.write(shown, None)
