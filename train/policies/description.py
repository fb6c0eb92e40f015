"""What a policy's JSON file says of it, and what it has to say."""

import json
from collections.abc import Mapping
from typing import Any

__all__ = ["FORMAT", "canonical", "checked", "copied", "described_space"]

FORMAT = "stickslip policy 1"
"""How the files call themselves; the number counts what can no longer be read as before."""

_MOST_LAYERS = 16
_WIDEST = 4096
_ACTIVATIONS = ("tanh", "relu")
_OUTPUTS = ("logits", "action values")

_KINDS: dict[str, type] = {
    "format": str,
    "environment": str,
    "env_kwargs": dict,
    "groups": dict,
    "observation_space": dict,
    "action_space": dict,
    "conditioned": bool,
    "network": dict,
    "algorithm": dict,
    "versions": dict,
    "scores": dict,
}
_NETWORK = {"sizes": list, "activation": str, "outputs": str}


def canonical(value: Any) -> str:
    """JSON of one form for one value.

    Raises
    ------
    ValueError, TypeError
        If `value` is not JSON, a NaN or an infinity among it.
    """
    return json.dumps(value, sort_keys=True, allow_nan=False, separators=(",", ":"), ensure_ascii=False)


def copied(value: Any) -> Any:
    """A copy of what JSON holds."""
    return json.loads(json.dumps(value))


def checked(description: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a description that has all that it needs.

    Raises
    ------
    ValueError, TypeError
        If something is missing, too much or of the wrong kind; the message names it.
    """
    own = json.loads(canonical(dict(description)))
    _of_kinds("description", own, _KINDS)
    if own["format"] != FORMAT:
        raise ValueError(f"format must be {FORMAT!r}, got {own['format']!r}")
    network = own["network"]
    _of_kinds("network", network, _NETWORK)
    sizes = network["sizes"]
    whole = all(isinstance(size, int) and not isinstance(size, bool) and 1 <= size <= _WIDEST for size in sizes)
    if not whole or not 2 <= len(sizes) <= _MOST_LAYERS + 1:
        raise ValueError(f"sizes must be 2 to {_MOST_LAYERS + 1} whole numbers in [1, {_WIDEST}], got {_short(sizes)}")
    for name, allowed in (("activation", _ACTIVATIONS), ("outputs", _OUTPUTS)):
        if network[name] not in allowed:
            raise ValueError(f"{name} must be one of {list(allowed)}, got {_short(network[name])}")
    if not isinstance(own["algorithm"].get("name"), str):
        raise ValueError(f"algorithm must have a name, got {_short(own['algorithm'])}")
    action_space = {"type": "Discrete", "n": 2}
    if any(own["action_space"].get(name) != value for name, value in action_space.items()):
        raise ValueError(f"action_space must be {action_space}, got {_short(own['action_space'])}")
    if sizes[-1] != 2:
        raise ValueError(f"sizes must end with 2, the number of actions, got {_short(sizes)}")
    seen = [sizes[0] - own["conditioned"]]
    if own["observation_space"].get("type") != "Box" or own["observation_space"].get("shape") != seen:
        raise ValueError(
            f"observation_space must be a Box of shape {seen}, as many as the network takes, "
            f"got {_short(own['observation_space'])}"
        )
    return own


def described_space(space: Any) -> dict[str, Any]:
    """A Box or a Discrete space as Minari writes it, but for infinities, which are strings.

    Parameters
    ----------
    space : gymnasium.spaces.Box or gymnasium.spaces.Discrete

    Returns
    -------
    dict
    """
    if hasattr(space, "n"):
        return {"type": "Discrete", "dtype": str(space.dtype), "start": int(space.start), "n": int(space.n)}
    ends = {name: [_json_number(x) for x in getattr(space, name).tolist()] for name in ("low", "high")}
    return {"type": "Box", "dtype": str(space.dtype), "shape": list(space.shape), **ends}


def _json_number(x: float) -> float | str:
    return x if abs(x) != float("inf") else str(x)


def _of_kinds(name: str, value: dict[str, Any], kinds: Mapping[str, type]) -> None:
    if set(value) != set(kinds):
        missing, unknown = sorted(set(kinds) - set(value)), sorted(set(value) - set(kinds))
        raise ValueError(
            f"{name} must have exactly {list(kinds)}; it lacks {missing} and has unknown {_short(unknown)}"
        )
    for key, kind in kinds.items():
        if not isinstance(value[key], kind):
            raise ValueError(f"{key} must be a JSON {_JSON[kind]}, got {_short(value[key])}")


_JSON = {str: "string", dict: "object", bool: "true or false", list: "array"}


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 200 else text[:200] + "..."
