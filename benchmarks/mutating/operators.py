"""Faults that somebody could have made: each kind finds its places in the tree and changes the text there alone."""

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from textwrap import dedent

from .source import Node, Source
from .visiting import called, visited, WITHOUT_EFFECT

__all__ = ["OPERATORS", "Mutant", "mutants"]

Edit = tuple[int, int, bytes]  # begin, end, and what stands there instead


@dataclass(frozen=True)
class Mutant:
    """A module with one fault.

    Parameters
    ----------
    kind : str
        Key of `OPERATORS`.
    line : int
        Where it begins, from 1.
    begin, end : int
        The stretch that is changed, in bytes.
    text : bytes
        What stands there instead.
    before, after : str
        The whole lines without and with the fault.
    compiled : bool
        Whether numba compiles the function that it is in.
    """

    kind: str
    line: int
    begin: int
    end: int
    text: bytes
    before: str
    after: str
    compiled: bool

    def applied(self, text: bytes) -> bytes:
        """The module's text with the fault."""
        return text[: self.begin] + self.text + text[self.end :]


def mutants(text: bytes) -> list[Mutant]:
    """All faults of a module, in order of place; what does not compile is not among them."""
    source = Source(text)
    found: dict[Edit, Mutant] = {}
    for node, compiled in visited(source.tree):
        for kind, operator in OPERATORS.items():
            for begin, end, new in operator(source, node):
                first, last = source.lines(begin, end)
                lines = (text[first:last], text[first:begin] + new + text[end:last])
                before, after = (dedent(each.decode()).strip() for each in lines)
                mutant = Mutant(kind, source.line(begin), begin, end, new, before, after, compiled)
                if before != after:
                    found.setdefault((begin, end, new), mutant)
    return sorted(found.values(), key=lambda mutant: (mutant.begin, mutant.end, mutant.text))


COMPARISONS: dict[type[ast.cmpop], tuple[str, tuple[str, ...]]] = {
    ast.Lt: ("<", ("<=", ">")),
    ast.LtE: ("<=", ("<", ">=")),
    ast.Gt: (">", (">=", "<")),
    ast.GtE: (">=", (">", "<=")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
    ast.In: ("in", ("not in",)),
    ast.NotIn: (r"not\s+in", ("in",)),
    ast.Is: ("is", ("is not",)),
    ast.IsNot: (r"is\s+not", ("is",)),
}
ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "/"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
    ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
}
PAIRS = [
    ("min", "max"),
    ("minimum", "maximum"),
    ("amin", "amax"),
    ("nanmin", "nanmax"),
    ("argmin", "argmax"),
    ("mean", "sum"),
    ("any", "all"),
    ("floor", "ceil"),
    ("sin", "cos"),
]
TWINS = dict(PAIRS) | {second: first for first, second in PAIRS}
COMMUTATIVE = {
    "add",
    "and_",
    "fmax",
    "fmin",
    "gcd",
    "hypot",
    "logical_and",
    "logical_or",
    "multiply",
    "or_",
    *TWINS,
} - {"mean", "sum"}
INTROSPECTION = {"getattr", "hasattr", "isinstance", "issubclass", "setattr"}
FLOATS = {"empty", "linspace", "ones", "zeros"}  # dtype=float is their default


def comparison(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Compare):
        left: ast.expr = node.left
        for operator, right in zip(node.ops, node.comparators, strict=True):
            sign, others = COMPARISONS[type(operator)]
            pattern = rf"\b{sign}\b" if sign[0].isalpha() else re.escape(sign)
            for begin, end in _between(source, left, right, pattern):
                yield from ((begin, end, other.encode()) for other in others)
            left = right


