r"""Math as MathML, written at build time: a page needs no script, no font and no network.

Display equations take the paper's numbers: one labelled ``eq-57`` with ``\tag{57}`` prints (57) at
the margin, and the role ``{eq}`eq-57``` prints (57) and leads there.
"""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

logger = logging.getLogger(__name__)

TAG = re.compile(r"\s*\\tag\{([^{}]*)\}")


def apply_tags(app: Sphinx, doctree: nodes.document) -> None:
    """Numbers each tagged equation by its tag instead of by counting."""
    equations = app.env.get_domain("math").equations
    for node in doctree.findall(nodes.math_block):
        found = TAG.search(node.astext())
        if found is None:
            continue
        node["number"] = found[1]
        equations[node["label"]] = (app.env.docname, found[1])


def mathml(node: nodes.Element, display: str) -> str:
    """The node's LaTeX as MathML; a warning where the converter leaves LaTeX in it."""
    markup = convert(TAG.sub("", node.astext()), display=display)
    if "\\" in markup or "<mi>&</mi>" in markup:
        logger.warning("cannot be written as MathML: %s", node.astext(), location=node)
    return markup


def visit_inline(self, node: nodes.math) -> None:
    self.body.append(mathml(node, "inline"))
    raise nodes.SkipNode


def visit_display(self, node: nodes.math_block) -> None:
    self.body.append('<div class="equation">')  # furo's wrapper carries the node's id
    self.body.append(mathml(node, "block"))
    if number := node.get("number"):
        self.body.append(f'<a class="eqno" href="#{node["ids"][0]}">({number})</a>')
    self.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("doctree-read", apply_tags)
    app.add_html_math_renderer("offline", (visit_inline, None), (visit_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
