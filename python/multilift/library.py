"""The scenarios that multilift ships."""

from __future__ import annotations

from pathlib import Path

from multilift.errors import ScenarioError

_PACKAGE = Path(__file__).resolve().parent


def folder() -> Path:
    """Where the shipped scenario files lie: in the package, or in the checkout beside it."""
    installed = _PACKAGE / "scenarios"
    return installed if installed.is_dir() else _PACKAGE.parents[1] / "scenarios"


def files() -> list[Path]:
    """The shipped scenario files, by name."""
    return sorted(folder().glob("*.toml"))


def find(path: str | Path) -> Path:
    """The file at `path`, or the shipped scenario of that name.

    Raises:
        ScenarioError: if there is neither.
    """
    file = Path(path)
    if file.is_file():
        return file
    shipped = {f.stem: f for f in files()}
    if str(path) in shipped:
        return shipped[str(path)]
    raise ScenarioError(
        "is a folder, not a file" if file.is_dir() else "does not exist",
        where=str(path),
        permitted="a TOML file, or a shipped name: " + ", ".join(shipped),
        advice="'multilift scenarios' lists what is shipped",
    )
