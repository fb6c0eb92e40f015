"""What a kept kernel is good for: the very function, form, sources, versions and processor that it was made of."""

import importlib
import sys
import threading

import llvmlite
import numba
import numpy as np
import pytest
from numba.core import config

from stickslip.compiling import kernel_cache
from stickslip.compiling.compilation import compiled
from stickslip.compiling.kernel_cache import sources_of

SOURCE = """
from .constants import STEP
def shift(x):
    return x + STEP
def enclosing(number):
    def enclosed(x):
        return x + number
    return enclosed
"""
TOP = """
from . import one as first, two
from .deep import (
    three,
    four as last,
)
if TYPE_CHECKING:
    from .seven import anything

    from .eight import everything
from .lazy import nine
def f():
    import json
"""
LAZY = """
from importlib import import_module
if TYPE_CHECKING:
    from .far import nine, ten
_HOME = {"nine": ".nearby", "ten": "..eight"}
def __getattr__(name):
    return getattr(import_module(_HOME[name], __name__), name)
"""
NAMES = iter(range(10**6))


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A folder that kernels are kept in, for sources that count as older than this process."""
    monkeypatch.setitem(vars(config), "CACHE_DIR", str(tmp_path / "kept"))
    # numba reads its settings anew before it compiles if the environment has changed since it last did.
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.setattr(kernel_cache, "_BEGAN", float("inf"))
    return tmp_path / "kept"


@pytest.fixture
def module(tmp_path, monkeypatch, kept):
    """A module with functions to compile, which takes a constant from a second one."""
    name = f"cached{next(NAMES)}"
    folder = tmp_path / name
    folder.mkdir()
    for file, text in (("__init__", ""), ("constants", "STEP = 1.0\n"), ("functions", SOURCE)):
        (folder / f"{file}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    return importlib.import_module(f"{name}.functions")


def files(kept):
    return sorted(kept.rglob("*.nbc"))


def hits(function, *arguments):
    """What a new kernel gives, and whether it was loaded."""
    kernel = compiled(function)
    answer = kernel(*arguments)
    return answer, sum(kernel.stats.cache_hits.values())


def test_a_form_is_compiled_once(module, kept, capsys):
    assert hits(module.shift, 1.0) == (2.0, 0)
    (file,) = files(kept)
    assert file.name.startswith(f"functions.shift.py{sys.version_info[0]}{sys.version_info[1]}.")
    before = file.read_bytes()
    assert hits(module.shift, 1.0) == (2.0, 1)
    assert file.read_bytes() == before
    # Another form has a file of its own, and so have functions of one code that enclose other values.
    assert hits(module.shift, 1) == (2.0, 0)
    assert [hits(module.enclosing(number), 1.0) for number in (1.0, 2.0)] == [(2.0, 0), (3.0, 0)]
    assert [hits(module.enclosing(number), 1.0) for number in (1.0, 2.0)] == [(2.0, 1), (3.0, 1)]
    assert len(files(kept)) == 4
    assert sorted(file for file in kept.rglob("*") if file.is_file()) == files(kept)


def cut_off(file, other):
    file.write_bytes(file.read_bytes()[:1000])


def emptied(file, other):
    file.write_bytes(b"")


def anothers(file, other):
    file.write_bytes(other.read_bytes())


def with_a_turned_bit(file, other):
    content = bytearray(file.read_bytes())
    content[-100] ^= 1
    file.write_bytes(content)


def with_a_turned_bit_of_the_digest(file, other):
    content = bytearray(file.read_bytes())
    content[31] ^= 1
    file.write_bytes(content)


def as_a_folder(file, other):
    file.unlink()
    file.mkdir()


@pytest.mark.parametrize(
    "damage", [cut_off, emptied, anothers, with_a_turned_bit, with_a_turned_bit_of_the_digest, as_a_folder]
)
def test_a_damaged_file_is_compiled_anew(module, kept, damage):
    hits(module.shift, 1.0)
    (file,) = files(kept)
    hits(module.enclosing(5.0), 1.0)
    (other,) = set(files(kept)) - {file}
    damage(file, other)
    assert hits(module.shift, 1.0) == (2.0, 0)
    assert hits(module.shift, 1.0) == (2.0, damage is not as_a_folder)


@pytest.mark.parametrize("package", [numba, llvmlite])
def test_another_version_of_the_compiler_is_another_form(module, kept, monkeypatch, package):
    hits(module.shift, 1.0)
    monkeypatch.setattr(package, "__version__", package.__version__ + ".post1")
    assert hits(module.shift, 1.0) == (2.0, 0)
    assert hits(module.shift, 1.0) == (2.0, 1)


def test_another_function_of_the_same_name_is_another_form(module, kept):
    hits(module.shift, 1.0)
    exec("def shift(x):\n    return x + STEP + STEP", vars(module))
    assert hits(module.shift, 1.0) == (3.0, 0)


@pytest.mark.parametrize("file", ["constants", "functions"])
def test_edited_sources_are_another_form_and_none_is_kept_of_what_was_imported_before(
    module, kept, monkeypatch, file, capfd
):
    hits(module.shift, 1.0)
    path = kept.parent / module.__package__ / f"{file}.py"
    path.write_text(path.read_text(encoding="utf-8") + "# edited\n", encoding="utf-8")
    for cached in (sources_of, kernel_cache._source, kernel_cache._imports):
        cached.cache_clear()
    assert hits(module.shift, 1.0) == (2.0, 0)
    assert hits(module.shift, 1.0) == (2.0, 1)
    # As if that had been after this process began.
    monkeypatch.setattr(kernel_cache, "_BEGAN", path.stat().st_mtime)
    for cached in (sources_of, kernel_cache._source, kernel_cache._imports):
        cached.cache_clear()
    kernel = compiled(module.shift)
    assert kernel(1.0) == 2.0
    assert not kernel.stats.cache_hits
    assert kernel.unkept == (
        "in this process, since their sources cannot be read or were edited after they were imported"
    )
    assert sources_of(module.__name__) == b""


def test_two_writers_of_one_form_leave_a_whole_one(module, kept):
    ready = threading.Barrier(4)
    found = []

    def work():
        ready.wait(10)
        found.append(hits(module.shift, 1.0)[0])

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [2.0] * 4
    assert hits(module.shift, 1.0) == (2.0, 1)
    assert [file for file in kept.rglob("*") if file.is_file()] == files(kept)
    assert len(files(kept)) == 1


def test_a_full_disk_keeps_nothing_and_fails_nobody(module, kept, monkeypatch):
    def full(path, write):
        raise OSError("no space left")

    hits(module.shift, 1)
    monkeypatch.setattr(kernel_cache, "atomically", full)
    assert hits(module.shift, 1.0) == (2.0, 0)
    assert len(files(kept)) == 1


def test_imports_are_followed_within_the_package_wherever_they_stand(tmp_path, monkeypatch, kept):
    name = f"cached{next(NAMES)}"
    folder = tmp_path / name
    (folder / "deep").mkdir(parents=True)
    (folder / "lazy").mkdir()
    texts = {
        "__init__": "",
        "top": f"TYPE_CHECKING = False\n{TOP}",
        "one": f"import {name}.five as other\n",
        "two": "",
        "five": "",
        "six": "",
        "deep/__init__": "",
        "deep/three": "from ..six import *\n",
        "deep/four": "X = 1",
        "lazy/__init__": f"TYPE_CHECKING = False\n{LAZY}",
        "lazy/nearby": "nine = 9\n",
        "lazy/far": "",
        "seven": "",
        "eight": "",
    }
    for file, text in texts.items():
        (folder / f"{file}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    module = importlib.import_module(f"{name}.top")
    for other in ("lazy.far", "seven", "eight"):  # of another's use
        importlib.import_module(f"{name}.{other}")
    reached = {}
    for file, text in texts.items():
        path = folder / f"{file}.py"
        path.write_text(text + "\n#", encoding="utf-8")
        for cached in (sources_of, kernel_cache._source, kernel_cache._imports):
            cached.cache_clear()
        reached[file] = sources_of(module.__name__)
    digests = list(reached.values())
    assert len({len(each) for each in digests}) == 1
    changed = {file for file, one, other in zip(list(texts)[1:], digests, digests[1:], strict=False) if one != other}
    assert changed == set(texts) - {"__init__", "lazy/far", "seven", "eight"}
    assert sources_of("json") != sources_of(module.__name__)


def test_a_module_in_no_package_may_show_how_others_import(tmp_path, monkeypatch, kept):
    name = f"alone{next(NAMES)}"
    words = '"""Like so:\n\nfrom .neighbour import number\nfrom json import loads\n"""\n'
    text = f"{words}def double(x):\n    return 2.0 * x\n"
    (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    module = importlib.import_module(name)
    assert sources_of(name)
    assert [hits(module.double, 1.0) for _ in range(2)] == [(2.0, 0), (2.0, 1)]


def test_a_kernel_whose_sources_cannot_be_read_is_kept_nowhere(kept):
    space = {"__name__": "nowhere_to_be_found"}
    sys.modules["nowhere_to_be_found"] = type(sys)("nowhere_to_be_found")
    try:
        exec("def double(x):\n    return 2 * x", space)
        kernel = compiled(space["double"])
        assert kernel(np.pi) == 2 * np.pi
        assert kernel.unkept.startswith("in this process, since their sources cannot be read")
    finally:
        del sys.modules["nowhere_to_be_found"]
    assert files(kept) == []
