"""TOML as people would write it: short lists in one line, every bit of a number kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def inline(value: Any) -> str:
    """A value in one line; numbers keep every bit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
        return f'"{escaped}"'
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} = {inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(inline, value)) + "]"
    return repr(value)


def document(tables: Mapping[str, Any], prefix: str = "") -> str:
    """Whole tables, each under its own heading; lists of tables in one line."""
    own = {k: v for k, v in tables.items() if not isinstance(v, Mapping)}
    text = "".join(f"{k} = {inline(v)}\n" for k, v in own.items())
    if prefix and (own or not tables):
        text = f"\n[{prefix}]\n{text}"
    for key, value in tables.items():
        if isinstance(value, Mapping):
            text += document(value, f"{prefix}.{key}" if prefix else key)
    return text
