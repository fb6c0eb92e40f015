"""The server of the page, for this machine alone."""

import errno
import logging
import socket
import webbrowser
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any
from urllib.parse import urlencode

from ...common.extras import optional_import
from ...common.workers import worker_processes
from ..kernels import compile_kernels
from ..link import query_of, setup_of_query
from ..setup import Setup
from .session import Session

with optional_import():
    from bokeh.application import Application
    from bokeh.application.handlers.function import FunctionHandler
    from bokeh.server.server import Server

__all__ = ["address_of", "prepare", "serve", "server_at"]

_HOST = "127.0.0.1"


def server_at(port: int, setup: Setup, workers: Executor, compilers: Executor) -> "Server":
    """A server that listens on this machine alone, not yet started.

    Parameters
    ----------
    port : int
        0 for any that is free.
    setup : Setup
        What a visitor without a link sees.
    workers : Executor
        Threads that do the long runs.
    compilers : Executor
        Processes that compile.

    Returns
    -------
    Server

    Raises
    ------
    ValueError
        If something else listens at the port, or it may not be listened at.
    """

    def visited(document: Any) -> None:
        arguments = document.session_context.request.arguments
        # What is no UTF-8 is refused as what it then reads, since no name and no value has such letters.
        pairs = [(name, value.decode(errors="replace")) for name, values in arguments.items() for value in values]
        seen, notice = setup, ""
        try:
            seen = setup_of_query(urlencode(pairs)) if pairs else setup
        except (TypeError, ValueError) as error:
            notice = f"This link is not followed: {' '.join(str(error).split())}."
        Session(document, seen, notice, workers, compilers)

    chosen = port or _free_port()
    try:
        server = Server(
            {"/": Application(FunctionHandler(visited))},
            address=_HOST,
            port=chosen,
            allow_websocket_origin=[f"{host}:{chosen}" for host in (_HOST, "localhost")],
        )
    except OSError as error:
        if error.errno not in (errno.EADDRINUSE, errno.EACCES):
            raise
        why = "something else listens there" if error.errno == errno.EADDRINUSE else "this user may not listen there"
        raise ValueError(f"port must be free, got {port}: {why}") from None
    return server


def _free_port() -> int:
    with socket.socket() as one:
        one.bind((_HOST, 0))
        return int(one.getsockname()[1])


def address_of(server: "Server", setup: Setup) -> str:
    """Where the page is."""
    query = query_of(setup)
    return f"http://{_HOST}:{server.port}/" + (f"?{query}" if query else "")


def prepare(setup: Setup) -> None:
    """Have all kernels loaded, or compiled, that a page begins with."""
    for each in (setup, Setup(), Setup(drive="policy")):
        compile_kernels(each)


def serve(setup: Setup, port: int, open_browser: bool, say: Callable[[str], None]) -> None:
    """Serve the page until an interrupt.

    Parameters
    ----------
    setup : Setup
        What a visitor without a link sees.
    port : int
        0 for any that is free.
    open_browser : bool
    say : callable
        Takes a line for the terminal.

    Raises
    ------
    ValueError
        As `server_at`.
    """
    # A visitor who has left is no news.
    logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)
    with ThreadPoolExecutor(1) as workers, worker_processes(1) as compilers:
        server = server_at(port, setup, workers, compilers)
        say("Preparing the solver: up to a minute the first time.")
        prepare(setup)
        server.start()
        where = address_of(server, setup)
        say(f"The page is at {where} for this machine alone; an interrupt (Ctrl+C) ends it.")
        if open_browser:
            webbrowser.open(where)
        try:
            server.io_loop.start()
        finally:
            server.stop()
