"""A policy in NumPy alone: a multilayer perceptron from an observation to the valve."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...common.validation import finite_array, number_within
from .description import checked, copied

__all__ = ["ACTIVATIONS", "Layer", "Policy"]

Array = NDArray[np.float64]

ACTIVATIONS: dict[str, Callable[[Array], Array]] = {
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0.0),
}
"""What stands between two layers, by name."""


class Layer(NamedTuple):
    """An affine map, ``weight @ x + bias``."""

    weight: NDArray[np.float32]
    """Of shape (outputs, inputs)."""
    bias: NDArray[np.float32]
    """Of shape (outputs,)."""


@dataclass(frozen=True, eq=False, repr=False)
class Policy:
    """A trained policy, which nothing changes any more.

    The network is that of Stable-Baselines3's ``MlpPolicy``: affine layers with an activation between them, from the
    observation to one number for each action, of which the largest wins. Its weights are single precision. They are
    summed up in double precision, so that an action does not depend on the batch that it is computed in, or on the
    processor.

    Parameters
    ----------
    layers : sequence of Layer
        The last one has two outputs, of the shut and of the open valve.
    description : mapping
        What stands in the policy's JSON file, `docs/training.md` says what.

    Raises
    ------
    ValueError, TypeError
        If the description lacks something, or the layers are not those that it tells of, not of finite float32 numbers,
        or do not fit each other.

    Notes
    -----
    Stable-Baselines3 computes in single precision, and draws level what differs by less: its actions are those of this
    policy but where the two outputs differ by no more than the rounding errors of its sums, about 1e-6 of the largest
    term. Where they are equal, both shut the valve.
    """

    layers: tuple[Layer, ...]
    _description: Mapping[str, Any]

    def __init__(self, layers: Any, description: Mapping[str, Any]) -> None:
        description = checked(description)
        kept = tuple(Layer(_own(weight), _own(bias)) for weight, bias in layers)
        _refuse_misfits(kept, description)
        object.__setattr__(self, "layers", kept)
        object.__setattr__(self, "_description", description)
        double = [(layer.weight.T.astype(np.float64), layer.bias.astype(np.float64)) for layer in kept]
        object.__setattr__(self, "_double", double)

    def __repr__(self) -> str:
        sizes = "-".join(map(str, self._description["network"]["sizes"]))
        name, environment = self._description["algorithm"]["name"], self._description["environment"]
        return f"Policy({environment}, {name}, {sizes}{', takes weight' if self.conditioned else ''})"

    def __reduce__(self) -> Any:
        """A copy, in another process say, is checked and frozen as this one is."""
        return Policy, (tuple(map(tuple, self.layers)), self.description)

    @property
    def description(self) -> dict[str, Any]:
        """All that stands in the JSON file but the digests, as a copy."""
        return copied(self._description)

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment it was trained in, as a copy."""
        return copied(self._description["env_kwargs"])

    @property
    def scores(self) -> dict[str, Any]:
        """What it came to when it was measured, with the seeds, as a copy."""
        return copied(self._description["scores"])

    @property
    def conditioned(self) -> bool:
        """Whether it takes the weight of memory in the reward beside the observation."""
        return bool(self._description["conditioned"])

    def outputs(self, observation: ArrayLike, weight: ArrayLike | None = None) -> Array:
        """The network's outputs: logits of a policy gradient's policy, action values of a DQN's.

        Parameters
        ----------
        observation, weight
            As in `predict`.

        Returns
        -------
        (2,) or (n, 2) array of float64
        """
        x = self._inputs(observation, weight)
        activation = ACTIVATIONS[self._description["network"]["activation"]]
        *hidden, (last, bias) = vars(self)["_double"]
        for matrix, offset in hidden:
            x = activation(x @ matrix + offset)
        return np.asarray(x @ last + bias)

    def predict(
        self,
        observation: ArrayLike,
        weight: ArrayLike | None = None,
        deterministic: bool = True,
        *,
        rng: np.random.Generator | None = None,
    ) -> Any:
        """Act on one observation, or on each of a batch.

        Parameters
        ----------
        observation : (d,) or (n, d) array_like
            Of the environment that `env_kwargs` makes; rounded to single precision, as the environment's are.
        weight : float or (n,) array_like, in [0, 1], optional
            Weight of memory in the reward, for a policy that is `conditioned` on it, and for no other.
        deterministic : bool
            Whether to take the best action, or to draw one from the policy's distribution.
        rng : numpy.random.Generator, optional
            What to draw from; a fresh one by default.

        Returns
        -------
        numpy.int64, or (n,) array of int64
            0 or 1.

        Raises
        ------
        ValueError, TypeError
            If an argument has the wrong shape, is not finite or out of range, or if actions are to be drawn by a policy
            of action values, which has no distribution.
        """
        outputs = self.outputs(observation, weight)
        if deterministic:
            return outputs.argmax(axis=-1)
        if self._description["network"]["outputs"] != "logits":
            raise ValueError("deterministic must be True for a policy of action values, which has no distribution")
        generator = np.random.default_rng() if rng is None else rng
        # P(open) = 1 / (1 + exp(l_0 - l_1)), and tanh overflows nowhere.
        opening = 0.5 + 0.5 * np.tanh(0.5 * (outputs[..., 1] - outputs[..., 0]))
        return (generator.random(opening.shape) < opening).astype(np.int64)[()]

    def at(self, weight: float) -> "Policy":
        """What a policy that is `conditioned` on the weight does at one weight, as a policy that takes none.

        The weight's part of the first layer is put into its bias, which rounds it to single precision.

        Parameters
        ----------
        weight : float, in [0, 1]
            Of memory in the reward.

        Returns
        -------
        Policy
            Its environment's ``memory_weight`` is the weight; its scores are those at that weight, if there are any.

        Raises
        ------
        ValueError, TypeError
            If the policy takes no weight, or `weight` is out of range.
        """
        if not self.conditioned:
            raise ValueError(f"weight must not be set: {self!r} was not trained for any weight")
        chosen = number_within("weight", weight, "[0, 1]")
        description = self.description
        sizes = description["network"]["sizes"]
        at_weight = [each for each in description["scores"].get("weights", []) if each.get("weight") == chosen]
        description |= {
            "conditioned": False,
            "env_kwargs": {**description["env_kwargs"], "memory_weight": chosen},
            "network": {**description["network"], "sizes": [sizes[0] - 1, *sizes[1:]]},
            "scores": at_weight[0] if at_weight else {},
        }
        (first, bias), *further = self.layers
        moved = bias + first[:, -1].astype(np.float64) * np.float32(chosen)
        return Policy([(first[:, :-1], moved.astype(np.float32)), *further], description)

    def scored(self, scores: Mapping[str, Any]) -> "Policy":
        """The same policy with other scores, ready for JSON."""
        return Policy(self.layers, {**self.description, "scores": dict(scores)})

    def _inputs(self, observation: ArrayLike, weight: ArrayLike | None) -> Array:
        wanted = self.layers[0].weight.shape[1] - self.conditioned
        seen = finite_array("observation", observation, (1, 2))
        if seen.shape[-1] != wanted:
            raise ValueError(f"observation must be of shape ({wanted},) or (n, {wanted}), got {seen.shape}")
        if not self.conditioned:
            if weight is not None:
                raise ValueError(f"weight must be None: this policy was not trained for any weight, got {weight!r}")
            return _single(seen)
        if weight is None:
            raise ValueError("weight must be given, in [0, 1]: this policy was trained for any weight of memory")
        chosen = finite_array("weight", weight, (0, 1))
        if (chosen < 0.0).any() or (chosen > 1.0).any():
            raise ValueError(f"weight must be in [0, 1], got {weight!r}")
        if chosen.ndim and chosen.shape != seen.shape[:-1]:
            raise ValueError(f"weight must be one number or one for each observation, got shape {chosen.shape}")
        beside = np.broadcast_to(chosen, seen.shape[:-1])[..., None]
        return _single(np.concatenate([seen, beside], axis=-1))


def _single(x: Array) -> Array:
    """Numbers rounded to single precision, in double."""
    with np.errstate(over="ignore"):
        rounded = x.astype(np.float32).astype(np.float64)
    return finite_array("observation in single precision", rounded, (1, 2))


def _own(values: Any) -> NDArray[np.float32]:
    """A copy that cannot be written to."""
    if getattr(values, "dtype", None) != np.float32:
        raise ValueError(f"weights must be float32, got {getattr(values, 'dtype', type(values).__name__)}")
    own = np.array(values, order="C")
    own.flags.writeable = False
    return own


def _refuse_misfits(layers: tuple[Layer, ...], description: Mapping[str, Any]) -> None:
    sizes = description["network"]["sizes"]
    shapes = [each.shape for layer in layers for each in layer]
    wanted = [shape for inputs, outputs in pairwise(sizes) for shape in ((outputs, inputs), (outputs,))]
    if shapes != wanted:
        raise ValueError(f"weights must have the shapes {wanted} of the description, got {shapes}")
    if not all(np.isfinite(each).all() for layer in layers for each in layer):
        raise ValueError("weights must be finite, got NaN or infinity")
