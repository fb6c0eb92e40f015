"""The policies that the package ships, by name."""

from importlib import resources

from ...common.validation import known_names
from .files import DESCRIPTION, unpacked, WEIGHTS
from .policy import Policy

__all__ = ["PRETRAINED", "pretrained"]

_PLACE = resources.files("stickslip.train.pretrained")

PRETRAINED = tuple(
    sorted(file.name.removesuffix(DESCRIPTION) for file in _PLACE.iterdir() if file.name.endswith(DESCRIPTION))
)
"""Names of the policies, which are those of the files."""


def pretrained(name: str) -> Policy:
    """A policy that the package ships; it was trained in the environment that its `env_kwargs` tell.

    Parameters
    ----------
    name : str
        One of :data:`PRETRAINED`: "speed" and "memory" are the ends of the trade, "knee" has most of both, and
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
    return unpacked({suffix: (_PLACE / (name + suffix)).read_bytes() for suffix in (WEIGHTS, DESCRIPTION)}, name)
