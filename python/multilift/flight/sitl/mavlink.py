"""pymavlink with the messages that the physics speaks, where it is installed."""

from __future__ import annotations

from typing import Any

from multilift.errors import MissingExtraError

#: The physics' own ids on the wire: those of a simulator beside an autopilot.
SYSTEM, COMPONENT = 252, 1


def dialect() -> Any:
    """The module of the common messages, MAVLink 2.

    Raises:
        MissingExtraError: where pymavlink is not installed.
    """
    try:
        from pymavlink.dialects.v20 import common  # noqa: PLC0415 - an extra
    except ImportError:
        raise MissingExtraError("pymavlink", "fly", "speaking MAVLink") from None
    return common


def parser() -> Any:
    """A coder and decoder that passes over what it cannot read."""
    mav = dialect().MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
    mav.robust_parsing = True
    return mav
