"""One visitor: what the browser asks for is done to the view, and the plots and words follow."""

import json
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from importlib import resources
from typing import Any

from ...common.extras import optional_import
from ...common.threads import library_threads
from ...compiling.compilation import kept_kernels_alone, NotCompiledError
from ...crawler.refusals import SolverError
from ...train.policies.pretrained import PRETRAINED
from ..driving import takes_weight
from ..front import front_at
from ..kernels import compile_kernels
from ..measures import exponents_of, long_run, LongRun, profile_of
from ..motion import events_of, shown, trace_of
from ..presets import PRESETS
from ..setup import LONGEST_WORD, NUMBERS, Setup, SWITCHES
from ..units import units_of
from ..view import acted, told_of_exponents, told_of_long_run, told_of_motion, told_of_setup, View
from .figures import draw_front, make_plots

with optional_import():
    from bokeh.document import Document
    from bokeh.models import ColumnDataSource, CustomJS
    from jinja2 import Environment, PackageLoader, StrictUndefined

__all__ = ["Session"]

_QUIET = 150
"""Milliseconds without a change after which what takes a long run is measured."""

_START = "window.stickslip.start({asked, told, measured, trace, cursor})"


class Session:
    """A visitor's view, his plots, and what he is told.

    The browser puts what it asks for into the source ``asked``, as JSON; it is told what came of it in ``told``, and a
    moment later what came of a long run in ``measured``. Whatever is asked for has a number, which the answers bear.

    What needs a kernel that is not kept is compiled by another process, and told once that is done: until then the page
    answers to whatever else is asked.

    Parameters
    ----------
    document : Document
        Of the visitor, to be filled.
    setup : Setup
        To begin with.
    notice : str
        What is to be said first, such as why a link was refused.
    workers : Executor
        Threads that do the long runs.
    compilers : Executor
        Processes that compile.
    """

    def __init__(self, document: "Document", setup: Setup, notice: str, workers: Executor, compilers: Executor) -> None:
        self._document, self._workers, self._compilers = document, workers, compilers
        self._view, self._notice = View(setup), notice
        self._asked = 0
        self._waiting: Any = None
        self._compiling = False
        self._compiled: Setup | None = None
        self._plots = make_plots()
        self._front: Any = None
        self._measured: dict[str, Any] = {}
        self._channels = {name: ColumnDataSource({"json": []}, name=name) for name in ("asked", "told", "measured")}
        self._channels["asked"].on_change("data", self._on_asked)
        sources = {**self._channels, **{name: self._plots.sources[name] for name in ("trace", "cursor")}}
        for model in (*self._plots.figures.values(), *self._channels.values()):
            document.add_root(model)
        document.js_on_event("document_ready", CustomJS(args=sources, code=_START))
        document.title = "stickslip explore"
        document.template = _template()
        document.template_variables.update(_static())
        self._move()

    def _on_asked(self, _name: str, _old: Any, new: Any) -> None:
        asked = json.loads(new["json"][0])
        self._asked = asked["number"]
        self._notice = ""
        try:
            for action in asked["actions"]:
                self._view = acted(self._view, action)
        except (TypeError, ValueError) as error:
            self._notice = _sentence(error)
        self._move()

    def _move(self) -> None:
        """Simulate what is to be seen, show it, and have the rest measured once nothing has changed for a while."""
        view = self._view
        told: dict[str, Any] = {"number": self._asked, "notice": self._notice, **told_of_setup(view)}
        if self._waiting is not None:
            self._document.remove_timeout_callback(self._waiting)
            self._waiting = None
        try:
            with self._kept_kernels(view.setup):
                what = shown(view.setup, view.bits)
        except NotCompiledError:
            _say(self._channels["told"], told | {"compiling": True})
            self._compile(view.setup)
            return
        except SolverError as error:
            told["notice"] = _sentence(error)
        else:
            self._plots.sources["trace"].data = trace_of(view.setup, what)
            self._plots.sources["events"].data = events_of(view.setup, what)
            self._draw_front(view.setup)
            told |= {"notice": self._notice or what.doubt, **told_of_motion(view, what)}
        _say(self._channels["told"], told)
        if view.setup.drive == "live":
            self._plots.sources["you"].data = {"speed": [], "memory": []}
            self._plots.sources["profile"].data = profile_of(None)
        else:
            self._waiting = self._document.add_timeout_callback(partial(self._measure, view.setup, self._asked), _QUIET)

    def _kept_kernels(self, setup: Setup) -> AbstractContextManager[None]:
        """Refuse kernels that are not kept, unless another process has already done for a setup what it can."""
        return nullcontext() if setup == self._compiled else kept_kernels_alone()

    def _compile(self, setup: Setup) -> None:
        """Have the kernels of a setup compiled; then those of what is asked for by then, if that needs others."""
        if not self._compiling:
            self._compiling = True
            done = self._compilers.submit(compile_kernels, setup)
            done.add_done_callback(lambda _: self._later(self._go_on, setup))

    def _go_on(self, setup: Setup) -> None:
        self._compiling, self._compiled = False, setup
        self._move()

    def _draw_front(self, setup: Setup) -> None:
        (dither, front), units = front_at(setup.dither), units_of(setup)
        if self._front != (dither, units):
            draw_front(self._plots, front, units)
            self._front = dither, units
            self._plots.sources["you"].data = {"speed": [], "memory": []}

    def _measure(self, setup: Setup, number: int) -> None:
        self._waiting = None
        self._workers.submit(self._work, setup, number)

    def _work(self, setup: Setup, number: int) -> None:
        """In a thread of the workers; the document is touched in its own."""
        try:
            with library_threads(1), self._kept_kernels(setup):
                if number != self._asked:
                    return
                run = long_run(setup)
                self._later(self._show_run, setup, number, run)
                if number == self._asked:
                    self._later(self._show_exponents, setup, number, exponents_of(setup, run.valve))
        except NotCompiledError:
            self._later(self._compile, setup)
        except Exception as error:  # a thread's own end would be silent, and the page would wait for it for ever
            self._later(self._show_failure, number, _sentence(error))

    def _later(self, function: Callable[..., None], *arguments: Any) -> None:
        self._document.add_next_tick_callback(partial(function, *arguments))

    def _show_run(self, setup: Setup, number: int, run: LongRun) -> None:
        if number != self._asked:
            return
        told = told_of_long_run(setup, run)
        self._plots.sources["profile"].data = profile_of(run.memory)
        self._plots.sources["you"].data = {"speed": [told["speed"]], "memory": [told["memory"] or 0.0]}
        self._measured = {"number": number, "run": told}
        _say(self._channels["measured"], self._measured)

    def _show_exponents(self, setup: Setup, number: int, spectrum: Any) -> None:
        if number == self._asked:
            # The run is told again: who has come since has not heard of it.
            self._measured["exponents"] = told_of_exponents(setup, spectrum)
            _say(self._channels["measured"], self._measured)

    def _show_failure(self, number: int, sentence: str) -> None:
        if number == self._asked:
            _say(self._channels["measured"], {"number": number, "failure": sentence})


