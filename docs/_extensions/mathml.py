"""Formulas as MathML, which browsers draw themselves: a page needs no script and no network."""

from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata
from sphinx.writers.html5 import HTML5Translator

__all__ = ["setup"]


def setup(app: Sphinx) -> ExtensionMetadata:
    """Add the renderer, which is the one that the site uses."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}


NAMESPACE = "http://www.w3.org/1998/Math/MathML"
ElementTree.register_namespace("", NAMESPACE)


def _drawn(formula: str, *, as_block: bool = False) -> str:
    """MathML, with the index of an accented letter beside it, where docutils puts it below."""
    root = ElementTree.fromstring(latex2mathml.tex2mathml(formula, as_block=as_block))
    for stack in root.iter(f"{{{NAMESPACE}}}munderover"):
        letter, index, accent = stack
        if accent.text == "ˆ":
            stack[:] = [ElementTree.Element(f"{{{NAMESPACE}}}mover"), index]
            stack[0].extend([letter, accent])
            stack.tag = f"{{{NAMESPACE}}}msub"
    return ElementTree.tostring(root, encoding="unicode")


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(_drawn(node.astext()))
    raise nodes.SkipNode


def _display(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="formula">{_drawn(node.astext(), as_block=True)}</div>')
    raise nodes.SkipNode
