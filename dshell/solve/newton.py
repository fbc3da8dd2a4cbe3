"""Newton's method for the least energy, damped and, if the Hessian is indefinite, modified.

Each iteration factorises the exact Hessian. If it has a negative eigenvalue, a convex replacement
is factorised instead, so that the step always goes downhill. Steps are limited in length and
shortened until the energy falls enough (Armijo). A whole step must not make the residual force much
larger.

A thin shell is soft in bending and stiff in stretching. A straight step that turns it also
stretches it, and the line search would allow only short steps (the Maratos effect). Corrections
with the same factor remove that stretch before the energy is judged. They cost no factorisation.
Each of them updates the factor (BFGS). A correction that would raise the energy is shortened.
"""

import itertools
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from bilayer.errors import ComputationError
from bilayer.runtime.time_limit import check_time
from dshell.energies.assembly import Assembly, Energy, deform, energy_sums, gradient_of
from dshell.energies.skin_contact import SkinContact, TouchingSkin
from dshell.energies.whole_turns import continue_turns
from dshell.solve.linear_solver import (
    Factor,
    LinearSolver,
    NotPositiveDefiniteError,
    SingularMatrixError,
)
from dshell.solve.secant_inverse import SecantInverse

Array = NDArray[np.float64]

SUFFICIENT_DECREASE = 1e-4
SHORTEST_STEP = 1e-8
CONVEX_SHIFT = 1e-8
"""Of the mean diagonal: keeps a convex relative regular where nothing resists."""
STIFFENINGS = (1e-3, 1e-1, 10.0)
"""Of the diagonal of a convex relative, in turn, if no step along Newton's direction lowers the
energy. The step gets shorter and turns to the residual force, along which the energy falls."""
FEW_NEGATIVE = 3
"""Negative eigenvalues whose modes are sought: far from an equilibrium there are many."""
MODE_TOLERANCE = 1e-4
MODE_RESTARTS = 3
"""Of ARPACK, twenty solutions each, for modes that mend a stiffness: those worth it, nearly 0,
stand apart and take no more; others took thousands of solutions on a fine mesh."""
TOO_FAR = 3.0
"""Growth of the residual force over a whole step, not a capped one, and its corrections. What comes
after is often indefinite, which costs several iterations; half the step needs no new factor."""
CONTACT_CORRECTIONS = 3
"""Corrections with one factor while something touches: contacts open and close, so that more of
them cost more than they save."""
FREE_SHARE = 0.9
"""Of the step to the first contact, the share that is taken at most."""
CORRECTION_SHARES = (1.0, 0.5, 0.25)
"""Of a correction, tried in this order until the energy falls."""
ENERGY_NOISE = 1e-6
"""Relative. Smaller changes may be round-off (strains of 1e-5 leave the energy six digits), so
there the residual force is the judge."""

CORRECTION_NOISE = 1e-12
"""Relative. Near an equilibrium a correction changes the energy by less, so that round-off would
decide whether it is kept; there the residual force is the judge."""


Deflation = Callable[[Array, Array], float]
"""Takes a state and its Newton step, returns a factor of the step; see `dshell.solve.deflation`."""


def undeflated(state: Array, step: Array) -> float:
    """Return 1: no equilibrium is to be avoided."""
    return 1.0


class NoDescentError(ComputationError):
    """No step along Newton's direction lowers the energy."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body: elastic energies under a dead load.

    Parameters
    ----------
    energies : sequence of Energy
        The elastic ones.
    load : array of float
        Force on each degree of freedom, N, in the shape of the state; it does not follow.
    contact : SkinContact, optional
        What keeps the body from passing through itself; nothing does if left out.
    """

    energies: Sequence[Energy]
    load: Array
    contact: SkinContact | None = None


