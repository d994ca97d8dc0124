"""The name, colour and line of each law, the same in every figure and page.

The paper's: proposed law blue and solid, PD red and dashed. Shades from Okabe and Ito, which the
colour-blind tell apart; dashes tell them apart in grey print.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class LawStyle:
    """How a law's curves look: colour, and a dash pattern in pixels, empty for a solid line."""

    color: str
    dashes: tuple[float, ...]


#: The paper's laws as readers should see them; another law goes by its title.
LAW_LABELS = {"energy_coupled": "energy-coupled", "pd": "PD"}

DESIRED_STYLE = LawStyle("#000000", (4.0, 3.0))
_KNOWN_STYLES = {
    "pd": LawStyle("#D55E00", (7.0, 3.0)),
    "energy_coupled": LawStyle("#0072B2", ()),
}
_FURTHER_STYLES = (
    LawStyle("#009E73", (9.0, 3.0, 2.0, 3.0)),
    LawStyle("#CC79A7", (12.0, 3.0)),
    LawStyle("#7A6A00", (5.0, 2.0, 2.0, 2.0, 2.0, 2.0)),
    LawStyle("#56B4E9", (3.0, 2.0)),
)


def law_styles(names: Sequence[str]) -> dict[str, LawStyle]:
    """Assigns each law its colour and line.

    Args:
        names: Laws in order of appearance; repetitions are fine.

    Returns:
        A style for each name. Beyond four laws without a style of their own, styles repeat.
    """
    styles: dict[str, LawStyle] = {}
    further = 0
    for name in names:
        if name in styles:
            continue
        if name in _KNOWN_STYLES:
            styles[name] = _KNOWN_STYLES[name]
        else:
            styles[name] = _FURTHER_STYLES[further % len(_FURTHER_STYLES)]
            further += 1
    return styles
