"""What `multilift.limit` raises, and the packages that it asks for."""

from __future__ import annotations

from typing import Any

from multilift.errors import MissingExtraError, MultiliftError


class LimitError(MultiliftError):
    """No bound was found: the limits leave no way, or the search did not converge."""


def casadi() -> Any:
    """The package CasADi.

    Raises:
        MissingExtraError: without it (``multilift[limit]``).
    """
    try:
        import casadi as ca  # noqa: PLC0415 - an extra
    except ImportError:
        raise MissingExtraError("casadi", "limit", "a move's physical bound") from None
    return ca
