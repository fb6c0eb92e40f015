"""Symbols in running text as they are written: z_c with its c below. What is code stays as it is typed."""

import re

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

_SYMBOL = re.compile(r"\b([A-Za-z])_(c|f|k|p|w|max|\d)\b")
_TYPED = (
    nodes.literal,
    nodes.FixedTextElement,
    nodes.math,
    nodes.math_block,
    nodes.raw,
    nodes.comment,
    nodes.strong,  # names of parameters
    addnodes.desc_signature,
)


class Subscripts(SphinxTransform):
    """Put what follows the underscore of a symbol into a subscript."""

    default_priority = 860  # after quotes are made curly, before titles are collected

    def apply(self) -> None:
        """Go through the texts of a page."""
        for text in list(self.document.findall(nodes.Text)):
            if not _SYMBOL.search(text) or _within(text, _TYPED):
                continue
            pieces: list[nodes.Node] = []
            end = 0
            for found in _SYMBOL.finditer(text):
                below = nodes.subscript("", found[2])
                pieces += [nodes.Text(text[end : found.end(1)]), below]
                end = found.end()
            text.parent.replace(text, [*pieces, nodes.Text(text[end:])])


def _within(node: nodes.Node, kinds: tuple[type[nodes.Node], ...]) -> bool:
    parent = node.parent
    while parent is not None:
        if isinstance(parent, kinds):
            return True
        parent = parent.parent
    return False


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the transform."""
    app.add_transform(Subscripts)
    return {"parallel_read_safe": True}
