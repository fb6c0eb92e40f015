"""The echo-state network: the standard reservoir to compare with."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import finite_array, number_within, whole_number


@dataclass(frozen=True)
class EchoStateNetwork:
    """Random recurrent network of leaky tanh nodes with one input [1]_.

    ::

        x(k) = (1 - leak) x(k-1) + leak tanh(W x(k-1) + W_in u(k) + b)

    W is normal and scaled to its spectral radius; W_in and b are uniform in [-input_scaling, input_scaling].
    The bias breaks the odd symmetry of tanh, without which no product of two inputs could be read out.

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
        Probability that an entry of W is not zero. Sparse pays only with hundreds of nodes.
    seed : int
        Of the random weights. Networks that are equal have equal weights.

    Raises
    ------
    TypeError
        If `nodes` or `seed` is not an integer.
    ValueError
        If a number is out of range, or W came out without a single cycle, which no scaling can help.

    References
    ----------
    .. [1] H. Jaeger, "The 'echo state' approach to analysing and training recurrent neural networks", GMD
       Report 148, 2001.
    """

    nodes: int
    spectral_radius: float = 0.9
    input_scaling: float = 0.1
    leak: float = 1.0
    density: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        whole_number("nodes", self.nodes, 1)
        number_within("spectral_radius", self.spectral_radius, "[0, inf)")
        number_within("input_scaling", self.input_scaling, "(0, inf)")
        number_within("leak", self.leak, "(0, 1]")
        number_within("density", self.density, "(0, 1]")
        whole_number("seed", self.seed, 0)

    def states(self, signal: ArrayLike) -> NDArray[np.float64]:
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
        state = np.zeros(self.nodes)
        for k, push in enumerate(drive):
            state = (1 - self.leak) * state + self.leak * np.tanh(recurrent @ state + push)
            states[k] = state
        return states

    def _weights(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        # A stream of its own: the input is often drawn with the same seed, and must not share its draws.
        random = np.random.default_rng([self.seed, self.nodes])
        shape = (self.nodes, self.nodes)
        recurrent = random.standard_normal(shape) * (random.random(shape) < self.density)
        inward, bias = random.uniform(-self.input_scaling, self.input_scaling, (2, self.nodes))
        radius = np.abs(np.linalg.eigvals(recurrent)).max()
        if radius == 0:
            raise ValueError(f"density must be larger for {self.nodes} nodes to form a cycle, got {self.density}")
        return recurrent * (self.spectral_radius / radius), inward, bias
