"""The key that signs messages, and the clock of signatures."""

from __future__ import annotations

import stat
from pathlib import Path
from typing import Any

from multilift.errors import ScenarioError

#: 2015-01-01 in Unix time, s: where the time of signatures begins.
_EPOCH = 1_420_070_400

_KEY = 32


def read_key(file: Path, where: str) -> bytes:
    """The 32 bytes of a key file, which may also give them as hexadecimal digits.

    Raises:
        ScenarioError: if it cannot be read, holds no key, or others may read it.
    """

    def fail(problem: str, advice: str) -> ScenarioError:
        return ScenarioError(problem, where=where, key="security.key_file", value=str(file),
                             permitted="32 bytes or 64 hexadecimal digits",
                             advice=advice)  # fmt: skip

    try:
        mode = file.stat().st_mode
        content = file.read_bytes()
    except (OSError, ValueError) as error:
        raise fail(f"cannot be read: {error}", "make one: openssl rand -hex 32 > FILE") from None
    if mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise fail("may be read by others", f"chmod 600 {file}")
    if len(content) == _KEY:
        return content
    try:
        key = bytes.fromhex(content.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != _KEY:
        raise fail("holds no key", "make one: openssl rand -hex 32 > FILE")
    return key


def signature_time(unix: float) -> int:
    """The time that signatures carry, 10 us since 2015."""
    return int((unix - _EPOCH) * 1e5)


def sign_with(encoder: Any, key: bytes, unix: float) -> None:
    """Makes a pymavlink encoder sign everything from now on.

    Args:
        encoder: a ``MAVLink``.
        key: 32 bytes.
        unix: the time, s; must be beyond every signature that was ever sent with this key.
    """
    encoder.signing.secret_key = key
    encoder.signing.timestamp = signature_time(unix)
    encoder.signing.sign_outgoing = True
