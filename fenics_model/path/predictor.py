"""The next state of a branch, extrapolated from the last ones."""

from collections.abc import Sequence

import numpy as np

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
    """

    def __init__(self, known: Sequence[tuple[float, State]]) -> None:
        self.known = list(known)

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
