"""What an environment was made from, in a form that JSON knows."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from enum import Enum
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec

from ..crawler import Groups, Scene
from ..crawler.model.holds import natural_holds
from ..crawler.model.variations import Range

__all__ = ["Specified", "plain", "plain_arguments"]


class Specified:
    """An environment whose `spec` can be written as JSON, whatever kinds of number its arguments were."""

    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """What `gymnasium.make` made it from; None if it was made without.

        `gymnasium.make` sets it to the arguments as they were given, NumPy's numbers among them, which JSON does not
        know; it is kept in Python's.
        """
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = None if spec is None else replace(spec, kwargs=plain_arguments(spec.kwargs))


def plain_arguments(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of an environment as `plain` makes them; a hold in seconds is natural, as the groups are."""
    own = dict(arguments)
    if isinstance(own.get("hold"), str):
        own["hold"] = natural_holds(own["hold"], own.get("groups"))
    return {name: plain(each) for name, each in own.items()}


def plain(value: Any) -> Any:
    """Arguments as JSON and YAML hold them.

    Parameters
    ----------
    value : object
        Groups, a scene, an actuator or a range, NumPy's numbers and arrays, enumerations, and mappings and sequences of
        these.

    Returns
    -------
    object
        Made of dicts, lists, strings, truths and Python's own numbers; what is none of the above is left as it is.
    """
    if isinstance(value, Groups | Scene):
        return value.to_dict()
    if isinstance(getattr(value, "groups", None), Groups):  # an actuator
        return value.groups.to_dict()
    if isinstance(value, Range):
        return asdict(value)
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [plain(each) for each in value]
    return value
