"""``stickslip compile``."""

from ..common.extras import optional_import
from .printing import progress

with optional_import():
    import typer

__all__ = ["compile_kernels"]


def compile_kernels() -> None:
    """Compile every kernel ahead of its first use, as for images and clusters, where none is compiled yet."""
    from ..ahead import uses, where_kept

    folder = where_kept()
    wanted = list(uses())
    with progress("compiling") as show:
        for done, (name, use) in enumerate(wanted):
            show(done, len(wanted), name)
            use()
        show(len(wanted), len(wanted))
    typer.echo(f"every kernel is compiled; the solver's are kept in {folder}")
