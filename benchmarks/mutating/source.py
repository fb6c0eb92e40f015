"""A module's text, its syntax tree, and the stretch of text of every node."""

import ast
from functools import cached_property, lru_cache

__all__ = ["Source", "same_code"]

Node = ast.expr | ast.stmt | ast.keyword


class Source:
    """The text of a module.

    Parameters
    ----------
    text : bytes
        In UTF-8: positions of the syntax tree count bytes.
    """

    def __init__(self, text: bytes) -> None:
        self.text = text
        self.tree = ast.parse(text)

    @cached_property
    def fields(self) -> dict[str, list[str]]:
        """What is read of each name in the module, sorted, but for modules and methods."""
        modules = {
            alias.asname or alias.name
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Import | ast.ImportFrom)
            for alias in node.names
        }
        methods = {id(node.func) for node in ast.walk(self.tree) if isinstance(node, ast.Call)}
        found: dict[str, set[str]] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Attribute) and id(node) not in methods and isinstance(node.value, ast.Name):
                found.setdefault(node.value.id, set()).add(node.attr)
        return {name: sorted(fields) for name, fields in found.items() if name not in modules}

    @cached_property
    def _begins(self) -> list[int]:
        begins = [0]
        for line in self.text.splitlines(keepends=True):
            begins.append(begins[-1] + len(line))
        return begins

    def begin(self, node: Node) -> int:
        """Where a node begins."""
        return self._begins[node.lineno - 1] + node.col_offset

    def end(self, node: Node) -> int:
        """Where a node ends; parentheses around it are not part of it."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self._begins[node.end_lineno - 1] + node.end_col_offset

    def of(self, node: Node) -> bytes:
        """The text of a node."""
        return self.text[self.begin(node) : self.end(node)]

    def line(self, position: int) -> int:
        """The number of the line at a position, from 1."""
        return self.text.count(b"\n", 0, position) + 1

    def lines(self, begin: int, end: int) -> tuple[int, int]:
        """Where the whole lines begin and end that hold a stretch."""
        first = self.text.rfind(b"\n", 0, begin) + 1
        last = self.text.find(b"\n", end)
        return first, len(self.text) if last < 0 else last


def same_code(one: bytes, other: bytes) -> bool:
    """Whether two texts compile to the same instructions; False if the second does not compile."""
    try:
        changed = compile(other, "module", "exec")
    except SyntaxError:
        return False
    return _meaning_of(one) == _meaning(changed)


@lru_cache(maxsize=256)
def _meaning_of(text: bytes) -> object:
    return _meaning(compile(text, "module", "exec"))


def _meaning(value: object) -> object:
    """What of code is not its place; constants by type, since 1 and True are equal."""
    if isinstance(value, type(same_code.__code__)):
        names = (value.co_name, value.co_names, value.co_varnames, value.co_freevars, value.co_cellvars)
        counts = (value.co_flags, value.co_argcount, value.co_posonlyargcount, value.co_kwonlyargcount)
        return value.co_code, value.co_exceptiontable, names, counts, _meaning(value.co_consts)
    if isinstance(value, tuple):
        return tuple(_meaning(part) for part in value)
    return type(value), repr(value)
