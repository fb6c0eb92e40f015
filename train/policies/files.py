"""A policy on disk: ``NAME.safetensors`` with its weights, and ``NAME.json``, which describes it.

Reading one runs no code of the file's: the one is a table of numbers, the other JSON. Each holds a SHA-256 digest that
tells the other, so that neither is changed unnoticed or taken for another's. They are no signature: whoever changes
both, and computes the digests anew, is not found out.
"""

import json
from hashlib import sha256
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from ...common.files import atomically
from .description import canonical, checked
from .policy import Layer, Policy

__all__ = ["DESCRIPTION", "WEIGHTS", "named_weights", "packed", "read_policy", "unpacked", "write_policy"]

WEIGHTS = ".safetensors"
DESCRIPTION = ".json"

_LARGEST = {WEIGHTS: 16 * 2**20, DESCRIPTION: 2**20}
_DIGEST = "sha256"
_DESCRIBED_BY = "description_sha256"


def write_policy(policy: Policy, path: str | Path) -> None:
    """Write a policy's two files, each whole or not at all.

    Parameters
    ----------
    policy : Policy
    path : str or Path
        Without a suffix, or with that of one of the two.

    Raises
    ------
    OSError
        If they cannot be written.
    """
    for suffix, content in packed(policy).items():
        atomically(_beside(path, suffix), lambda file, content=content: file.write_bytes(content))  # type: ignore[misc]


def read_policy(path: str | Path) -> Policy:
    """Read a policy. No code of the file's is run.

    Parameters
    ----------
    path : str or Path
        Without a suffix, or with that of one of the two files.

    Returns
    -------
    Policy

    Raises
    ------
    ValueError
        If a file is missing, too large, cut, changed or no policy's; the message names the file and what is wrong.
    """
    contents = {}
    for suffix, largest in _LARGEST.items():
        file = _beside(path, suffix)
        if not file.is_file():
            raise ValueError(
                f"policy must be {_beside(path, WEIGHTS)} with its {DESCRIPTION} beside it, {file} is no file"
            )
        with file.open("rb") as opened:
            contents[suffix] = opened.read(largest + 1)
        if len(contents[suffix]) > largest:
            raise ValueError(f"policy {file} must have at most {largest} bytes, it has more")
    return unpacked(contents, str(_beside(path, "")))


def packed(policy: Policy) -> dict[str, bytes]:
    """Contents of a policy's two files, by their suffixes.

    Parameters
    ----------
    policy : Policy

    Returns
    -------
    dict of str to bytes
    """
    description = policy.description
    weights = save(named_weights(policy), {_DESCRIBED_BY: _digest(canonical(description).encode())})
    text = json.dumps({**description, _DIGEST: _digest(weights)}, indent=2, allow_nan=False, ensure_ascii=False)
    return {WEIGHTS: weights, DESCRIPTION: (text + "\n").encode()}


def named_weights(policy: Policy) -> dict[str, NDArray[Any]]:
    """A policy's arrays, layer by layer: ``0.weight``, ``0.bias``, ``1.weight`` and so on."""
    return {f"{k}.{part}": getattr(layer, part) for k, layer in enumerate(policy.layers) for part in Layer._fields}


def unpacked(contents: dict[str, bytes], name: str) -> Policy:
    """The policy of two files' contents.

    Parameters
    ----------
    contents : dict of str to bytes
        By the files' suffixes.
    name : str
        Of the policy, for messages.

    Returns
    -------
    Policy

    Raises
    ------
    ValueError
        As `read_policy`.
    """
    description = _parsed(contents[DESCRIPTION], f"policy {name}{DESCRIPTION}")
    weights, file = contents[WEIGHTS], f"policy {name}{WEIGHTS}"
    if (digest := _digest(weights)) != (told := description.pop(_DIGEST, None)):
        raise ValueError(
            f"{file} must have the {_DIGEST} {told!r} of its {DESCRIPTION}, it has {digest!r}: it was changed"
        )
    try:
        tensors = load(weights)
        header = json.loads(weights[8 : 8 + int.from_bytes(weights[:8], "little")])
    except (SafetensorError, ValueError, KeyError, RecursionError) as error:
        raise ValueError(f"{file} must be of safetensors' form: {_line(error)}") from None
    told = (header.get("__metadata__") or {}).get(_DESCRIBED_BY)
    try:
        if told != _digest(canonical(description).encode()):
            raise ValueError("it must say what was said when the weights were written: it was changed")
        description = checked(description)
        return Policy(_layers(tensors, description), description)
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"policy {name}{DESCRIPTION} or its {WEIGHTS} is refused: {_line(error)}") from None


def _layers(tensors: dict[str, Any], description: dict[str, Any]) -> list[Layer]:
    count = len(description["network"]["sizes"]) - 1
    names = {f"{k}.{part}" for k in range(count) for part in Layer._fields}
    if set(tensors) != names:
        raise ValueError(f"weights must be named {sorted(names)}, got {sorted(tensors)}"[:400])
    return [Layer(*(tensors[f"{k}.{part}"] for part in Layer._fields)) for k in range(count)]


def _parsed(content: bytes, file: str) -> dict[str, Any]:
    try:
        value = json.loads(content.decode("utf-8"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{file} must be JSON: {_line(error)}") from None
    if not isinstance(value, dict):
        raise ValueError(f"{file} must be a JSON object, got {type(value).__name__}")
    return value


def _refuse_constant(name: str) -> None:
    raise ValueError(f"numbers must be finite, got {name}")


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__


def _beside(path: str | Path, suffix: str) -> Path:
    path = Path(path)
    name = path.name.removesuffix(WEIGHTS).removesuffix(DESCRIPTION)
    return path.with_name(name + suffix)
