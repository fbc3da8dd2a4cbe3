"""Branch switching: the equilibrium that a shell takes if the one it found is unstable.

The unstable equilibrium is left along its mode to both sides, and the equilibria found there are
compared by their energies. Or it is kept. The path then follows the unstable equilibria by plain
Newton iterations, which do not require that the energy falls.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dshell.solve.newton import Body, EquilibriumSolver, NewtonLimits, Outcome

Array = NDArray[np.float64]

MODE_SIDES = (1.0, -1.0)
ESCAPES = 3
"""Number of times that an unstable equilibrium is left before it is kept."""
FOLLOWING_ITERATIONS = 15
"""Of plain Newton iterations near an equilibrium; a step that needs more is halved."""
FOLLOWING_STEP = 0.05
"""Of them, largest change of a degree of freedom over the largest that the descent allows."""
SAME_ENERGY = 1e-9
"""Relative difference of two energies below which they count as equal, as of mirror images."""


@dataclass(frozen=True, eq=False)
class StepOutcome:
    """The outcome of a load step.

    Parameters
    ----------
    outcome : Outcome
        With the iterations of every side that was tried.
    unstable_modes : int or None
        Of the equilibrium; None if there is none, or nobody has counted.
    """

    outcome: Outcome
    unstable_modes: int | None


class BranchRule(Protocol):
    """A rule that selects the equilibrium of a load step."""

    def take_load_step(
        self, bodies: Sequence[Body], start: Array, modes: int | None, limits: NewtonLimits
    ) -> StepOutcome:
        """Find an equilibrium.

        Parameters
        ----------
        bodies : sequence of Body
            On their way to the last of them, see `EquilibriumSolver.find_minimum`.
        start : array of float
            The first state, m.
        modes : int or None
            Its unstable modes; None if it is no equilibrium.
        limits : NewtonLimits
            When to stop.
        """


class StableBranchRule:
    """Goes downhill to an equilibrium, and on to a stable one if it is not.

    Parameters
    ----------
    solver : EquilibriumSolver
        Of the shell.
    distance : float
        Distance by which an unstable equilibrium is left along its mode, m.
    choose : callable
        Takes the energies of what was found, J, and returns the place of the one to take.
    """

    def __init__(
        self,
        solver: EquilibriumSolver,
        distance: float,
        choose: Callable[[Sequence[float]], int],
    ) -> None:
        self._solver, self._distance, self._choose = solver, distance, choose

    def take_load_step(
        self, bodies: Sequence[Body], start: Array, modes: int | None, limits: NewtonLimits
    ) -> StepOutcome:
        """Return the stable equilibrium of the last body; see `BranchRule`."""
        body = bodies[-1]
        found = _step_outcome(self._solver, body, self._solver.find_minimum(bodies, start, limits))
        for _ in range(ESCAPES):
            if not found.unstable_modes:
                break
            found = self._leave_unstable(body, found.outcome, limits)
        return found

    def _leave_unstable(self, body: Body, unstable: Outcome, limits: NewtonLimits) -> StepOutcome:
        here = self._solver.configure(body, unstable.state)
        away = self._distance * self._solver.unstable_direction(body, unstable.state)
        sides = [
            self._solver.find_minimum([body], here.pushed(side * away).state, limits)
            for side in MODE_SIDES
        ]
        arrived = [side for side in sides if side.converged] or sides[:1]
        energies = [self._solver.configure(body, side.state).energy for side in arrived]
        taken = arrived[self._choose(energies)]
        iterations = unstable.iterations + sum(side.iterations for side in sides)
        return _step_outcome(self._solver, body, replace(taken, iterations=iterations))


class UnstableBranchRule:
    """Goes downhill to a first equilibrium and then follows it, stable or not.

    Parameters
    ----------
    solver : EquilibriumSolver
        Of the shell.
    """

    def __init__(self, solver: EquilibriumSolver) -> None:
        self._solver = solver

    def take_load_step(
        self, bodies: Sequence[Body], start: Array, modes: int | None, limits: NewtonLimits
    ) -> StepOutcome:
        """Return the equilibrium of the last body next to the start; see `BranchRule`."""
        body = bodies[-1]
        if modes is None:
            return _step_outcome(
                self._solver, body, self._solver.find_minimum(bodies, start, limits)
            )
        near = replace(
            limits,
            iterations=min(limits.iterations, FOLLOWING_ITERATIONS),
            longest_step=FOLLOWING_STEP * limits.longest_step,
        )
        return _step_outcome(
            self._solver, body, self._solver.find_nearby_equilibrium(body, start, near)
        )


class NextEquilibriumRule:
    """Goes downhill to an equilibrium, whatever its stability, and does not count its modes.

    Parameters
    ----------
    solver : EquilibriumSolver
        Of the shell.
    """

    def __init__(self, solver: EquilibriumSolver) -> None:
        self._solver = solver

    def take_load_step(
        self, bodies: Sequence[Body], start: Array, modes: int | None, limits: NewtonLimits
    ) -> StepOutcome:
        """Return the equilibrium of the last body downhill; see `BranchRule`."""
        return StepOutcome(self._solver.find_minimum(bodies, start, limits), None)


def _step_outcome(solver: EquilibriumSolver, body: Body, outcome: Outcome) -> StepOutcome:
    """Count the unstable modes of an outcome, if it is an equilibrium."""
    modes = solver.unstable_modes(body, outcome.state) if outcome.converged else None
    return StepOutcome(outcome, modes)


def lowest(energies: Sequence[float]) -> int:
    """Return the place of the least energy, the first of those that are as low."""
    least = min(energies)
    return next(k for k, energy in enumerate(energies) if energy - least <= _noise(least))


def highest(energies: Sequence[float]) -> int:
    """Return the place of the greatest energy, the last of those that are as high."""
    greatest = max(energies)
    as_high = [k for k, energy in enumerate(energies) if greatest - energy <= _noise(greatest)]
    return as_high[-1]


def _noise(energy: float) -> float:
    return SAME_ENERGY * abs(energy)


BRANCH_RULES: Mapping[str, Callable[[EquilibriumSolver, float], BranchRule]] = {
    "lowest": lambda solver, distance: StableBranchRule(solver, distance, lowest),
    "other": lambda solver, distance: StableBranchRule(solver, distance, highest),
    "unstable": lambda solver, distance: UnstableBranchRule(solver),
}
"""By the setting `branch`."""
