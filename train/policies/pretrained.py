"""The policies that the package ships, by name."""

from importlib import resources

from ...common.validation import known_names
from .files import DESCRIPTION, unpacked, WEIGHTS
from .policy import Policy

__all__ = ["PRETRAINED", "pretrained"]

PRETRAINED = ("speed", "knee", "memory", "conditioned")
"""Names of the policies: the ends of the trade, its knee, and one policy for every weight of memory."""

_PLACE = "stickslip.train.pretrained"


def pretrained(name: str) -> Policy:
    """A policy that the package ships; it was trained in the environment that its `env_kwargs` tell.

    Parameters
    ----------
    name : {"speed", "knee", "memory", "conditioned"}
        "conditioned" takes the weight of memory beside the observation.

    Returns
    -------
    Policy

    Raises
    ------
    ValueError
        If there is none of that name, or its files were changed.
    """
    known_names("name", [name], PRETRAINED)
    folder = resources.files(_PLACE)
    return unpacked({suffix: (folder / (name + suffix)).read_bytes() for suffix in (WEIGHTS, DESCRIPTION)}, name)
