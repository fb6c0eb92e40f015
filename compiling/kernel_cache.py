"""Compiled kernels on disk, each in a file that is good only for the very sources it was compiled from.

numba's own cache asks the file of the outermost function alone whether it has changed, and ends with an error on a file
that is cut off. Here a file begins with the digest of all that its code depends on and of the code itself: one that was
cut off, belongs to something else, or was compiled from other sources, is no match and is compiled anew.
"""

import hashlib
import pickle
import re
import sys
import time
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import config, serialize
from numba.core.caching import _Cache, _CacheLocator
from numba.core.compiler import CompileResult
from numba.core.sigutils import normalize_signature
from numba.misc.appdirs import AppDirs

from ..common.files import atomically

__all__ = ["KernelCache", "sources_of"]

_PACKAGE = __name__.partition(".")[0]
_IMPORT = re.compile(rb"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+)?import[ \t]+(\([^)]*\)|[^\n#]*)", re.MULTILINE)
# What is imported for type checkers alone is in no kernel.
_TYPES = re.compile(rb"^if TYPE_CHECKING:\n(?:[ \t]+.*\n|[ \t]*\n)+", re.MULTILINE)
_DIGEST = hashlib.sha256().digest_size
_BEGAN = time.time()


class KernelCache(_Cache):
    """The compiled forms of one function.

    Parameters
    ----------
    function : callable
    on_miss : callable
        Told the `cache_path` and `unkept`, before a form is compiled that no folder has.
    """

    def __init__(self, function: Callable[..., Any], on_miss: Callable[[str | None, str], Any]) -> None:
        self._function = function
        self._on_miss = on_miss

    @cached_property
    def _places(self) -> list[Path]:
        # Code that was imported and has since been edited is not what its sources say.
        return _folders(self._function) if self._sources else []

    @property
    def _sources(self) -> bytes:
        return sources_of(self._function.__module__)

    @property
    def cache_path(self) -> str | None:
        """Folder in which a form would be kept now; None if none can be written."""
        folder = next(filter(_writable, self._places), None)
        return None if folder is None else str(folder)

    @property
    def unkept(self) -> str:
        """Why a form would be kept nowhere now; empty if it would be kept."""
        if not self._sources:
            return "in this process, since their sources cannot be read or were edited after they were imported"
        if self.cache_path is None:
            return "in every process, since no folder for them can be written: set NUMBA_CACHE_DIR to one that can"
        return ""

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """The form for a signature, or None if it has to be compiled."""
        target_context.refresh()
        name, stamp = self._key(sig, target_context.codegen())
        for folder in self._places:
            try:
                kept = (folder / name).read_bytes()
            except OSError:
                continue
            data = memoryview(kept)[_DIGEST:]
            if kept[:_DIGEST] == _digest(stamp, data):
                return CompileResult._rebuild(target_context, *pickle.loads(data))
        self._on_miss(self.cache_path, self.unkept)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a form in the first folder that can be written, if there is one."""
        if self.cache_path is None or data.library.has_dynamic_globals:
            return
        name, stamp = self._key(sig, data.codegen)
        code = serialize.dumps(data._reduce())
        for folder in filter(_writable, self._places):
            try:
                atomically(folder / name, lambda path: path.write_bytes(_digest(stamp, code) + code))
            except OSError:  # full, or lost since
                continue
            return

    def enable(self) -> None:
        """Nothing to do: it is always enabled."""

    def disable(self) -> None:
        """Look nowhere, and keep nothing."""
        self._places = []

    def flush(self) -> None:
        """Nothing to do: what is out of date is overwritten."""

    def _key(self, sig: Any, codegen: Any) -> tuple[str, bytes]:
        """A file's name, and what its code depends on."""
        function = self._function
        cells = tuple(cell.cell_contents for cell in function.__closure__ or ())
        signature, _ = normalize_signature(sig)
        which = repr((signature, codegen.magic_tuple())).encode() + serialize.dumps(cells)
        python = "".join(map(str, sys.version_info[:2])) + getattr(sys, "abiflags", "")
        name = f"{function.__qualname__.replace('<locals>.', '')}.py{python}.{hashlib.sha256(which).hexdigest()[:16]}"
        versions = f"{numba.__version__} {llvmlite.__version__}".encode()
        stamp = _digest(versions, which, function.__code__.co_code, self._sources)
        return f"{function.__module__.rpartition('.')[2]}.{name}.nbc", stamp


def _folders(function: Callable[..., Any]) -> list[Path]:
    """The folder that ``NUMBA_CACHE_DIR`` names, or else the module's ``__pycache__`` and one of the user's."""
    file = Path(function.__code__.co_filename)
    own = _CacheLocator.get_suitable_cache_subpath(str(file))
    chosen = vars(config)["CACHE_DIR"]
    if chosen:
        return [Path(chosen) / own]
    return [file.parent / "__pycache__", Path(AppDirs(_PACKAGE, appauthor=False).user_cache_dir) / own]


@cache
def _writable(folder: Path) -> bool:
    probe = folder / f".{_PACKAGE}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        atomically(probe, Path.touch)
        probe.unlink(missing_ok=True)
    except OSError:
        return False
    return True


@cache
def sources_of(module: str) -> bytes:
    """Digest of a module's source and of those that it imports, and they import, of this package and its own.

    Returns
    -------
    bytes
        Empty where one of them cannot be read, or has been edited since this process began.
    """
    packages = _PACKAGE, module.partition(".")[0]
    reached = {module}
    waiting = [module]
    while waiting:
        for imported in _imports(waiting.pop()):
            if imported not in reached and imported.partition(".")[0] in packages:
                reached.add(imported)
                waiting.append(imported)
    sources = [_source(name) for name in sorted(reached)]
    return _digest(*(source for source in sources if source is not None)) if None not in sources else b""


@cache
def _imports(module: str) -> tuple[str, ...]:
    """Modules that a module's source imports, wherever in it."""
    return tuple(name for name in _named_in(module) if name in sys.modules)


def _named_in(module: str) -> Iterator[str]:
    package = getattr(sys.modules[module], "__package__", None) or ""
    for origin, names in _IMPORT.findall(_TYPES.sub(b"", _source(module) or b"")):
        plain = [name.split(b" as ")[0].strip(b" \t\r\n()").decode() for name in names.split(b",")]
        if not origin:
            yield from plain
        elif package or not origin.startswith(b"."):
            source = resolve_name(origin.decode(), package)
            yield source
            yield from (f"{source}.{name}" for name in plain)  # which may be modules
            # Or names that a package imports on first use, from where its table says.
            homes = getattr(sys.modules.get(source), "_HOME", {})
            yield from (resolve_name(homes[name], source) for name in plain if name in homes)


@cache
def _source(module: str) -> bytes | None:
    file = getattr(sys.modules[module], "__file__", None)
    try:
        path = Path(file or "")
        source = path.read_bytes()
        dates = path.stat()
    except OSError:
        return None
    # An edit sets both, to a date that is past by now; an archive sets the first to any date.
    edited = any(_BEGAN <= date <= time.time() for date in (dates.st_mtime, dates.st_ctime))
    return None if edited else source


def _digest(*parts: bytes | memoryview) -> bytes:
    """Of the parts, each told from the next."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(len(part).to_bytes(8, "little"))
        whole.update(part)
    return whole.digest()
