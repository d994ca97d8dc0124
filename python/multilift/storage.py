"""Writing results so that nothing is lost and nothing half-written is left behind."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from multilift.errors import OutputError

#: A file that marks a folder as written by multilift, and so as one it may replace when told to.
MARKER = "run.json"

#: By which a process holds a folder that it goes on writing.
LOCK = ".lock"

#: How long to wait for it, s: a process just killed may still be going down.
_PATIENCE = 2.0


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


def write_whole(file: Path, content: bytes | memoryview) -> None:
    """Writes a file so that it is there complete or not at all, also after a power cut.

    Raises:
        OutputError: if it cannot be written.
    """
    draft = file.with_name(f".tmp-{os.getpid()}-{file.name[:80]}")
    try:
        with draft.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(file)
        _sync_folder(file.parent)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise as_output_error(error, file) from error


def as_output_error(error: OSError, place: Path) -> OutputError:
    """An error of the operating system as one of ours, with what to do."""
    if isinstance(error, OutputError):
        return error
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return OutputError(
            f"{place} cannot be written: the disk is full\n"
            "  what to do: free some space and give the same command again; what is "
            "finished is kept"
        )
    return OutputError(
        f"{place} cannot be written: {error}\n"
        "  what to do: mend that and give the same command again; what is finished is kept"
    )


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Holds a folder for this process; the system lets go when it ends, however it ends.

    Raises:
        OutputError: if another process holds it for longer than one that was killed takes to end.
    """
    with (folder / LOCK).open("a") as stream:
        until = time.monotonic() + _PATIENCE
        while True:
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > until:
                    raise OutputError(
                        f"{folder} is being written by another process\n"
                        "  what to do: wait for it, or choose another folder"
                    ) from None
                time.sleep(0.02)
        yield


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
