"""The reproduction report: one self-contained page from plain data.

Fill the dataclasses of `multilift.report.contents` and call `render`. The page loads nothing from
anywhere: style, scripts, figures and the data behind the animation are inside the one file.
"""

from multilift.report.contents import (
    Body,
    Claim,
    Command,
    Discrepancy,
    Figure,
    FileInfo,
    Geometry,
    MetricInfo,
    Page,
    PaperTest,
    Push,
    PushShape,
    RunView,
    Sensitivity,
    Series,
    Verdict,
)
from multilift.report.page import render
from multilift.styles import DESIRED_STYLE, LawStyle, law_styles

__all__ = [
    "DESIRED_STYLE",
    "Body",
    "Claim",
    "Command",
    "Discrepancy",
    "Figure",
    "FileInfo",
    "Geometry",
    "LawStyle",
    "MetricInfo",
    "Page",
    "PaperTest",
    "Push",
    "PushShape",
    "RunView",
    "Sensitivity",
    "Series",
    "Verdict",
    "law_styles",
    "render",
]