class Configuration:
    """A body in a state; what has been computed of it is kept for the next question.

    Parameters
    ----------
    body : Body
        What is deformed.
    state : (dofs,) array of float
        All degrees of freedom, m.
    assembly : Assembly
        Of the body's energies.
    """

    def __init__(self, body: Body, state: Array, assembly: Assembly) -> None:
        self.body, self.state = body, state
        self._assembly = assembly
        with np.errstate(all="ignore"):  # a step too far may invert a fibre; it is then refused
            self._deformed = deform(body.energies, state)

    @cached_property
    def contact(self) -> TouchingSkin | None:
        """The contact of the body with itself; None if nothing acts."""
        if self.body.contact is None:
            return None
        touching = self.body.contact.at(self.state)
        return touching if touching.touches else None

    @cached_property
    def energy(self) -> float:
        """Potential energy, J."""
        elastic = float(sum(self._energies)) - float(self.body.load @ self.state)
        return elastic if self.contact is None else elastic + self.contact.energy

    @property
    def energy_scale(self) -> float:
        """Size of what adds up to the energy, J."""
        return float(sum(map(abs, self._energies))) + abs(float(self.body.load @ self.state))

    @cached_property
    def _energies(self) -> list[float]:
        with np.errstate(all="ignore"):
            return energy_sums(self._deformed)

    @cached_property
    def residual(self) -> Array:
        """Residual force on the free degrees of freedom, N."""
        with np.errstate(all="ignore"):
            forces = gradient_of(self._deformed)
        if self.contact is not None:
            forces += self.contact.gradient
        return (forces - self.body.load)[self._assembly.free]

    @cached_property
    def error(self) -> float:
        """Norm of the residual force, N."""
        return float(np.linalg.norm(self.residual))

    def free_share(self, step: Array) -> float:
        """Return the share of a step that may be taken: 1, or less if the skin would touch."""
        if self.body.contact is None:
            return 1.0
        free = self.body.contact.free_share(self.state, self.state + step)
        return 1.0 if free == 1.0 else FREE_SHARE * free

    def pushed(self, step: Array) -> "Configuration":
        """Return the body after as much of a step as its skin lets it take."""
        return self.moved(self.free_share(step) * step)

    def under(self, body: Body) -> "Configuration":
        """Return another body in the same state, such as the same sheet with another prestretch.

        Raises
        ------
        NoDescentError
            Its fibres, of another height, would pass through each other.
        """
        before, after = self.body.contact, body.contact
        if self.contact is not None and before is not None and after is not None:
            ways = before.points(self.state), after.points(self.state)
            if after.barrier.free_share(*ways) < 1:
                raise NoDescentError("the sheet, of another thickness, passes through itself")
        return Configuration(body, self.state, self._assembly)

    def is_free_to(self, there: "Configuration") -> bool:
        """Whether the skin does not pass through itself on the way to another state."""
        contact = self.body.contact
        return contact is None or contact.free_share(self.state, there.state) == 1.0

    def moved(self, step: Array) -> "Configuration":
        """Return the body after a step, (dofs,), m, over which its folds turn continuously."""
        there = Configuration(self.body, self.state + step, self._assembly)
        continued = continue_turns(self._deformed, there._deformed, there.state)
        if continued is None:
            return there
        return Configuration(self.body, continued, self._assembly)

    def hessian(self) -> csc_matrix:
        """Return the second derivative by the free degrees of freedom, N/m."""
        elastic = self._assembly.hessian(self._deformed)
        if self.contact is None:
            return elastic
        return elastic + self._assembly.of_free_dofs(self.contact.hessian())

    def hessian_with_convex_contact(self) -> csc_matrix:
        """Return the like of it whose contact alone has no negative eigenvalue."""
        elastic = self._assembly.hessian(self._deformed)
        if self.contact is None:
            return elastic
        return elastic + self._assembly.of_free_dofs(self.contact.convex_hessian())

    def convex_hessian(self) -> csc_matrix:
        """Return the like of it that has no negative eigenvalue."""
        elastic = self._assembly.convex_hessian(self._deformed)
        if self.contact is None:
            return elastic
        return elastic + self._assembly.of_free_dofs(self.contact.convex_hessian())


@dataclass(frozen=True)
class NewtonLimits:
    """When an equilibrium is found or given up.

    Parameters
    ----------
    tolerance : float
        Norm of the residual force that is small enough, N.
    iterations : int
        Allowed in one solve.
    longest_step : float
        Largest change of a degree of freedom in one iteration, m.
    corrections : int
        Allowed with one factor; `scripts/benchmark dshell` tells the iterations that they leave.
    """

    tolerance: float
    iterations: int
    longest_step: float
    corrections: int = 8