def _say(channel: Any, what: dict[str, Any]) -> None:
    channel.data = {"json": [json.dumps(what, allow_nan=False)]}


def _sentence(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _template() -> Any:
    environment = Environment(
        loader=PackageLoader("stickslip.explore.page", "."), autoescape=True, undefined=StrictUndefined
    )
    return environment.get_template("page.html.jinja")


def _static() -> dict[str, Any]:
    """What does not change of the page."""
    files = resources.files("stickslip.explore.page")
    groups: dict[str, list[tuple[str, str]]] = {}
    for name, each in PRESETS.items():
        groups.setdefault(each.kind, []).append((name, each.title))
    sections = {
        "Body": ["duffing", "damping_ratio", "deborah", "radial_coupling", "foot_mass_fraction"],
        "Ground": ["static_friction", "kinetic_friction", "slope", "ratchet", "anchored"],
        "Time and solver": ["hold", "tolerance"],
    }
    return {
        "numbers": NUMBERS,
        "switches": SWITCHES,
        "sections": sections,
        "presets": groups,
        "policies": {name: takes_weight(name) for name in PRETRAINED},
        "longest_word": LONGEST_WORD,
        "style": (files / "page.css").read_text(encoding="utf-8"),
        "scripts": [(files / name).read_text(encoding="utf-8") for name in ("stage.js", "page.js")],
    }
