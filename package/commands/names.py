"""``stickslip list``."""

from ..common.extras import optional_import

with optional_import():
    import typer

__all__ = ["list_names"]


def list_names() -> None:
    """List the tasks, measures, reservoirs, presets, algorithms and more that are known by name."""
    from ..listing import known_by_name

    for kind, names in known_by_name().items():
        typer.echo("\n  ".join([kind, *names]))
