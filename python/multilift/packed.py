"""Columns and texts as the self-contained pages carry them: compact, and harmless inside HTML.

packed.js beside this file unpacks the columns again.
"""

from __future__ import annotations

import json
import math
import re
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray


def stride_of(records: int, max_points: int) -> int:
    """Every how many records to take so that about max_points are left."""
    return max(1, math.ceil((records - 1) / max_points))


def thinned(column: NDArray[np.float64], stride: int) -> NDArray[np.float64]:
    """Every stride-th record and the last."""
    picked = column[::stride]
    return picked if (len(column) - 1) % stride == 0 else np.append(picked, column[-1])


def encoded(column: NDArray[np.float64], diverged: bool) -> dict[str, Any]:
    """A column as compact JSON, to six digits of its largest value, or of each if it diverged.

    One of {"c": x, "n": count}, a constant; {"p": p, "d": [...]}, whole numbers of which the
    running sum over 10**p is the column; {"v": [...]}, the numbers themselves with null for what
    is not finite.
    """
    if np.all(column == column[0]) and math.isfinite(column[0]):
        return {"c": float(f"{column[0]:.6g}"), "n": len(column)}
    largest = float(np.max(np.abs(column)))  # NaN if there is one
    p = 5 - math.floor(math.log10(largest)) if math.isfinite(largest) else 0
    if diverged or not math.isfinite(largest) or abs(p) > 200:
        return {"v": [float(f"{x:.6g}") if math.isfinite(x) else None for x in column]}
    whole = np.rint(column * 10.0**p).astype(np.int64)
    return {"p": p, "d": np.diff(whole, prepend=0).tolist()}


def safe_json(value: Any) -> str:
    """JSON without a character that means something to HTML."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def script(text: str) -> str:
    """A script's source such that it cannot end the script element around it."""
    return re.sub(r"</(?=script)", r"<\\/", text, flags=re.IGNORECASE)


def resource(package: str, name: str) -> str:
    """A text file that lies in a package."""
    return resources.files(package).joinpath(name).read_text("utf-8")
