"""The way of least energy from one equilibrium to another: a string of states.

The states stand at equal distances along the string. Each goes downhill within the plane across
the string (E, Ren and Vanden-Eijnden, J. Chem. Phys. 126, 164103, 2007, the simplified string
method), by Newton's step within that plane instead of the gradient: a thin shell is so much stiffer
in stretching than in bending that the gradient would crawl. Corrections with the same factor keep
the stretch out of a step, as in `dshell.solve.newton`. At rest the forces point along the string,
and its highest state is near a saddle.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dshell.solve.newton import Body, Configuration, EquilibriumSolver, NoDescentError

Array = NDArray[np.float64]

CORRECTIONS = 6
"""Allowed with one factor."""
STEPS = 2
"""Of a state in one round: the first takes out the stretch that comes of spreading the states."""
HALVINGS = 12
"""Of a step whose energy does not fall."""


@dataclass(frozen=True, eq=False)
class StringOfStates:
    """States along a way.

    Parameters
    ----------
    states : (k, dofs) array of float
        Both ends included, m.
    energies : (k,) array of float
        Of each, J.
    lengths : (k,) array of float
        Distance along the way from the first, m.
    """

    states: Array
    energies: Array
    lengths: Array

    @property
    def top(self) -> int:
        """The place of the highest state between the ends."""
        return 1 + int(np.argmax(self.energies[1:-1]))


def between_neighbours(string: StringOfStates) -> Array:
    """Return as many states on the part of a string about its highest state."""
    before, highest, after = string.states[string.top - 1 : string.top + 2]
    shares = np.linspace(0, 1, len(string.states) // 2 + 1)[:, None]
    up, down = (a + shares * (b - a) for a, b in ((before, highest), (highest, after)))
    return np.concatenate([up, down[1:]])


class StringSearch:
    """Relaxes a string between two equilibria.

    Parameters
    ----------
    solver : EquilibriumSolver
        Of the body.
    body : Body
        What is deformed.
    weights : (dofs,) array of float
        Of the distance between states: the square root of the sum of weights times squares.
    longest_step : float
        Largest change of a degree of freedom in one step, m.
    lay_onto : callable
        Takes a state and another, returns the first after the rigid motion that brings it nearest
        to the other; a body that is held in space returns it as it is.
    """

    def __init__(
        self,
        solver: EquilibriumSolver,
        body: Body,
        weights: Array,
        longest_step: float,
        lay_onto: Callable[[Array, Array], Array],
    ) -> None:
        self._solver, self._body, self._lay_onto = solver, body, lay_onto
        self._weights, self._longest = weights, longest_step
        self._free = solver.assembly.free

    def relax(
        self, states: Array, rounds: int, tell: Callable[[int], None] | None = None
    ) -> StringOfStates:
        """Return a string after some rounds, in each of which every inner state goes downhill.

        Parameters
        ----------
        states : (k, dofs) array of float
            To begin with; the ends stay.
        rounds : int
            How many.
        tell : callable, optional
            Told of each round.
        """
        for number in range(rounds):
            states = self._spread(states)
            across = self._tangents(states)
            for place in range(1, len(states) - 1):
                for _ in range(STEPS):
                    states[place] = self._step_across(states[place, :], across[place - 1, :])
            if tell is not None:
                tell(number)
        energies = [self._solver.configure(self._body, state).energy for state in states]
        return StringOfStates(states, np.array(energies), self._lengths(states))

    def _lengths(self, states: Array) -> Array:
        steps = np.sqrt(np.diff(states, axis=0) ** 2 @ self._weights)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def _spread(self, states: Array) -> Array:
        """Return states at equal distances along their polygon, each laid onto the one before."""
        laid = [states[0]]
        for state in states[1:]:
            laid.append(self._lay_onto(state, laid[-1]))
        states = np.stack(laid)
        lengths = self._lengths(states)
        places = np.linspace(0, lengths[-1], len(states))
        right = np.clip(np.searchsorted(lengths, places), 1, len(states) - 1)
        share = (places - lengths[right - 1]) / (lengths[right] - lengths[right - 1])
        spread = states[right - 1] + share[:, None] * (states[right] - states[right - 1])
        spread[0], spread[-1] = states[0], states[-1]
        return np.asarray(spread)

    def _tangents(self, states: Array) -> Array:
        """Return the direction across which each inner state goes, as weights of the free dofs."""
        along = (states[2:] - states[:-2]) * self._weights
        return np.asarray(along[:, self._free])

    def _step_across(self, state: Array, tangent: Array) -> Array:
        """Return a state after one step downhill in the plane across a tangent."""
        here = self._solver.configure(self._body, state)
        try:
            factor = self._solver.factor_downhill(here)
        except NoDescentError:
            return state
        along = factor.solve(tangent)
        stiff = float(tangent @ along)

        def step_of(residual: Array) -> Array:
            """Return the step that the residual asks for, without its part along the string."""
            straight = -factor.solve(residual)
            straight -= along * (float(tangent @ straight) / stiff)
            step = np.zeros(len(state))
            step[self._free] = straight
            length = np.abs(step).max()
            return step * min(1.0, self._longest / length) if length > 0 else step

        step, share = step_of(here.residual), 1.0
        for _ in range(HALVINGS):
            there = self._corrected(here.moved(share * step), step_of)
            if there.energy < here.energy:
                return there.state
            share /= 2
        return state

    def _corrected(self, there: Configuration, step_of: Callable[[Array], Array]) -> Configuration:
        for _ in range(CORRECTIONS):
            if not np.isfinite(there.energy):
                break
            lower = there.moved(step_of(there.residual))
            if not lower.energy < there.energy:
                break
            there = lower
        return there
