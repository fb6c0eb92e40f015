"""A command that refuses an option said twice, of which the parser would keep the last in silence."""

from typing import Any

from .extras import optional_import

with optional_import():
    from typer.core import TyperCommand

__all__ = ["SaidOnce"]


class SaidOnce(TyperCommand):
    """A command each of whose options may be said once, but for those declared to be multiple."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take what follows the command's name.

        Raises
        ------
        ValueError
            If an option is said more than once.
        """
        if not ctx.resilient_parsing:
            _, _, said = self.make_parser(ctx).parse_args(list(args))
            options: list[Any] = [each for each in said if each.param_type_name == "option" and each.expose_value]
            for option in options:
                if options.count(option) > 1 and not option.multiple and not option.count:
                    values = " and ".join(map(repr, self._values(option, ctx, args)))
                    raise ValueError(f"{option.opts[0]} must be said once, got {values}")
        return super().parse_args(ctx, args)

    def _values(self, option: Any, ctx: Any, args: list[str]) -> list[Any]:
        """All values of an option that takes one."""
        option.multiple = True
        try:
            values, _, _ = self.make_parser(ctx).parse_args(list(args))
        finally:
            option.multiple = False
        return list(values[option.name])