def arithmetic(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield source.begin(node), source.begin(node) + 1, b""
    elif isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC and not _of_text(node.left, node.right):
        sign, other = ARITHMETIC[type(node.op)]
        for begin, end in _between(source, node.left, node.right, re.escape(sign)):
            yield begin, end, other.encode()
    elif isinstance(node, ast.AugAssign) and type(node.op) in ARITHMETIC and not _of_text(node.value):
        sign, other = ARITHMETIC[type(node.op)]
        for begin, end in _between(source, node.target, node.value, re.escape(sign + "=")):
            yield begin, end, f"{other}=".encode()


def logic(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.BoolOp):
        word, other = ("and", b"or") if isinstance(node.op, ast.And) else ("or", b"and")
        for left, right in _neighbours(node.values):
            for begin, end in _between(source, left, right, rf"\b{word}\b"):
                yield begin, end, other
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        begin = source.begin(node)
        space = re.compile(rb"not\s*").match(source.text, begin)
        assert space is not None
        yield begin, space.end(), b""


def condition(source: Source, node: ast.AST) -> Iterator[Edit]:
    tests: list[ast.expr] = []
    if isinstance(node, ast.If | ast.IfExp | ast.While):
        tests = [node.test]
    elif isinstance(node, ast.comprehension):
        tests = node.ifs
    for test in tests:
        negated_elsewhere = isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not)
        if isinstance(test, ast.Compare) and len(test.ops) == 1:
            negated_elsewhere = not isinstance(test.ops[0], ast.Lt | ast.LtE | ast.Gt | ast.GtE)
        if not negated_elsewhere and not isinstance(test, ast.Constant):
            yield source.begin(test), source.end(test), b"not (" + source.of(test) + b")"


def number(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        value = node.value
        assert isinstance(value, int | float)
        if isinstance(value, int):
            changed: float = {0: 1, 1: 0}.get(value, value + 1)
        else:
            changed = 2 * value if value else 1.0
        yield source.begin(node), source.end(node), repr(changed).encode()


def truth_value(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield source.begin(node), source.end(node), repr(not node.value).encode()


def keyword_dropped(source: Source, node: ast.AST) -> Iterator[Edit]:
    if not isinstance(node, ast.Call):
        return
    for keyword in node.keywords:
        is_default = keyword.arg == "dtype" and called(node.func) in FLOATS and called(keyword.value) == "float"
        if keyword.arg is None or keyword.arg in WITHOUT_EFFECT or is_default:
            continue
        begin, end = source.begin(keyword), source.end(keyword)
        others: list[Node] = [node.func, *node.args, *node.keywords]
        before = max(source.end(each) for each in others if source.end(each) <= begin)
        comma = source.text.rfind(b",", before, begin)
        if comma >= 0:
            yield comma, end, b""
        else:
            behind = re.compile(rb"\s*,?\s*").match(source.text, end)
            assert behind is not None
            yield begin, behind.end(), b""


def arguments_swapped(source: Source, node: ast.AST) -> Iterator[Edit]:
    if not isinstance(node, ast.Call):
        return
    if called(node.func) not in COMMUTATIVE | INTROSPECTION and not any(isinstance(a, ast.Starred) for a in node.args):
        factors_first = called(node.func) == "fma"
        yield from _swapped(source, node.args[factors_first:])
    for one, other in _neighbours([keyword.value for keyword in node.keywords if keyword.arg not in WITHOUT_EFFECT]):
        if type(one) is type(other):
            yield from _swapped(source, [one, other])


def label_swapped(source: Source, node: ast.AST) -> Iterator[Edit]:
    names: list[ast.expr | None] = []
    values: dict[int, bytes] = {}
    if isinstance(node, ast.Dict):
        names = node.keys
        values = {id(name): source.of(value) for name, value in zip(node.keys, node.values, strict=True)}
    elif isinstance(node, ast.List | ast.Tuple):
        names = list(node.elts)
    labels = [name for name in names if isinstance(name, ast.Constant) and isinstance(name.value, str)]
    for one, other in _neighbours(labels):
        if not values or values[id(one)] != values[id(other)]:
            yield from _swapped(source, [one, other])


def field_swapped(source: Source, node: ast.AST) -> Iterator[Edit]:
    match node:
        case ast.Attribute(value=ast.Name(id=name), attr=field, ctx=ast.Load()) if field in source.fields.get(name, ()):
            fields = source.fields[name]
            other = fields[(fields.index(field) + 1) % len(fields)]
            if other != field:
                yield source.end(node) - len(field.encode()), source.end(node), other.encode()


def copy_removed(source: Source, node: ast.AST) -> Iterator[Edit]:
    match node:
        case ast.Call(func=ast.Attribute(value=value, attr="copy"), args=[], keywords=[]):
            yield source.text.index(b".", source.end(value)), source.end(node), b""
        case ast.Call(func=function, args=[ast.Name() | ast.Attribute() | ast.Subscript() | ast.Call(), *_]) if (
            called(function) == "array"
        ):
            yield source.end(function) - len(b"array"), source.end(function), b"asarray"
        case ast.Call(func=function, args=[value]) if called(function) in ("copy", "deepcopy"):
            yield source.begin(node), source.end(node), b"(" + source.of(value) + b")"


def function_changed(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Call) and called(node.func) in TWINS:
        name, end = called(node.func), source.end(node.func)
        yield end - len(name), end, TWINS[name].encode()


def order_reversed(source: Source, node: ast.AST) -> Iterator[Edit]:
    if not isinstance(node, ast.Call):
        return
    end = source.end(node) - 1
    if called(node.func) == "reversed":
        yield source.begin(node), source.end(node.func), b"list"
    elif any(keyword.arg == "reverse" for keyword in node.keywords):
        return
    elif called(node.func) == "sorted" and not any(isinstance(each, ast.GeneratorExp) for each in node.args):
        yield end, end, b", reverse=True"
    elif called(node.func) == "sort" and not node.args:
        yield end, end, b", reverse=True" if node.keywords else b"reverse=True"


def refusal_removed(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Raise):
        yield source.begin(node), source.end(node), b"pass"


def guard_removed(source: Source, node: ast.AST) -> Iterator[Edit]:
    match node:
        case ast.If(body=[ast.Return() | ast.Continue() | ast.Break() as leaving], orelse=[]):
            yield source.begin(leaving), source.end(leaving), b"pass"


def store_removed(source: Source, node: ast.AST) -> Iterator[Edit]:
    match node:
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]) | ast.AugAssign():
            yield source.begin(node), source.end(node), b"pass"


