"""How a policy is measured and put where the package, or a study, keeps its policies."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .policies.files import read_policy, write_policy
from .policies.policy import Policy
from .scores import HELD_OUT_SEEDS, score

__all__ = ["WEIGHTS_OF_A_FRONT", "ship"]

WEIGHTS_OF_A_FRONT = tuple(k / 10 for k in range(11))
"""At which a policy is measured that takes the weight of memory."""


def ship(
    source: Policy | Path,
    name: str,
    folder: Path,
    *,
    steps: int = 6000,
    seeds: Sequence[int] = HELD_OUT_SEEDS,
) -> Policy:
    """Measure a policy and write its two files.

    Parameters
    ----------
    source : Policy or Path
        The policy, such as `policy_of` makes of a model, or the folder of a run, whose best policy is taken.
    name : str
        Of the files, without a suffix.
    folder : Path
        Made if it is missing. The package's own is that of `stickslip.train.pretrained`.
    steps : int
        To measure over, for each seed, 1000 at least.
    seeds : sequence of int
        That no training saw.

    Returns
    -------
    Policy
        As it was written: its scores are those measured now, of a policy that takes the weight one entry of
        ``"weights"`` for each of `WEIGHTS_OF_A_FRONT`.

    Raises
    ------
    ValueError
        If there is no policy in the folder.
    OSError
        If the files cannot be written.
    """
    policy = source if isinstance(source, Policy) else read_policy(source / "best")
    arguments: dict[str, Any] = policy.env_kwargs
    if policy.conditioned:
        front = [
            {"weight": weight, **score(policy.at(weight), arguments, steps=steps, seeds=seeds)}
            for weight in WEIGHTS_OF_A_FRONT
        ]
        measured = policy.scored({"weights": front})
    else:
        measured = policy.scored(score(policy, arguments, steps=steps, seeds=seeds))
    folder.mkdir(parents=True, exist_ok=True)
    write_policy(measured, folder / name)
    return measured
