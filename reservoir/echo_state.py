"""Echo-state networks: the standard reservoirs to compare with."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.validation import finite_array, known_names, number_within, whole_number
from ..compiling.compilation import compiled

__all__ = ["TOPOLOGIES", "EchoStateNetwork"]

TOPOLOGIES = ("random", "cycle", "orthogonal")
"""How the nodes of a network may be connected."""

_Array = NDArray[np.float64]

_MOST_SKIPPED = 50
_SINGULAR = 0.05
_PRODUCTS_OF_A_CALL = 20_000_000


@dataclass(frozen=True)
class EchoStateNetwork:
    """Recurrent network of leaky tanh nodes with one input [1]_.

    ::

        x(k) = (1 - leak) x(k-1) + leak tanh(W x(k-1) + W_in u(k) + b)

    W is `spectral_radius` times a matrix of spectral radius 1, chosen by `topology`:

    - "random": normal entries [1]_.
    - "orthogonal": uniform among orthogonal matrices, which remember best of all random ones while tanh is linear [2]_.
    - "cycle": each node feeds the next one and nothing else. With input weights of one size, whose signs are by the
      digits of pi (from the first one at which they are not singular, which 2 nodes are at any), and no bias, this is
      the simple cycle reservoir [3]_. Nothing in it is random. While tanh is linear, its memory of the input
      ``d = j nodes + i`` samples ago, 0 <= i < nodes, is ``r^(2 j nodes) (1 - r^(2 nodes))`` with r the spectral
      radius; over all d it sums to `nodes`.

    Of the others W_in and b are uniform in [-input_scaling, input_scaling]. The bias breaks the odd symmetry of tanh,
    without which no product of two inputs could be read out. A cycle needs inputs with a mean for that.

    Attributes
    ----------
    nodes : int
        Number of nodes, at least 1.
    spectral_radius : float, in [0, inf)
        Largest modulus of an eigenvalue of W. Below 1 the start is usually forgotten; nearer 1, more slowly.
    input_scaling : float, in (0, inf)
        Size of the input weights and biases. Small is linear and remembers, large is nonlinear and forgets: on
        random bits, 12 nodes had memory capacity 10 and two-bit parity capacity 0.6 at 0.1, but 5.5 and 2.3 at 1.
    leak : float, in (0, 1]
        Share of a node's state that is renewed at each step; 1 is no leak.
    density : float, in (0, 1]
        Probability that an entry of a random W is not zero. Sparse pays only with hundreds of nodes.
    seed : int
        Of the random weights. Networks that are equal have equal weights.
    topology : {"random", "cycle", "orthogonal"}
        How the nodes are connected.

    Raises
    ------
    TypeError
        If `nodes` or `seed` is not an integer.
    ValueError
        If a number is out of range, the topology unknown, `density` given for another topology than the random one,
        or W came out without a single cycle, which no scaling can help.

    References
    ----------
    .. [1] H. Jaeger, "The 'echo state' approach to analysing and training recurrent neural networks", GMD
       Report 148, 2001.
    .. [2] O. L. White, D. D. Lee and H. Sompolinsky, "Short-term memory in orthogonal neural networks", Phys. Rev.
       Lett. 92, 148102, 2004.
    .. [3] A. Rodan and P. Tino, "Minimum complexity echo state network", IEEE Trans. Neural Networks 22, 131, 2011.
    """

    nodes: int
    spectral_radius: float = 0.9
    input_scaling: float = 0.1
    leak: float = 1.0
    density: float = 1.0
    seed: int = 0
    topology: str = "random"

    def __post_init__(self) -> None:
        whole_number("nodes", self.nodes, 1)
        number_within("spectral_radius", self.spectral_radius, "[0, inf)")
        number_within("input_scaling", self.input_scaling, "(0, inf)")
        number_within("leak", self.leak, "(0, 1]")
        number_within("density", self.density, "(0, 1]")
        whole_number("seed", self.seed, 0)
        known_names("topology", [self.topology], TOPOLOGIES)
        if self.density != 1.0 and self.topology != "random":
            raise ValueError(f"density must be 1 unless the topology is random, got {self.density}")

    def states(self, signal: ArrayLike) -> _Array:
        """Drive the network from rest.

        Parameters
        ----------
        signal : array_like of shape (samples,)

        Returns
        -------
        ndarray of shape (samples, nodes)
            Row k is the state that has absorbed ``signal[k]``; in (-1, 1).

        Raises
        ------
        ValueError
            If `signal` has a wrong shape or is not finite.
        """
        signal = finite_array("signal", signal, 1)
        recurrent, inward, bias = self._weights()
        drive = signal[:, None] * inward + bias
        states = np.empty_like(drive)
        outward = np.ascontiguousarray(recurrent.T)
        # An interrupt is heard between two calls of compiled code.
        together = max(1, _PRODUCTS_OF_A_CALL // self.nodes**2)
        for begin in range(0, len(signal), together):
            _follow(outward, drive, self.leak, states, begin, min(begin + together, len(signal)))
        return states

    def stepper(self, signal: ArrayLike) -> Callable[[float], _Array]:
        """Drive the network from rest, and step it on from there.

        Parameters
        ----------
        signal : array_like of shape (samples,)

        Returns
        -------
        callable
            Takes the next number of the signal and gives the state (nodes,) that has absorbed it.
        """
        recurrent, inward, bias = self._weights()
        state = self.states(signal)[-1].copy()

        def step(value: float) -> _Array:
            nonlocal state
            state = (1 - self.leak) * state + self.leak * np.tanh(recurrent @ state + (value * inward + bias))
            return state.copy()

        return step

    def _weights(self) -> tuple[_Array, _Array, _Array]:
        # A stream of its own: the input is often drawn with the same seed, and must not share its draws.
        random = np.random.default_rng([self.seed, self.nodes])
        if self.topology == "cycle":
            inward = self.input_scaling * _aperiodic_signs(self.nodes)
            return self.spectral_radius * np.roll(np.eye(self.nodes), 1, axis=0), inward, np.zeros(self.nodes)
        shape = (self.nodes, self.nodes)
        recurrent = random.standard_normal(shape)
        if self.topology == "random":
            recurrent = recurrent * (random.random(shape) < self.density)
        inward, bias = random.uniform(-self.input_scaling, self.input_scaling, (2, self.nodes))
        if self.topology == "orthogonal":
            rotation, triangle = np.linalg.qr(recurrent)
            # The signs make it uniform: F. Mezzadri, Notices of the AMS 54, 592, 2007.
            return self.spectral_radius * rotation * np.sign(np.diag(triangle)), inward, bias
        radius = np.abs(np.linalg.eigvals(recurrent)).max()
        if radius == 0:
            raise ValueError(f"density must be larger for {self.nodes} nodes to form a cycle, got {self.density}")
        return recurrent * (self.spectral_radius / radius), inward, bias


def _aperiodic_signs(count: int) -> _Array:
    """Signs by the digits of pi, from the first digit after the point at which a cycle of them is not singular.

    Where their Fourier transform has a zero, states never leave a subspace and memory is lost: 6 signs from the first
    digit on are such.
    """
    signs = _signs_of_pi(count + _MOST_SKIPPED)
    for first in range(_MOST_SKIPPED):
        tried = signs[first : first + count]
        if np.abs(np.fft.fft(tried)).min() > _SINGULAR:
            break
    return tried


def _signs_of_pi(count: int) -> _Array:
    """1 where a digit of pi after the point is 5 or more, -1 elsewhere; by Machin's formula in whole numbers."""
    unit = 10 ** (count + 10)

    def arctan_of_inverse(x: int) -> int:
        term = unit // x
        total, power, sign = term, 1, -1
        while term:
            term //= x * x
            power += 2
            total += sign * (term // power)
            sign = -sign
        return total

    digits = str(4 * (4 * arctan_of_inverse(5) - arctan_of_inverse(239)))[1 : count + 1]
    return np.array([1.0 if digit >= "5" else -1.0 for digit in digits])


@compiled
def _follow(outward: _Array, drive: _Array, leak: float, states: _Array, begin: int, end: int) -> None:
    """Step the network, at rest before sample 0, from sample `begin` to `end`.

    Row j of `outward` is what node j feeds to each, `drive` what comes from outside. The sums go into `drive`.
    """
    nodes = drive.shape[1]
    for k in range(begin, end):
        push = drive[k]
        if k > 0:
            # Node by node over all that it feeds: such a loop is vectorised, a sum is not.
            for j in range(nodes):
                state = states[k - 1, j]
                for i in range(nodes):
                    push[i] += outward[j, i] * state
        for i in range(nodes):
            kept = states[k - 1, i] if k > 0 else 0.0
            states[k, i] = (1.0 - leak) * kept + leak * np.tanh(push[i])
