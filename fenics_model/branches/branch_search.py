"""From an unstable equilibrium onto stable branches: along its mode to either side.

The most unstable mode is followed down the valley of the energy on both sides; where that ends,
Newton's method finds the equilibrium, or the viscous flow if it does not or if what it finds is
unstable again. What both sides come to is compared by its energy, and one of them is taken.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fenics_model.branches.buckling_modes import BucklingMode, buckling_modes
from fenics_model.branches.gradient_flow import GradientFlow
from fenics_model.branches.valley_walk import ValleyWalk
from fenics_model.settings import BRANCHES
from fenics_model.solid.solid import Solid
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome

SIDES = {"plus": 1.0, "minus": -1.0}

LEFT = "left"
"""Name of the unstable equilibrium that the search begins at."""

SAME_ENERGY = 1e-9
"""Branches are as low as each other, such as mirror images, where the energies agree so well."""

LANDINGS, ATTEMPTS = 2, 3
"""Unstable equilibria that are left by a walk in turn; calls of Newton's method at its end.

A soft valley, such as that of a rolled disc whose axis is free to turn, takes more than one call.
"""


@dataclass(frozen=True)
class Branch:
    """An equilibrium at a milestone, unstable or found by leaving that one.

    Parameters
    ----------
    name : str
        `LEFT`, or one of `SIDES`.
    energy : float
        Potential energy, J; NaN where the search found nothing.
    unstable_modes : int
        -1 where the search found nothing.
    """

    name: str
    energy: float
    unstable_modes: int


@dataclass(frozen=True)
class Departure:
    """What a search found.

    Parameters
    ----------
    equilibrium : NewtonOutcome or None
        Of the branch that was taken, whose state the solver holds; None if it stayed.
    branches : tuple of Branch
        The one that was left, and what was found to either side.
    taken : str
        Name of the branch that was taken.
    effort : Effort
        What it took.
    """

    equilibrium: NewtonOutcome | None
    branches: tuple[Branch, ...]
    taken: str
    effort: Effort

    @property
    def unstable_modes(self) -> int:
        """Of the branch that was taken."""
        return next(b.unstable_modes for b in self.branches if b.name == self.taken)


@dataclass(frozen=True)
class _Found:
    branch: Branch
    outcome: NewtonOutcome
    values: NDArray[np.float64]


def _by_energy(found: Sequence[_Found]) -> list[_Found]:
    """Lowest first; those that are as low as each other keep their order."""
    least = min(item.branch.energy for item in found)
    as_low = least + SAME_ENERGY * abs(least)
    return sorted(found, key=lambda item: max(item.branch.energy, as_low))


def _lowest(found: Sequence[_Found]) -> _Found | None:
    return _by_energy(found)[0] if found else None


def _other(found: Sequence[_Found]) -> _Found | None:
    return _by_energy(found)[-1] if found else None


def _none(found: Sequence[_Found]) -> _Found | None:
    return None


_CHOICES: Mapping[str, Callable[[Sequence[_Found]], _Found | None]] = dict(
    zip(BRANCHES, (_lowest, _other, _none), strict=True)
)
"""Which branch is taken where a milestone is unstable."""


class BranchSearch:
    """Finds stable branches near the solver's present state, at the loads of the moment.

    Parameters
    ----------
    newton : Newton
        Holds the state.
    flow : GradientFlow
        Of the same solver.
    solid : Solid
        Whose energy is compared.
    first_distance : float
        Rms displacement of the first step along a mode, m.
    side : array of float
        A change of the state; the side "plus" of a mode is the one that has part in it.
    choice : {"lowest", "other", "unstable"}
        Which branch is taken, see `SolidSettings.branch`.
    """

    def __init__(
        self,
        newton: Newton,
        flow: GradientFlow,
        solid: Solid,
        *,
        first_distance: float,
        side: NDArray[np.float64],
        choice: str = "lowest",
    ) -> None:
        self.flow = flow
        self._newton, self._solid = newton, solid
        self._first_distance, self._side = first_distance, side
        self._choose = _CHOICES[choice]

    def leave(self, modes: int, tolerance: float, reference: float) -> Departure:
        """Leave the present equilibrium, if a branch is found that is to be taken.

        Parameters
        ----------
        modes : int
            Its unstable modes, just counted: the solver holds its factors.
        tolerance : float
            Norm of the residual of an equilibrium, N.
        reference : float
            Norm of the residual that is to be balanced, N.
        """
        values = self._newton.state.x.array
        unstable = values.copy()
        branches = [Branch(LEFT, self._solid.potential_energy(), modes)]
        found, effort = [], Effort()
        mode = self._most_unstable(modes)
        for name, sign in SIDES.items():
            values[:] = unstable
            outcome, spent = self._descended(mode, sign, tolerance, reference)
            effort += spent
            branch = Branch(name, np.nan, -1)
            if outcome is not None:
                branch = Branch(name, self._solid.potential_energy(), self.flow.unstable_modes())
                found.append(_Found(branch, outcome, values.copy()))
            branches.append(branch)
        taken = self._choose(found)
        values[:] = unstable if taken is None else taken.values
        if taken is None:
            return Departure(None, tuple(branches), LEFT, effort)
        effort += Effort(escapes=1)
        return Departure(taken.outcome, tuple(branches), taken.branch.name, effort)

    def _most_unstable(self, modes: int) -> BucklingMode | None:
        found = buckling_modes(self._newton, self.flow.mass, modes, self._side)
        return found[0] if found else None

    def _descended(
        self, mode: BucklingMode | None, sign: float, tolerance: float, reference: float
    ) -> tuple[NewtonOutcome | None, Effort]:
        """Follow a mode down to a stable equilibrium; None where there is none."""
        effort = Effort()
        for _ in range(LANDINGS):
            if mode is None:
                break
            walk = ValleyWalk(self._newton, self.flow.mass, sign * mode.direction, tolerance)
            arrived = walk.descend(self._first_distance)
            effort += Effort(walk.iterations)
            if not arrived:
                break
            landed, modes = self._landed(tolerance)
            effort += Effort(landed.iterations)
            if landed.converged and modes <= 0:
                return landed, effort
            if not landed.converged:
                break
            mode = self._most_unstable(modes)
        flowed = self.flow.relax(tolerance, reference)
        return flowed.equilibrium, effort + flowed.effort

    def _landed(self, tolerance: float) -> tuple[NewtonOutcome, int]:
        """Solve at the end of a walk; where that fails, go back there. With its unstable modes."""
        values = self._newton.state.x.array
        kept, iterations = values.copy(), 0
        for _ in range(ATTEMPTS):
            outcome = self._newton.solve(tolerance)
            iterations += outcome.iterations
            if outcome.converged or not np.isfinite(outcome.residual):
                break
        if not outcome.converged:
            values[:] = kept
        return replace(outcome, iterations=iterations), self.flow.unstable_modes()
