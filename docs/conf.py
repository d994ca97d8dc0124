"""The documentation's build: ``sphinx-build -W -n -b html docs docs/_build/html``, offline."""

import re
import sys
from pathlib import Path

import multilift

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "multilift"
copyright = "The multilift developers"
release = version = multilift.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "offline_math",
    "scenario_reference",
    "flight_reference",
]
exclude_patterns = ["_build", "generated"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = "multilift"
html_static_path = ["_static"]
html_css_files = ["multilift.css"]
html_math_renderer = "offline"
html_copy_source = False
html_show_copyright = False
pygments_style = "default"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_attr_annotations = False
# Other people's types are named, not linked: links would need their inventories.
nitpick_ignore_regex = [
    ("py:.*", r"(np|numpy|pd|pandas|matplotlib|pathlib|collections|typing|types)\..*"),
    ("py:.*", r"(NDArray|Path|Figure|SimpleNamespace|Vector|Callable|Sequence|Mapping|Law)"),
    ("py:.*", r"(ModuleType|Columns|Steps|View|Limits|Move)"),
]


def keep_bars(*arguments):
    """A docstring's |theta1| is a size, not a substitution."""
    lines = arguments[-1]
    lines[:] = [line.replace("|", r"\|") for line in lines]


def shorten(app, what, *arguments):
    """Classes by name alone, their attributes follow; arrays without what NumPy adds to them."""
    array = r"~?numpy\.ndarray\[tuple\[.*?float64\]\]"
    if what == "class":
        return "", None
    return tuple(text and re.sub(array, "NDArray", text) for text in arguments[-2:])


def setup(app):
    app.connect("autodoc-process-docstring", keep_bars)
    app.connect("autodoc-process-signature", shorten)
