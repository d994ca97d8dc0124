"""Where a study's rows lie: one Parquet file a chunk, written so that none is lost or half there.

A chunk's file is written under another name, flushed to the disk and then renamed; its name holds
the checksum of its bytes. So a process may be killed at any instant: a chunk is there complete or
not at all, and what a failing disk has changed is found and made again.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import provenance
from multilift.errors import MissingExtraError, OutputError
from multilift.storage import LOCK, as_output_error, held, write_whole
from multilift.study.rows import Chunk
from multilift.study.spec import Study

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    raise MissingExtraError("pyarrow", "study", "multilift study") from None

MANIFEST = "study.json"
ROWS = "rows"
_PART = re.compile(r"chunk-(\d{7,})\.([0-9a-f]{32})\.parquet")

#: What made the rows; a study is not continued by another version, which may round differently.
SAME = ("multilift", "commit", "compiler", "machine", "isa")


class Store:
    """The folder of one study, held by one process at a time; made by `open_store`.

    Attributes:
        folder: of the study.
        study: whose rows it holds.
        chunk: worlds in each part, the last one excepted.
        damaged: parts that were found changed and were removed.
    """

    def __init__(self, folder: Path, study: Study, chunk: int) -> None:
        self.folder = folder
        self.study = study
        self.chunk = chunk
        self.damaged: list[str] = []
        self._parts: dict[int, Path] = {}

    @property
    def chunks(self) -> int:
        """How many chunks the study has."""
        return -(-self.study.worlds // self.chunk)

    @property
    def finished(self) -> int:
        """How many of them are on the disk."""
        return len(self._parts)

    def missing(self) -> list[int]:
        """Numbers of the chunks that are not there yet."""
        return [k for k in range(self.chunks) if k not in self._parts]

    def range(self, number: int) -> tuple[int, int]:
        """First world of a chunk, and the one after its last."""
        return number * self.chunk, min((number + 1) * self.chunk, self.study.worlds)

    def write(self, chunk: Chunk) -> None:
        """Adds a chunk's rows.

        Raises:
            OutputError: if they cannot be written; what was there stays.
        """
        number = chunk.start // self.chunk
        sink = pa.BufferOutputStream()
        pq.write_table(chunk.table, sink, compression="zstd", compression_level=1)
        content = sink.getvalue()
        name = f"chunk-{number:07d}.{_checksum(memoryview(content))}.parquet"
        write_whole(self.folder / ROWS / name, memoryview(content))
        self._parts[number] = self.folder / ROWS / name

    def find_parts(self) -> None:
        """Takes stock: verifies every part, removes leftovers and what is damaged."""
        self._parts.clear()
        for leftover in self.folder.rglob(".tmp-*"):
            leftover.unlink()
        for file in sorted((self.folder / ROWS).iterdir()):
            match = _PART.fullmatch(file.name)
            if match is None:
                continue
            number = int(match[1])
            good = number < self.chunks and _file_checksum(file) == match[2]
            if good and number not in self._parts:
                self._parts[number] = file
                continue
            if not good:
                self.damaged.append(file.name)
            file.unlink()

    def column(self, name: str) -> NDArray[Any]:
        """A column of all rows, shape (laws, worlds); outcomes as places in ``Study.outcomes``."""
        laws = len(self.study.controllers)
        pieces = []
        for number in range(self.chunks):
            values = pq.read_table(self._parts[number], columns=[name]).column(0).combine_chunks()
            if name == "outcome":
                names = values.dictionary.to_pylist()
                codes = np.array([self.study.outcomes.index(t) for t in names], "i1")
                array = codes[values.indices.to_numpy()]
            else:
                array = values.to_numpy()
            pieces.append(array.reshape(laws, -1))
        return np.concatenate(pieces, axis=1)


@contextmanager
def open_store(
    folder: Path, study: Study, *, chunk: int | None = None, force: bool = False,
    default_chunk: int = 8192,
) -> Iterator[Store]:  # fmt: skip
    """Begins a study's folder, or takes it up where it was left.

    Args:
        folder: made if it is not there.
        study: whose rows it shall hold.
        chunk: worlds a part; None for the folder's, or `default_chunk` in a new one.
        force: remove an earlier result there.
        default_chunk: see `chunk`.

    Raises:
        OutputError: if the folder is somebody else's, in use, of another study, or unwritable.
    """
    _check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with held(folder):
            if force:
                _clear(folder)
            chunk = _begin(folder, study, chunk, default_chunk)
            store = Store(folder, study, chunk)
            store.find_parts()
            yield store
    except OSError as error:
        raise as_output_error(error, folder) from error


def _check_folder(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder} is a file, not a folder\n  what to do: choose another")
    if folder.exists() and not (folder / MANIFEST).is_file():
        left = [f.name for f in folder.iterdir() if f.name not in (LOCK, ROWS)
                and not f.name.startswith(".tmp-")]  # fmt: skip
        rows = list((folder / ROWS).iterdir()) if (folder / ROWS).is_dir() else []
        if left or rows:
            raise OutputError(
                f"{folder} is not empty and holds no study, so it is not touched\n"
                "  what to do: choose another folder"
            )
    parent = folder
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not os.access(parent, os.W_OK):
        raise OutputError(f"{folder} cannot be made: {parent} is not a folder one may write to")


def _clear(folder: Path) -> None:
    """Removes everything but the lock; the manifest last, which says that the folder is ours."""
    for entry in sorted(folder.iterdir(), key=lambda e: e.name == MANIFEST):
        if entry.name == LOCK:
            continue
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        else:
            entry.unlink()


def _begin(folder: Path, study: Study, chunk: int | None, default_chunk: int) -> int:
    (folder / ROWS).mkdir(exist_ok=True)
    made_by = {k: v for k, v in provenance.describe().items() if k in SAME}
    if not (folder / MANIFEST).is_file():
        chunk = min(chunk or default_chunk, study.worlds)
        manifest = {
            "study": study.name,
            "digest": study.digest(),
            "worlds": study.worlds,
            "controllers": study.controllers,
            "chunk": chunk,
            "made_by": made_by,
        }
        write_whole(folder / MANIFEST, (json.dumps(manifest, indent=2) + "\n").encode())
        return chunk
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        stored = int(manifest["chunk"])
        digest, before = manifest["digest"], manifest["made_by"]
    except (ValueError, KeyError, TypeError):
        raise OutputError(
            f"{folder / MANIFEST} cannot be read\n"
            "  what to do: choose another folder, or begin anew with --force"
        ) from None
    advice = "\n  what to do: choose another folder, or replace what is there with --force"
    if digest != study.digest():
        raise OutputError(
            f"{folder} holds rows of another study: {manifest['study']!r} of "
            f"{manifest['worlds']} worlds was begun there, with other values, draws or laws{advice}"
        )
    if before != made_by:
        changed = [f"{k} was {before.get(k)}, is {made_by.get(k)}"
                   for k in SAME if before.get(k) != made_by.get(k)]  # fmt: skip
        raise OutputError(
            f"{folder} was begun by another multilift or machine ({'; '.join(changed)}), whose "
            f"rows may differ in their last bits{advice}"
        )
    if chunk is not None and min(chunk, study.worlds) != stored:
        raise OutputError(
            f"{folder} was begun with chunks of {stored} worlds\n"
            "  what to do: leave --chunk out to go on, or begin anew with --force"
        )
    return stored


def _checksum(content: memoryview) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def _file_checksum(file: Path) -> str:
    digest = hashlib.blake2b(digest_size=16)
    with file.open("rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
