"""Which nodes of a syntax tree may be changed: no text for readers, no types, no imports."""

import ast
from collections.abc import Iterator
from typing import Any

__all__ = ["WITHOUT_EFFECT", "called", "visited"]

TYPES = {"Annotated", "Callable", "ClassVar", "Literal", "Optional", "TypeAlias", "Union"}
TALK = {"cast", "debug", "getLogger", "info", "NewType", "TypeVar", "warn"}
NAMES_FOR_READERS = {"__all__", "__slots__", "__version__"}
WITHOUT_EFFECT = {"flush", "help", "stacklevel", "strict"}
"""Keywords for readers and for what cannot happen."""
KERNELS = {"allocating", "compiled", "formula", "merged", "njit", "overload"}


def visited(node: ast.AST, compiled: bool = False) -> Iterator[tuple[ast.AST, bool]]:
    """Nodes that may be changed, and whether each belongs to a function that numba compiles."""
    if isinstance(node, ast.FunctionDef):
        marks = {name.id for mark in node.decorator_list for name in ast.walk(mark) if isinstance(name, ast.Name)}
        for outside in (*node.decorator_list, *node.args.defaults, *filter(None, node.args.kw_defaults)):
            yield from visited(outside, compiled)
        compiled = compiled or bool(marks & KERNELS)
        children: list[Any] = list(node.body)
    else:
        children = _parts(node)
    if not _is_left_alone(node):
        yield node, compiled
        for child in children:
            yield from visited(child, compiled)


def called(node: ast.expr) -> str:
    """The last name of what is called: "c" of ``a.b.c()``."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _is_left_alone(node: ast.AST) -> bool:
    match node:
        case ast.Import() | ast.ImportFrom() | ast.JoinedStr() | ast.Expr(value=ast.Constant()):
            return True
        case ast.Assign(targets=[ast.Name(id=name)]) | ast.AnnAssign(target=ast.Name(id=name)):
            return name in NAMES_FOR_READERS
        case ast.Subscript(value=value):
            return called(value) in TYPES
        case ast.Expr(value=ast.Call(func=function)) | ast.Call(func=function):
            return called(function) in TALK
        case ast.If(test=test):
            names = {name.id for name in ast.walk(test) if isinstance(name, ast.Name)}
            return bool(names & {"TYPE_CHECKING", "__name__"})
    return False


def _parts(node: ast.AST) -> list[Any]:
    """Children that may be changed."""
    match node:
        case ast.Raise():
            return []
        case ast.AnnAssign():
            return [node.target, *([node.value] if node.value else [])]
        case ast.Assert():
            return [node.test]
        case ast.Lambda():
            return [*node.args.defaults, *filter(None, node.args.kw_defaults), node.body]
        case ast.Call(func=ast.Name(id="isinstance" | "issubclass"), args=[value, _]):
            return [value]
        case ast.Call():
            return [node.func, *node.args, *(each for each in node.keywords if each.arg not in WITHOUT_EFFECT)]
        case ast.Compare():  # the order of a collection that is searched has no meaning
            lists = (ast.List, ast.Set, ast.Tuple)
            found = [
                other
                for operator, other in zip(node.ops, node.comparators, strict=True)
                if not (isinstance(operator, ast.In | ast.NotIn) and isinstance(other, lists))
            ]
            return [node.left, *found]
    return list(ast.iter_child_nodes(node))
