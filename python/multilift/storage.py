"""Writing results so that nothing is lost and nothing half-written is left behind."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from multilift.errors import OutputError

#: A file that marks a folder as written by multilift, and so as one it may replace when told to.
MARKER = "run.json"


def check_target(target: Path, *, force: bool) -> None:
    """Refuses a target that is taken, before any work is done.

    Raises:
        OutputError: if something is there that may not be replaced, or its parent is unwritable.
    """
    try:
        exists = target.exists()
    except OSError as error:
        raise OutputError(f"{target} cannot be a folder: {error.strerror}") from error
    if exists:
        if not target.is_dir():
            raise OutputError(f"{target} is a file, not a folder\n  what to do: choose another")
        if any(target.iterdir()):
            if not (target / MARKER).is_file():
                raise OutputError(
                    f"{target} is not empty and was not written by multilift, so it is not "
                    "replaced\n  what to do: choose another folder"
                )
            if not force:
                raise OutputError(
                    f"{target} already holds a result\n"
                    "  what to do: choose another folder, or replace it with --force"
                )
    parent = target.parent
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise OutputError(f"{target} cannot be made: {parent} is not a folder one may write to")


@contextmanager
def new_folder(target: Path, *, force: bool = False) -> Iterator[Path]:
    """A fresh folder beside `target` that takes its name once everything in it is written.

    An old result at `target` stays until that moment, and comes back if the exchange fails.

    Raises:
        OutputError: as check_target, and when writing fails, with the reason.
    """
    check_target(target, force=force)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    except OSError as error:
        raise OutputError(f"{target} cannot be made: {error}") from error
    try:
        yield draft
        draft.chmod(0o777 & ~_umask())
        old = None
        if target.exists():
            old = Path(tempfile.mkdtemp(prefix=f".{target.name}-old-", dir=target.parent))
            target.rename(old / target.name)
        try:
            draft.rename(target)
        except OSError:
            if old is not None:
                (old / target.name).rename(target)
            raise
        if old is not None:
            shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"{target} cannot be written: {error}") from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