def call_removed(source: Source, node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield source.begin(node), source.end(node), b"pass"


OPERATORS: dict[str, Callable[[Source, ast.AST], Iterator[Edit]]] = {
    "comparison": comparison,
    "arithmetic": arithmetic,
    "logic": logic,
    "condition negated": condition,
    "number": number,
    "truth value": truth_value,
    "keyword dropped": keyword_dropped,
    "arguments swapped": arguments_swapped,
    "label swapped": label_swapped,
    "field swapped": field_swapped,
    "copy removed": copy_removed,
    "function changed": function_changed,
    "order reversed": order_reversed,
    "refusal removed": refusal_removed,
    "guard removed": guard_removed,
    "store removed": store_removed,
    "call removed": call_removed,
}
"""What finds the places of each kind."""


def _between(source: Source, left: Node, right: Node, pattern: str) -> Iterator[tuple[int, int]]:
    """Where a sign stands between two nodes, comments left out."""
    begin = source.end(left)
    gap = re.sub(rb"#[^\n]*", lambda comment: b" " * len(comment[0]), source.text[begin : source.begin(right)])
    found = re.search(pattern.encode(), gap)
    if found:
        yield begin + found.start(), begin + found.end()


def _swapped(source: Source, nodes: Sequence[ast.expr]) -> Iterator[Edit]:
    for one, other in _neighbours(nodes):
        if source.of(one) != source.of(other) and _alike(one, other):
            middle = source.text[source.end(one) : source.begin(other)]
            yield source.begin(one), source.end(other), source.of(other) + middle + source.of(one)


def _alike(one: ast.expr, other: ast.expr) -> bool:
    """Whether somebody could mistake one for the other: no text for anything else, no number for a truth value."""
    kinds = {type(node.value) for node in (one, other) if isinstance(node, ast.Constant)}
    both = isinstance(one, ast.Constant) and isinstance(other, ast.Constant)
    return kinds <= {int, float} or (both and len(kinds) == 1)


def _neighbours(nodes: Sequence[ast.expr]) -> Iterator[tuple[ast.expr, ast.expr]]:
    return pairwise(nodes)


def _of_text(*nodes: ast.expr) -> bool:
    return any(
        isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))
        for node in nodes
    )
