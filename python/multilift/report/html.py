"""What the offline pages share: how their templates are read, and figures inside them."""

from __future__ import annotations

import base64
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import jinja2


@dataclass(frozen=True)
class Image:
    """A PNG for a data URL, with its size in pixels, so that the page does not jump."""

    base64: str
    width: int
    height: int


def image(png: bytes) -> Image:
    """A PNG as a page holds it."""
    return Image(base64.b64encode(png).decode("ascii"), *struct.unpack(">II", png[16:24]))


def environment(
    filters: Mapping[str, Callable[..., Any]] | None = None, *, keep_trailing_newline: bool = False
) -> jinja2.Environment:
    """Escapes everything and refuses names that are not given.

    Args:
        filters: of the template, by name.
        keep_trailing_newline: the template's last one.
    """
    made = jinja2.Environment(
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=keep_trailing_newline,
    )
    made.filters |= filters or {}
    return made
