"""What compiled code gives to Python: numbers and arrays, never a tuple class.

numba makes a tuple class by calling it. While an interrupt is pending that call fails, and the process ends with a
segmentation fault.
"""

import ast
import importlib
import inspect
import pkgutil

from numba.core import types

import stickslip
from stickslip.ahead import uses
from stickslip.common.extras import MissingExtra
from stickslip.compiling.compilation import compiled, Kernel
from stickslip.crawler.model.state import REST


def modules():
    for found in pkgutil.walk_packages(stickslip.__path__, "stickslip."):
        try:
            module = importlib.import_module(found.name)
        except MissingExtra:  # of a page in the browser, which has no kernel
            continue
        yield module


def marks_of(definition):
    return {ast.unparse(mark).partition("(")[0] for mark in definition.decorator_list}


def implementations(tree):
    """Names of the functions that an overload gives to the compiler."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and "overload" in marks_of(node):
            yield from (each.id for each in ast.walk(node) if isinstance(each, ast.Name))


def named_in_python(module, tree, implementing):
    """Kernels that code of the module which is not compiled names."""

    def within(node):
        if isinstance(node, ast.FunctionDef):
            marks = {"compiled", "allocating", "merged", "formula", "inlined", "overload"}
            if node.name in implementing or not marks.isdisjoint(marks_of(node)):
                return
        if isinstance(node, ast.Name):
            found = vars(module).get(node.id)
            if isinstance(found, Kernel):
                yield found
        for child in ast.iter_child_nodes(node):
            yield from within(child)

    yield from within(tree)
    for value in vars(module).values():
        if isinstance(value, dict):
            yield from (kernel for kernel in value.values() if isinstance(kernel, Kernel))


def called_from_python():
    """Every kernel of the package that Python may call."""
    trees = {module: ast.parse(inspect.getsource(module)) for module in modules()}
    implementing = {name for tree in trees.values() for name in implementations(tree)}
    return {kernel for module, tree in trees.items() for kernel in named_in_python(module, tree, implementing)}


def has_tuple_class(kind):
    if isinstance(kind, types.BaseNamedTuple):
        return True
    return isinstance(kind, types.BaseTuple) and any(map(has_tuple_class, kind))


def offenders(kernels):
    return [
        kernel.py_func.__qualname__
        for kernel in kernels
        if any(has_tuple_class(form.return_type) for form in kernel.nopython_signatures)
    ]


def test_the_search_finds_an_offender():
    @compiled
    def offending():
        return REST, 1

    offending()
    assert offenders([offending]) == [offending.py_func.__qualname__]


def test_no_kernel_gives_python_a_tuple_class():
    kernels = called_from_python()
    known = {"_drive_on", "step", "step_batch"}
    assert known <= {kernel.py_func.__name__ for kernel in kernels}
    for _, use in uses():
        use()
    unused = [kernel.py_func.__qualname__ for kernel in kernels if not kernel.nopython_signatures]
    assert unused == []
    assert offenders(kernels) == []
