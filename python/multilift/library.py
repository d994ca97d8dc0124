"""The scenarios and studies that multilift ships."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from multilift.errors import ScenarioError

_PACKAGE = Path(__file__).resolve().parent


def folder(kind: str = "scenarios") -> Path:
    """Where the shipped files lie: in the package, or in the checkout beside it."""
    installed = _PACKAGE / kind
    return installed if installed.is_dir() else _PACKAGE.parents[1] / kind


def files() -> list[Path]:
    """The shipped scenario files, by name."""
    return sorted(folder().glob("*.toml"))


def tuned() -> list[Path]:
    """The shipped scenarios with tuned gains, by name; see ``docs/tuning``."""
    return sorted((folder() / "tuned").glob("*.toml"))


def studies() -> list[Path]:
    """The shipped study files, by name."""
    return sorted(folder("studies").glob("*.toml"))


def tunings() -> list[Path]:
    """The shipped tuning files, by name."""
    return sorted(folder("tunings").glob("*.toml"))


def find(path: str | Path) -> Path:
    """The file at `path`, or the shipped scenario of that name.

    Raises:
        ScenarioError: if there is neither.
    """
    return _find(path, [*files(), *tuned()], "'multilift scenarios' lists what is shipped")


def find_study(path: str | Path) -> Path:
    """The file at `path`, or the shipped study of that name.

    Raises:
        ScenarioError: if there is neither.
    """
    return _find(path, studies(), "'multilift study --list' lists what is shipped")


def find_tuning(path: str | Path) -> Path:
    """The file at `path`, or the shipped tuning of that name.

    Raises:
        ScenarioError: if there is neither.
    """
    return _find(path, tunings(), "'multilift tune --list' lists what is shipped")


def read(file: Path, where: str) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises:
        ScenarioError: if it cannot be read or is not TOML.
    """
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"cannot be read: {error}", where=where) from None
    except RecursionError:
        raise ScenarioError("is nested too deeply", where=where) from None
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(
            f"is not valid TOML: {error}", where=where, advice="mend the line named"
        ) from None


def _find(path: str | Path, shipped_files: list[Path], advice: str) -> Path:
    file = Path(path)
    if file.is_file():
        return file
    shipped = {f.stem: f for f in shipped_files}
    if str(path) in shipped:
        return shipped[str(path)]
    raise ScenarioError(
        "is a folder, not a file" if file.is_dir() else "does not exist",
        where=str(path),
        permitted="a TOML file, or a shipped name: " + ", ".join(shipped),
        advice=advice,
    )