@dataclass(frozen=True, eq=False)
class Outcome:
    """The end of the iterations.

    Parameters
    ----------
    state : array of float
        The last state.
    converged : bool
        Whether its residual is within the tolerance.
    residual : float
        Norm of the residual force on the free degrees of freedom, N.
    iterations : int
        Newton steps taken.
    """

    state: Array
    converged: bool
    residual: float
    iterations: int


class _FlippedFactor:
    """An indefinite matrix, factorised, with its negative eigenvalues' signs turned."""

    def __init__(self, factor: Factor, values: Array, modes: Array) -> None:
        self._factor, self._values, self._modes = factor, values, modes

    def solve(self, right_side: Array) -> Array:
        """See `Factor`."""
        along = np.divide(self._modes.T @ right_side, self._values)
        return self._factor.solve(right_side) - 2 * self._modes @ along


class EquilibriumSolver:
    """Finds equilibria of bodies on one assembly.

    Parameters
    ----------
    assembly : Assembly
        Of the bodies' energies.
    linear_solver : LinearSolver
        For the steps.
    """

    def __init__(self, assembly: Assembly, linear_solver: LinearSolver) -> None:
        self.assembly = assembly
        self._linear = linear_solver

    def configure(self, body: Body, state: Array) -> Configuration:
        """Return a body in a state."""
        return Configuration(body, state, self.assembly)

    def find_minimum(self, bodies: Sequence[Body], start: Array, limits: NewtonLimits) -> Outcome:
        """Go downhill from a state to an equilibrium, or as far as the limits let.

        From a state that does not touch itself it first goes without contact. That is kept if no
        two places come within range on the straight way from the start to the end, or from iterate
        to iterate. If two places do, it goes on from the last iterate before.

        Parameters
        ----------
        bodies : sequence of Body
            What is on its way to the last of them: each of the others gets one iteration.
        start : array of float
            The first state, m.
        limits : NewtonLimits
            When to stop.
        """
        contact = bodies[-1].contact
        if contact is None or contact.at(start).touches:
            return self._go_downhill(bodies, start, limits, [])
        bare = [replace(body, contact=None) for body in bodies]
        iterates: list[Array] = []
        found = self._go_downhill(bare, start, limits, iterates)
        if found.converged and contact.stays_apart(start, found.state):
            return found
        steps = list(itertools.pairwise(iterates))
        clear = sum(1 for _ in itertools.takewhile(lambda ends: contact.stays_apart(*ends), steps))
        if found.converged and clear == len(steps):
            return found
        rest = bodies[min(clear, len(bodies) - 1) :]
        touched = self._go_downhill(rest, iterates[clear], limits, [])
        return replace(touched, iterations=found.iterations + touched.iterations)

    def _go_downhill(
        self, bodies: Sequence[Body], start: Array, limits: NewtonLimits, iterates: list[Array]
    ) -> Outcome:
        """Go downhill and append the states on the way, both ends included, to `iterates`."""
        here = self.configure(bodies[0], start)
        iterates.append(here.state)
        for iteration in range(limits.iterations + 1):
            check_time()
            body = bodies[min(iteration, len(bodies) - 1)]
            converged = False
            try:
                if here.body is not body:
                    here = here.under(body)
                converged = body is bodies[-1] and here.error <= limits.tolerance
                if converged or iteration == limits.iterations:
                    break
                here = self._iterate(here, limits)
                iterates.append(here.state)
            except NoDescentError:
                break
        return Outcome(here.state, converged, here.error, iteration)

    def smooth_guess(self, body: Body, guess: Array, limits: NewtonLimits) -> Array:
        """Return a state nearer to an equilibrium than a guess from elsewhere, by one iteration.

        A shape from another mesh is rough: some of its membrane is pressed, and the Hessian there
        is indefinite for that reason alone. The convex one is taken at once, because it costs two
        factorisations to find that out, one of them with an ordering of its own.

        Parameters
        ----------
        body : Body
            What is deformed.
        guess : (dofs,) array of float
            The state to begin with, m.
        limits : NewtonLimits
            Tolerance, longest step and corrections.
        """
        here = self.configure(body, guess)
        try:
            return self._descend(here, self._factor_convex(here), limits).state
        except NoDescentError:
            return guess

    def find_nearby_equilibrium(
        self,
        body: Body,
        start: Array,
        limits: NewtonLimits,
        deflation: Deflation = undeflated,
    ) -> Outcome:
        """Go to an equilibrium near a state, stable or not, by plain Newton steps, capped alone.

        Parameters
        ----------
        body : Body
            What is in equilibrium.
        start : array of float
            The first state, m.
        limits : NewtonLimits
            When to stop.
        deflation : callable, optional
            Takes a state and its Newton step, returns the factor of the step that leads away from
            equilibria that are known.
        """
        here = self.configure(body, start)
        for iteration in range(limits.iterations + 1):
            converged = here.error <= limits.tolerance
            if converged or not np.isfinite(here.error) or iteration == limits.iterations:
                break
            check_time()
            try:
                factor = self._linear.factor(here.hessian())
            except SingularMatrixError:
                break
            step = self._step(factor, here.residual)
            step = _cap_step(deflation(here.state, step) * step, limits.longest_step)
            here = here.pushed(step)
        return Outcome(here.state, converged, here.error, iteration)

    def unstable_modes(self, body: Body, state: Array) -> int:
        """Return the number of negative eigenvalues of the exact Hessian."""
        hessian = self.configure(body, state).hessian()
        try:
            self._linear.cholesky(hessian)
        except NotPositiveDefiniteError:
            return self._linear.factor(hessian).negative
        return 0

    def factor(self, hessian: csc_matrix) -> Factor:
        """Return a factor of any Hessian on the assembly."""
        return self._linear.factor(hessian)

    def unstable_direction(self, body: Body, state: Array) -> Array:
        """Return the direction of the negative eigenvalue nearest to 0, its largest entry 1."""
        return self.unstable_directions(body, state, 1)[0]

    def unstable_directions(self, body: Body, state: Array, count: int) -> Array:
        """Return those of the negative eigenvalues nearest to 0, (count, dofs); see the first."""
        hessian = self.configure(body, state).hessian()
        _, modes = _negative_pairs(hessian, self._linear.factor(hessian), count)
        directions = np.zeros((count, len(state)))
        directions[:, self.assembly.free] = modes.T
        largest = np.argmax(np.abs(directions), axis=1)
        return directions / directions[np.arange(count), largest][:, None]

    def _iterate(self, here: Configuration, limits: NewtonLimits) -> Configuration:
        """Return the body after one iteration, with a stiffer factor if need be."""
        try:
            return self._descend(here, self.factor_downhill(here), limits)
        except NoDescentError:
            for stiffening in STIFFENINGS:
                with suppress(NoDescentError):
                    return self._descend(here, self._factor_convex(here, stiffening), limits)
            raise

    def _descend(self, here: Configuration, factor: Factor, limits: NewtonLimits) -> Configuration:
        """Return the body after one step.

        That is the longest halved step that is low enough, and on which the skin does not pass
        through itself. If corrections lead it through itself, the step is taken without them.
        """
        tries = [limits]
        if here.body.contact is not None:
            tries = [replace(limits, corrections=count) for count in (CONTACT_CORRECTIONS, 0)]
        straight = self._step(factor, here.residual)
        step = _cap_step(straight, limits.longest_step)
        whole = step is straight
        slope = float(here.residual @ step[self.assembly.free])
        share = longest = here.free_share(step)
        while share > SHORTEST_STEP * longest:
            for each in tries:
                there = self._step_and_correct(here, share * step, factor, each)
                change = there.energy - here.energy
                too_far = whole and share == 1.0 and there.error > TOO_FAR * here.error
                low = change <= SUFFICIENT_DECREASE * share * slope and not too_far
                noise = ENERGY_NOISE * here.energy_scale
                settled = abs(change) <= noise and there.error < 0.5 * here.error
                if (low or settled) and here.is_free_to(there):
                    return there
            share /= 2
        raise NoDescentError("no step along Newton's direction lowers the energy")

    def _step_and_correct(
        self, here: Configuration, step: Array, factor: Factor, limits: NewtonLimits
    ) -> Configuration:
        """Return the configuration after a step and those corrections that lower the energy.

        The BFGS update must not use the step itself: it also stretches the shell, so the bending
        direction would look stiff and the next iteration would undo the step.
        """
        free = self.assembly.free
        there = here.moved(step)
        inverse = SecantInverse(factor)
        for _ in range(limits.corrections):
            if not np.isfinite(there.energy) or there.error <= limits.tolerance:
                break
            correction = _cap_step(self._step(inverse, there.residual), limits.longest_step)
            lower = self._shorten_correction(there, correction)
            if lower is None:
                break
            inverse.add_pair((lower.state - there.state)[free], lower.residual - there.residual)
            there = lower
        return there

    def _shorten_correction(self, here: Configuration, correction: Array) -> Configuration | None:
        """Return the body after the largest share of a correction that lowers the energy."""
        for share in CORRECTION_SHARES:
            there = here.moved(share * correction)
            noise = CORRECTION_NOISE * here.energy_scale
            change = there.energy - here.energy
            if change < -noise or (change <= noise and there.error < here.error):
                return there
        return None

    def _step(self, factor: Factor, residual: Array) -> Array:
        step = np.zeros(self.assembly.size)
        step[self.assembly.free] = -factor.solve(residual)
        return step

    def factor_downhill(self, here: Configuration) -> Factor:
        """Return the exact Hessian, or a relative whose steps go downhill, factorised.

        Raises
        ------
        NoDescentError
            Round-off hides the convex relative.
        """
        hessian = here.hessian()
        try:
            return self._linear.cholesky(hessian)
        except NotPositiveDefiniteError:
            pass
        if here.contact is not None:
            try:
                return self._linear.cholesky(here.hessian_with_convex_contact())
            except NotPositiveDefiniteError:
                pass
        return self._flip_negative_modes(hessian) or self._factor_convex(here)

    def _flip_negative_modes(self, hessian: csc_matrix) -> Factor | None:
        """Return the Hessian with its negative eigenvalues made positive, if they are few.

        Where a shape is about to lose its symmetry one or two of them are nearly 0, and the convex
        relative, which resists there, would only crawl.
        """
        try:
            factor = self._linear.factor(hessian)
            if 0 < factor.negative <= FEW_NEGATIVE:
                pairs = _negative_pairs(hessian, factor, factor.negative, MODE_RESTARTS)
                return _FlippedFactor(factor, *pairs)
        except (SingularMatrixError, ArpackError):
            pass
        return None

    def _factor_convex(self, here: Configuration, stiffening: float = 0.0) -> Factor:
        convex = here.convex_hessian()
        diagonal = convex.diagonal()
        convex.setdiag((1 + stiffening) * diagonal + CONVEX_SHIFT * diagonal.mean())
        try:
            return self._linear.cholesky(convex)
        except NotPositiveDefiniteError as error:
            raise NoDescentError("round-off hides the convex relative of the stiffness") from error


def _cap_step(step: Array, longest: float) -> Array:
    """Return a step itself if no degree of freedom changes by more than `longest`, or less."""
    length = np.abs(step).max()
    return step * (longest / length) if length > longest else step


def _negative_pairs(
    matrix: csc_matrix, factor: Factor, count: int, restarts: int | None = None
) -> tuple[Array, Array]:
    """Return the negative eigenvalues nearest to 0, (count,), and their modes, (n, count)."""
    size = matrix.shape[0]
    inverse = LinearOperator((size, size), matvec=factor.solve, dtype=float)
    begin = np.random.default_rng(0).normal(size=size)
    values, modes = eigsh(
        matrix, k=count, sigma=0.0, OPinv=inverse, which="SA", v0=begin, tol=MODE_TOLERANCE,
        maxiter=restarts,
    )  # fmt: skip
    return values, modes
