"""Numbers and sentences as readers see them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from markupsafe import Markup, escape

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MINUS = "−"
_NO_VALUE = "–"


def is_value(x: float | None) -> bool:
    """Whether there is a number, infinity included."""
    return x is not None and not math.isnan(x)


def _power_of_ten(x: float, digits: int) -> str:
    mantissa, exponent = f"{x:.{digits}e}".split("e")
    return f"{mantissa}×10{str(int(exponent)).translate(_SUPERSCRIPT)}"


def number(x: float | None, digits: int) -> str:
    """A number with fixed decimals; powers of ten where those would show only zeros."""
    if x is None or math.isnan(x):
        return _NO_VALUE
    if math.isinf(x):
        return "∞" if x > 0 else f"{_MINUS}∞"
    text = f"{x:.{digits}f}"
    if float(text) == 0.0:
        text = f"{0.0:.{digits}f}" if x == 0.0 else _power_of_ten(x, 1)
    elif abs(x) >= 1e6:
        text = _power_of_ten(x, 3)
    return text.replace("-", _MINUS)


def change(x: float | None, base: float | None, digits: int) -> str:
    """The change from `base` to `x`, empty where it would say nothing."""
    if x is None or base is None or not (math.isfinite(x) and math.isfinite(base)):
        return ""
    if abs(base) < 5.0 * 10.0**-digits:
        return ""
    percent = round(100.0 * (x - base) / abs(base))
    if abs(percent) >= 1000:
        return ""
    if percent == 0:
        return "±0 %"
    return f"{'+' if percent > 0 else _MINUS}{abs(percent)} %"


def inline(text: str) -> Markup:
    """Escaped text in which `backticks` set code."""
    parts = str(escape(text)).split("`")
    if len(parts) % 2 == 0:  # an odd backtick is a character like any other
        parts[-2:] = ["`".join(parts[-2:])]
    return Markup(
        "".join(f"<code>{part}</code>" if k % 2 else part for k, part in enumerate(parts))
    )


def paragraphs(text: str) -> list[Markup]:
    """Escaped paragraphs of a text that blank lines divide."""
    return [inline(part.strip()) for part in re.split(r"\n\s*\n", text) if part.strip()]


def ordinal(n: int) -> str:
    """1st, 2nd, 3rd, 4th, ..."""
    if n % 100 in (11, 12, 13):
        return f"{n}th"
    return f"{n}{ {1: 'st', 2: 'nd', 3: 'rd'}.get(n % 10, 'th') }"


def listed(items: Sequence[str]) -> str:
    """Items in a sentence: a, b and c."""
    return ", ".join(items) if len(items) < 2 else ", ".join(items[:-1]) + " and " + items[-1]
