"""The one family of errors that multilift raises on purpose.

Each message names what was wrong where, what is permitted and what to do about it.
"""

from __future__ import annotations

from typing import Any


class MultiliftError(Exception):
    """Base of every error that multilift raises on purpose; the command line exits with 2."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Errors travel between processes as they are, whatever their constructors take."""
        return _rebuilt, (type(self), self.args, self.__dict__)


class ScenarioError(MultiliftError, ValueError):
    """A scenario that cannot be meant: unknown key, wrong type, value out of range, geometry.

    Attributes:
        where: file, or a description of where the scenario came from.
        key: dotted key, such as ``plant.bar_mass``; empty where no single key is to blame.
    """

    def __init__(
        self,
        problem: str,
        *,
        where: str,
        key: str = "",
        value: object = None,
        permitted: str = "",
        advice: str = "",
    ) -> None:
        self.where = where
        self.key = key
        subject = f"{key} = {value!r}" if key and value is not None else key
        lines = [f"{where}: " + (f"{subject}: {problem}" if subject else problem)]
        if permitted:
            lines.append(f"  permitted: {permitted}")
        if advice:
            lines.append(f"  what to do: {advice}")
        super().__init__("\n".join(lines))


class ControllerError(MultiliftError):
    """A control law that cannot be found, loaded or stepped."""


class PlanningError(MultiliftError, ValueError):
    """Numbers from which no move can be planned."""

    def __init__(self, problem: str, permitted: str) -> None:
        super().__init__(f"{problem}\n  permitted: {permitted}")


class OutputError(MultiliftError, OSError):
    """A place to write to that is taken, unwritable or not ours to replace."""


class MissingExtraError(MultiliftError, ImportError):
    """An optional part of multilift is used but its packages are not installed."""

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        super().__init__(
            f"{purpose} needs the package {package}, which is not installed.\n"
            f"  what to do: pip install 'multilift[{extra}]'"
        )


def _rebuilt(kind: type[MultiliftError], args: Any, attributes: Any) -> MultiliftError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(attributes)
    return error
