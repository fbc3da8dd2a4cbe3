"""The next state of a branch, extrapolated from the last ones."""

from collections.abc import Sequence

import numpy as np

from fenics_model.solid.state import State

MEMORY = 3
"""Equilibria that a predictor keeps: a parabola goes through three."""


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
        """Guess the state at a parameter (Lagrange's formula)."""
        change = np.zeros_like(self.last.values)
        for t, state in self.known:
            others = [s for s, _ in self.known if s != t]
            weight = np.prod([(parameter - s) / (t - s) for s in others])
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
