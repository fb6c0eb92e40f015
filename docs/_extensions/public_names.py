"""The API reference: every name of a package's ``__all__``, where a page has ``<!-- public names: PACKAGE -->``.

A name is documented where it is first public, `stickslip` before its subpackages; packages that pass it on refer to it
there. Docstrings name things in backticks: what the reference has becomes a link, and what it has not stays code.
"""

import ast
import inspect
import os
import re
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.pycode import ModuleAnalyzer
from sphinx.util.nodes import make_refnode
from sphinx.util.typing import ExtensionMetadata

__all__ = ["setup"]

PAGES = Path(__file__).parents[1] / "reference"
MARK = re.compile(r"^<!-- public names: ([\w.]+) -->$", re.MULTILINE)


def setup(app: Sphinx) -> ExtensionMetadata:
    """Fill the pages in as they are read, and keep what is no docstring out of them."""
    app.connect("source-read", _fill_in)
    app.connect("autodoc-process-docstring", _as_rest, priority=1)
    app.connect("autodoc-skip-member", _skip)
    app.connect("missing-reference", _resolve)
    app.connect("doctree-resolved", _number_sources)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _fill_in(_app: Sphinx, _document: str, source: list[str]) -> None:
    source[0] = MARK.sub(lambda mark: _reference(mark[1]), source[0])


def _reference(package: str) -> str:
    module = import_module(package)
    names = sorted((name for name in module.__all__ if not name.startswith("__")), key=lambda name: _rank(module, name))
    homes = {name: _first_public(module, name) for name in names}
    passed_on = [name for name in names if homes[name] != f"{package}.{name}"]
    lines = ["```{eval-rst}", f".. py:module:: {package}", ""]
    for name in passed_on:
        lines += [f".. py:data:: {name}", "   :no-typesetting:", ""]
    if passed_on:
        links = ", ".join(f":py:obj:`{name} <{homes[name]}>`" for name in passed_on)
        lines += [f"Here too, and described where the link goes: {links}.", ""]
    lines += [_block(module, name) for name in names if name not in passed_on]
    return "\n".join([*lines, "```"])


def _rank(module: ModuleType, name: str) -> tuple[int, str]:
    """Functions, classes, then what is neither, by name."""
    thing = getattr(module, name)
    return (0 if inspect.isfunction(thing) else 1 if inspect.isclass(thing) else 2), name.lower()


def _block(module: ModuleType, name: str) -> str:
    kind = ("autofunction", "autoclass", "")[_rank(module, name)[0]]
    if kind:
        return f".. {kind}:: {module.__name__}.{name}\n"
    return f".. py:data:: {name}\n\n" + "".join(f"   {line}\n" if line else "\n" for line in _about(module, name))


def _first_public(module: ModuleType, name: str) -> str:
    """Where the same object is public first."""
    thing = getattr(module, name)
    for package in _packages():
        if package is not module and name in package.__all__ and getattr(package, name) is thing:
            return f"{package.__name__}.{name}"
        if package is module:
            break
    return f"{module.__name__}.{name}"


@cache
def _packages() -> list[ModuleType]:
    """Packages that pages have the names of, in alphabetical order, so that `stickslip` is the first."""
    pages = (page.read_text(encoding="utf-8") for page in PAGES.glob("*.md"))
    return [import_module(name) for name in sorted(mark for page in pages for mark in MARK.findall(page))]


def _about(module: ModuleType, name: str) -> Iterator[str]:
    """The text below an assignment, and the names that a table holds."""
    home = _home(module, name)
    for line in ModuleAnalyzer.for_module(home.__name__).find_attr_docs().get(("", name), []):
        yield _line_as_rest(line, ())
    yield ""
    thing = getattr(module, name)
    if isinstance(thing, Mapping):
        yield "Names: " + ", ".join(f"``{key!r}``" for key in thing) + "."
    elif isinstance(thing, tuple):
        yield f"``{thing!r}``"


