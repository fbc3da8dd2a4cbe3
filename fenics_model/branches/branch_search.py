"""From an unstable equilibrium onto stable branches: along its mode to either side.

The most unstable mode is followed down the valley of the energy on both sides. At the end of the
valley Newton's method finds an equilibrium. If it fails, or if that equilibrium is unstable, the
gradient flow continues to a stable one. The two equilibria are compared by their energies, and the
setting `branch` selects one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.specimen.settings import BRANCH_CHOICES
from fenics_model.branches.buckling_modes import BucklingMode, buckling_modes
from fenics_model.branches.gradient_flow import GradientFlow
from fenics_model.branches.stability import unstable_modes
from fenics_model.branches.valley_walk import ValleyWalk, WalkRule
from fenics_model.solid.state import State
from fenics_model.solve.effort import Effort
from fenics_model.solve.factors import Factors
from fenics_model.solve.newton import Newton, NewtonOutcome

MODE_SIDES = {"plus": 1.0, "minus": -1.0}

DEPARTED = "left"
"""Name of the unstable equilibrium that the search begins at."""


@dataclass(frozen=True)
class SearchRule:
    """Limits of a search, and the branch that it takes.

    Parameters
    ----------
    choice : {"lowest", "other", "unstable"}
        Which branch is taken, see `SolidSettings.branch`.
    same_energy : float
        Branches are as low as each other, such as mirror images, if the energies agree so well.
    landings : int
        Unstable equilibria on one side that are left in turn, each along its most unstable mode.
    attempts : int
        Calls of Newton's method at the end of a walk. A soft valley, such as that of a rolled disc
        whose axis is free to turn, takes more than one.
    walk : WalkRule
        Of the walk along a mode.
    """

    choice: str = "lowest"
    same_energy: float = 1e-9
    landings: int = 12
    attempts: int = 3
    walk: WalkRule = field(default_factory=WalkRule)


@dataclass(frozen=True)
class BranchEquilibrium:
    """An equilibrium at a milestone, unstable or found by leaving that one.

    Parameters
    ----------
    name : str
        `DEPARTED`, or one of `MODE_SIDES`.
    energy : float
        Potential energy, J; NaN if the search found nothing.
    unstable_modes : int
        -1 if the search found nothing.
    """

    name: str
    energy: float
    unstable_modes: int


@dataclass(frozen=True, eq=False)
class BranchSearchOutcome:
    """The outcome of a branch search.

    Parameters
    ----------
    equilibrium : NewtonOutcome or None
        Of the branch that was taken; None if it stayed.
    branches : tuple of BranchEquilibrium
        The one that was left, and what was found to either side.
    taken : str
        Name of the branch that was taken.
    effort : Effort
        The work of the search.
    """

    equilibrium: NewtonOutcome | None
    branches: tuple[BranchEquilibrium, ...]
    taken: str
    effort: Effort

    @property
    def unstable_modes(self) -> int:
        """Of the branch that was taken."""
        return next(b.unstable_modes for b in self.branches if b.name == self.taken)


@dataclass(frozen=True, eq=False)
class _Candidate:
    branch: BranchEquilibrium
    outcome: NewtonOutcome


@dataclass(frozen=True, eq=False)
class _Descent:
    """The equilibrium below a mode, with its unstable modes; None if there is none."""

    outcome: NewtonOutcome | None
    unstable_modes: int
    effort: Effort


def _sort_by_energy(found: Sequence[_Candidate], same_energy: float) -> list[_Candidate]:
    """Sort from the lowest up; those that are as low as each other keep their order."""
    least = min(item.branch.energy for item in found)
    as_low = least + same_energy * abs(least)
    return sorted(found, key=lambda item: max(item.branch.energy, as_low))


def _take_lowest(ascending: Sequence[_Candidate]) -> _Candidate | None:
    return ascending[0]


def _take_other(ascending: Sequence[_Candidate]) -> _Candidate | None:
    return ascending[-1]


def _take_none(ascending: Sequence[_Candidate]) -> _Candidate | None:
    return None


_CHOICES: Mapping[str, Callable[[Sequence[_Candidate]], _Candidate | None]] = dict(
    zip(BRANCH_CHOICES, (_take_lowest, _take_other, _take_none), strict=True)
)
"""The rules that choose a branch, by the values of the setting."""


class BranchSearch:
    """Finds stable branches near an unstable equilibrium, at the loads of the moment.

    Parameters
    ----------
    newton : Newton
        Solves.
    flow : GradientFlow
        Of the same solver.
    first_distance : float
        Rms displacement of the first step along a mode, m.
    side : array of float
        A change of the state; the side "plus" of a mode is the one that has part in it.
    rule : SearchRule, optional
        Its limits, and the branch that it takes.
    """

    def __init__(
        self,
        newton: Newton,
        flow: GradientFlow,
        *,
        first_distance: float,
        side: NDArray[np.float64],
        rule: SearchRule | None = None,
    ) -> None:
        self.flow = flow
        self._newton, self._solid = newton, newton.solid
        self._first_distance, self._side = first_distance, side
        self._rule = SearchRule() if rule is None else rule

    @property
    def stays(self) -> bool:
        """Whether the rule takes no other branch: it looks what there is, and leaves nothing."""
        return _CHOICES[self._rule.choice] is _take_none

    def leave_unstable(
        self, state: State, factors: Factors, tolerance: float, reference: float
    ) -> BranchSearchOutcome:
        """Leave an unstable equilibrium, if a branch is found that is to be taken.

        Parameters
        ----------
        state : State
            The equilibrium.
        factors : Factors
            Of its tangent; the search needs the solver and so uses them up.
        tolerance : float
            Norm of the residual of an equilibrium, N.
        reference : float
            Norm of the residual that is to be balanced, N.
        """
        modes = self._count_modes(factors)
        mode = self._find_most_unstable(factors, modes)
        branches = [BranchEquilibrium(DEPARTED, self._newton.potential_energy(state), modes)]
        found, effort = [], Effort()
        for name, sign in MODE_SIDES.items():
            descent = self._descend(state, mode, sign, tolerance, reference)
            effort += descent.effort
            branch = BranchEquilibrium(name, np.nan, -1)
            if descent.outcome is not None:
                energy = self._newton.potential_energy(descent.outcome.state)
                branch = BranchEquilibrium(name, energy, descent.unstable_modes)
                found.append(_Candidate(branch, descent.outcome))
            branches.append(branch)
        taken = self._choose(found)
        if taken is None:
            return BranchSearchOutcome(None, tuple(branches), DEPARTED, effort)
        effort += Effort(escapes=1)
        return BranchSearchOutcome(taken.outcome, tuple(branches), taken.branch.name, effort)

    def _choose(self, found: Sequence[_Candidate]) -> _Candidate | None:
        if not found:
            return None
        stable = [one for one in found if one.branch.unstable_modes <= 0]
        ascending = _sort_by_energy(stable or found, self._rule.same_energy)
        return _CHOICES[self._rule.choice](ascending)

    def _count_modes(self, factors: Factors) -> int:
        return unstable_modes(factors, self._solid.number_of_pressures)

    def _find_most_unstable(self, factors: Factors, modes: int) -> BucklingMode | None:
        found = buckling_modes(factors, self._newton.mass, modes, self._side)
        return found[0] if found else None

    def _descend(
        self,
        start: State,
        mode: BucklingMode | None,
        sign: float,
        tolerance: float,
        reference: float,
    ) -> _Descent:
        """Follow a mode down, and then that of each unstable equilibrium that this leads to.

        The last one is the result if the rule's `landings` do not suffice.
        """
        self._newton.set_out_from(start)
        descent, state = _Descent(None, -1, Effort()), start
        for _ in range(self._rule.landings):
            landed, spent = self._land(state, mode, sign, tolerance, reference)
            effort = descent.effort + spent
            if landed is None:
                return replace(descent, effort=effort)
            state = landed.state
            with self._newton.factorise(state) as factors:
                modes = self._count_modes(factors)
                descent = _Descent(landed, modes, effort)
                if modes <= 0:
                    break
                mode = self._find_most_unstable(factors, modes)
            self._newton.tell(f"{modes} unstable modes, on along the next")
        return descent

    def _land(
        self,
        state: State,
        mode: BucklingMode | None,
        sign: float,
        tolerance: float,
        reference: float,
    ) -> tuple[NewtonOutcome | None, Effort]:
        """Return the equilibrium below a mode, by a walk or a flow, stable or not."""
        effort = Effort()
        if mode is not None:
            walk = ValleyWalk(
                self._newton, state, sign * mode.direction, tolerance, self._rule.walk
            )
            walked = walk.descend(self._first_distance)
            state, effort = walked.state, Effort(walked.iterations)
            if walked.arrived:
                landed = self._solve_at_end_of_walk(state, tolerance)
                effort += Effort(landed.iterations)
                if landed.converged:
                    return landed, effort
        flowed = self.flow.flow_to_equilibrium(state, tolerance, reference)
        return flowed.equilibrium or flowed.unstable, effort + flowed.effort

    def _solve_at_end_of_walk(self, state: State, tolerance: float) -> NewtonOutcome:
        """Solve at the end of a walk."""
        iterations = 0
        for _ in range(self._rule.attempts):
            outcome = self._newton.solve(state, tolerance)
            iterations += outcome.iterations
            if outcome.converged or not np.isfinite(outcome.residual):
                break
            state = outcome.state
        return replace(outcome, iterations=iterations)
