"""Load steps that another result's shapes predict, straight from one shape to the next.

The guide's shape at the next parameter, made a state of the solid, is off by about what it was off
by before: that defect is extrapolated and added. Newton's method does the rest. A step that ends
elsewhere than where it was predicted has found another branch, and does not count.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bilayer.results.starting import LONGEST_WAY
from fenics_model.path.shell_start import Extrusion
from fenics_model.solid.solid import Solid
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome

FAR_FROM_BALANCE = 0.5
"""Residual of a guess, over the reference, above which it is settled with the interface held.

A nearer one is settled, too, where Newton's method fails from it."""

SETTLED = 0.1
"""To what part of the reference it is settled."""

ELSEWHERE = 0.5
"""How far from its prediction a solution may be, over how far the prediction led."""


class Guide:
    """Another result's shapes as states of the solid, and how far they are from its equilibria.

    Parameters
    ----------
    newton : Newton
        Solves for the equilibria.
    solid : Solid
        Whose states.
    extrusion : Extrusion
        Makes a state of a shape.
    settle : callable
        Relaxes a state to a norm of the residual, the interface held; returns its outcome.
    shapes : mapping of float to (n, 3) array of float
        The bonded interface by path parameter, m, where the solid is held; empty: no guide.

    Attributes
    ----------
    left : list of (float, str)
        Path parameters of shapes that were not followed, and why.
    """

    def __init__(
        self,
        newton: Newton,
        solid: Solid,
        extrusion: Extrusion,
        settle: Callable[[float], NewtonOutcome],
        shapes: Mapping[float, NDArray[np.float64]],
    ) -> None:
        self._newton, self._solid, self._extrusion = newton, solid, extrusion
        self._settle, self._shapes = settle, dict(sorted(shapes.items()))
        self._states: dict[float, NDArray[np.float64]] = {}
        self._defects: list[tuple[float, NDArray[np.float64]]] = []
        self._is_trusted = True
        self.left: list[tuple[float, str]] = []

    def next_toward(self, goal: float, here: float) -> float | None:
        """Return where to step, the farthest shape in reach; None where there is none to trust."""
        ahead = [there for there in self._shapes if here < there <= goal]
        if not ahead or not self._is_trusted:
            return None
        in_reach = [there for there in ahead if there <= here + LONGEST_WAY * (1 + 1e-9)]
        return in_reach[-1] if in_reach else ahead[0]

    def advance(
        self, there: float, accepted: float, reference: float
    ) -> tuple[NewtonOutcome, Effort]:
        """Step from the present equilibrium to where a shape is; the loads of there act already.

        Where that fails the state is where it came to, and nothing is predicted until `learn`.

        Parameters
        ----------
        there : float
            The path parameter.
        accepted : float
            Norm of the residual of an equilibrium, N.
        reference : float
            Norm of the residual that is to be balanced, N.
        """
        values = self._newton.state.x.array
        before, guess = values.copy(), self._state_at(there) + self._defect_at(there)
        values[:] = guess
        outcome, effort = None, Effort(guided_steps=1)
        if self._newton.residual_norm() < FAR_FROM_BALANCE * reference:  # else far, or no number
            outcome = self._newton.solve(accepted)
            effort += Effort(outcome.iterations)
        if outcome is None or not outcome.converged:
            values[:] = guess
            settled = self._settle(SETTLED * reference)
            guess = values.copy()
            outcome = self._newton.solve(accepted)
            effort += Effort(settled.iterations + outcome.iterations)
        if outcome.converged and self._is_elsewhere(before, guess):
            outcome = replace(outcome, converged=False, reason="another branch")
        if not outcome.converged:
            self.distrust(there, outcome.reason)
        return outcome, effort

    def _is_elsewhere(self, before: NDArray[np.float64], predicted: NDArray[np.float64]) -> bool:
        """Whether the present state is too far from a prediction to be what it meant."""
        led = self._solid.displacement_norm(before - predicted)
        missed = self._solid.displacement_norm(self._newton.state.x.array - predicted)
        return missed > ELSEWHERE * led

    def distrust(self, there: float, reason: str) -> None:
        """Predict nothing until the equilibrium at one of the shapes is known; note why."""
        self._is_trusted = False
        self.left.append((there, reason))

    def learn(self, parameter: float) -> None:
        """Note how far the shape at a parameter, if there is one, is from the present state."""
        if parameter in self._shapes:
            defect = self._newton.state.x.array - self._state_at(parameter)
            self._defects = [*self._defects[-1:], (parameter, defect)]
            self._is_trusted = True

    def _state_at(self, parameter: float) -> NDArray[np.float64]:
        """Return the state made of a shape, with the natural states of its parameter."""
        if parameter not in self._states:
            self._states[parameter] = self._extrusion.state_of(self._shapes[parameter])
        return self._states[parameter]

    def _defect_at(self, parameter: float) -> NDArray[np.float64] | float:
        """Return the last defect, or the secant through the last two."""
        if len(self._defects) < 2:
            return self._defects[0][1] if self._defects else 0.0
        (s, first), (t, second) = self._defects
        return second + (parameter - t) / (t - s) * (second - first)
