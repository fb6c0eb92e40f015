"""What a trade is measured under: the environment's arguments, which all judges read alike."""

from typing import Any

from ...envs.settings import Settings

__all__ = ["conditions"]


def conditions(**env_kwargs: Any) -> Settings:
    """The environment's arguments, checked.

    Parameters
    ----------
    **env_kwargs
        Arguments of `StickSlipCrawlerEnv`, but for `memory_weight` and `randomize`: both objectives are told apart, and
        one crawler is measured.

    Returns
    -------
    Settings

    Raises
    ------
    ValueError, TypeError
        If an argument is unknown, out of range, of the wrong type, or one of those two.
    """
    for name in ("memory_weight", "randomize"):
        if name in env_kwargs:
            raise ValueError(f"env_kwargs must be without {name}, got {name}={env_kwargs[name]!r}")
    return Settings.of(memory_weight=0.0, **env_kwargs)
