"""What a trade is measured under: the environment's arguments, which all judges read alike."""

from typing import Any

from ...envs.settings import Settings

__all__ = ["conditions", "refuse_silence"]


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


def refuse_silence(settings: Settings) -> None:
    """Refuse conditions without flips.

    Raises
    ------
    ValueError
        If there is no dither.
    """
    if settings.dither == 0.0:
        raise ValueError("dither must be in (0, 0.5]: without flips there is nothing to remember, got 0.0")