def _home(module: ModuleType, name: str) -> ModuleType:
    """The module that assigns a name, followed through the imports of packages."""
    tree = ast.parse(inspect.getsource(module))
    for statement in ast.walk(tree):
        if isinstance(statement, ast.ImportFrom) and name in {each.name for each in statement.names}:
            return _home(import_module("." * statement.level + (statement.module or ""), module.__package__), name)
    return module


def _as_rest(_app: Sphinx, _what: str, _name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """What reST would misread: a docstring in Markdown, bars and trailing underscores, sources that stand elsewhere."""
    if lines and lines[0].startswith("## "):
        lines[:] = ["See :doc:`the environment's page </environment>`.", ""]
    sources = {mark for line in lines for mark in re.findall(r"^\.\. (\[\d\])", line)}
    lines[:] = [_line_as_rest(line, sources) for line in lines]


def _line_as_rest(line: str, sources: Collection[str]) -> str:
    line = re.sub(r"`docs/(\w+)\.md`", r":doc:`/\1`", line)
    line = re.sub(r"\|(\w+)\|", r"``|\1|``", line)  # no substitution
    line = re.sub(r"(?<=[( ])(\w+_)(?=[,)])", r"``\1``", line)  # no target, but scikit-learn's names
    line = re.sub(r"(?<![`:])(`\w+`)(?=\w)", r"\1\\ ", line)  # a plural
    return re.sub(r"(\[\d\])_", lambda mark: mark[0] if mark[1] in sources else mark[1], line)


def _skip(_app: Sphinx, _what: str, name: str, thing: Any, _skipped: bool, _options: Any) -> bool | None:
    """Fields of named tuples of which nothing is said, and methods that scikit-learn adds."""
    if (inspect.getdoc(thing) or "").startswith("Alias for field number"):
        return not any(name in told for told in _told_of_fields(thing, name))
    foreign = (getattr(thing, "__module__", None) or "stickslip").partition(".")[0] not in ("stickslip", "builtins")
    return True if foreign else None


def _told_of_fields(thing: Any, name: str) -> Iterator[set[str]]:
    """What is said of the fields of the named tuple that has this one."""
    for package in _packages():
        for each in (getattr(package, public) for public in package.__all__):
            if inspect.isclass(each) and vars(each).get(name) is thing:
                told = ModuleAnalyzer.for_module(each.__module__).find_attr_docs()
                yield {field for owner, field in told if owner == each.__qualname__}


def _resolve(
    app: Sphinx, environment: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.Node | None:
    """What backticks name: the object whose path ends with it, where it is public first, or plain code."""
    if node.get("refdomain") != "py" or node.get("reftype") not in ("obj", "data", "class", "func", "meth"):
        return None
    objects = environment.domains.python_domain.objects
    kinds = ("method", "property", "attribute") if "." in node["reftarget"] else ("class", "function", "data")
    ends = "." + node["reftarget"]
    found = [path for path in objects if path.endswith(ends) and objects[path].objtype in kinds]
    if found and app.builder.format == "html":
        path = min(found, key=len)
        return make_refnode(app.builder, node["refdoc"], objects[path].docname, objects[path].node_id, content, path)
    return content if node["reftype"] == "obj" or _is_internal(node["reftarget"]) else None


def _number_sources(_app: Sphinx, doctree: nodes.document, _document: str) -> None:
    """Sources have the numbers that docstrings give them, and not the names that tell those of a page apart."""
    for text in list(doctree.findall(nodes.Text)):
        number = re.fullmatch(r"(\[?)R[0-9a-f]{12}-(\d+)(\]?)", text)
        if number:
            text.parent.replace(text, nodes.Text("".join(number.groups())))


def _is_internal(path: str) -> bool:
    """Whether a module of the package defines such a name, though it is not public."""
    defined = re.compile(rf"^(?:class |def )?{path.partition('.')[0]}\b", re.MULTILINE)
    return any(defined.search(source) for source in _sources())


@cache
def _sources() -> list[str]:
    (folder,) = import_module("stickslip").__path__
    files = (Path(at) / file for at, _, found in os.walk(folder, followlinks=True) for file in found)
    return [file.read_text(encoding="utf-8") for file in files if file.suffix == ".py"]
