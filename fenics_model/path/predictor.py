"""The next state of a branch, extrapolated from the last ones."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_model.solid.state import State

MEMORY = 3
"""Equilibria that a predictor keeps: a parabola goes through three."""


def extrapolation_weights(known: Sequence[float], parameter: float) -> list[float]:
    """Return the weights of values at known parameters, for that at another one (Lagrange).

    Examples
    --------
    >>> extrapolation_weights([1.0, 2.0], 3.0)
    [-1.0, 2.0]
    """
    return [
        float(np.prod([(parameter - other) / (t - other) for other in known if other != t]))
        for t in known
    ]


class Predictor:
    """Extrapolates the last equilibria: the parabola through three, the secant through two.

    Parameters
    ----------
    known : sequence of (float, State)
        Parameter and state of one or more equilibria, the last one last.
    slope : array of float, optional
        Change of the state over that of the parameter, for a single equilibrium.
    """

    def __init__(
        self, known: Sequence[tuple[float, State]], slope: NDArray[np.float64] | None = None
    ) -> None:
        self.known = list(known)
        self._slope = slope

    def record_equilibrium(self, parameter: float, state: State) -> None:
        """Learn an equilibrium; of two at one parameter, the second."""
        others = [(t, known) for t, known in self.known if t != parameter]
        self.known = [*others[-MEMORY + 1 :], (parameter, state)]

    def turn_back(self) -> None:
        """Expect the equilibria so far to come again, in the opposite order."""
        here = self.parameter
        self.known = [(2 * here - t, state) for t, state in self.known]

    def guess(self, parameter: float) -> State:
        """Guess the state at a parameter."""
        if len(self.known) == 1 and self._slope is not None:
            return self.last + (parameter - self.parameter) * self._slope
        change = np.zeros_like(self.last.values)
        weights = extrapolation_weights([t for t, _ in self.known], parameter)
        for weight, (_, state) in zip(weights, self.known, strict=True):
            change += weight * (state - self.last)
        return self.last + change

    @property
    def parameter(self) -> float:
        """Of the last equilibrium."""
        return self.known[-1][0]

    @property
    def last(self) -> State:
        """The last equilibrium."""
        return self.known[-1][1]
