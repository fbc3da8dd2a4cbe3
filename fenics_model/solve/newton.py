"""Newton's method on a residual and its tangent, a factor kept as long as that costs less.

Each tangent's factor serves several accelerated corrections (`corrections`). PETSc assembles and
solves, open to the user's options; its own accelerated methods can not tell when a new tangent is
due, nor shorten a step that turned an element inside out.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType
from typing import Protocol

import numpy as np
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from bilayer.runtime.termination import PutOff, signals_put_off
from bilayer.runtime.time_limit import check_time, time_is_up
from fenics_model.plain_options import PREFIX
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State
from fenics_model.solve.corrections import AndersonMixing, CorrectionRule, Progress
from fenics_model.solve.factors import Factors, why_petsc_failed
from fenics_model.solve.layout import AssembledMatrix, Layout, create_tangent_matrix
from fenics_model.solve.petsc_options import UserOptions
from fenics_model.solve.stopwatch import Stopwatch

DEFAULT_OPTIONS = {
    "ksp_type": "preonly",
    "pc_type": "cholesky",  # of an indefinite matrix: L D L'
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_13": "1",  # no ScaLAPACK at the root, so that its pivots' signs are counted
    "mat_mumps_icntl_14": "50",  # percent of extra workspace for delayed pivots
}

INSIDE_OUT = "an element was turned inside out"

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NewtonOutcome:
    """The end of a solution.

    Parameters
    ----------
    state : State
        The solution, or where the iteration left it.
    converged : bool
        Whether the residual fell to the tolerance.
    iterations : int
        New tangents, each with one factorisation, that it took.
    corrections : int
        Corrections with these factors.
    residual : float
        Final norm of the residual.
    correction : float
        Norm of the last correction.
    reason : str
        Why it failed, in a few words; empty if it converged.
    """

    state: State
    converged: bool
    iterations: int
    corrections: int
    residual: float
    correction: float
    reason: str


class Viscosity:
    """A force k M (x - origin) beside the residual.

    Parameters
    ----------
    mass : AssembledMatrix
        M.
    k : float
        Viscosity over time step.
    origin : State
        Where the motion starts.
    layout : Layout
        Of the dofs.
    """

    def __init__(self, mass: AssembledMatrix, k: float, origin: State, layout: Layout) -> None:
        self.mass, self.k = mass, k
        self._origin, self._layout = origin, layout

    def force(self, state: State) -> Array:
        """Return the force at a state."""
        return self.k * self.mass.times(state - self._origin)

    def norm_and_work(self, state: State) -> tuple[float, float]:
        """Return the norm of the force at a state, N, and the work that the motion took, J."""
        force = self.force(state)
        return self._layout.norm(force), self._layout.dot(force, state - self._origin)


class AddedForce(Protocol):
    """What acts on the solid beside its own stresses and loads."""

    def force(self, state: State) -> Array:
        """Return what it adds to the residual, N, on the dofs that this rank owns."""

    def stiffness(self, state: State, held: NDArray[np.int32]) -> PETSc.Mat | None:
        """Return what it adds to the tangent, N/m, a matrix that the caller destroys; None: zero.

        Parameters
        ----------
        state : State
            Where.
        held : array of int
            Dofs of this rank whose rows and columns are left out.
        """


class Newton:
    """Finds states of a solid whose residual vanishes, some dofs held.

    It owns PETSc's objects: close it, or use it as a context manager.

    Parameters
    ----------
    solid : Solid
        Whose states.
    held : sequence of dolfinx.fem.DirichletBC
        Constraints.
    iteration_limit : int
        New tangents after which it has failed.
    options : str
        PETSc options that win over `DEFAULT_OPTIONS` and over the global options database.
    stopwatch : Stopwatch, optional
        Told of the work.
    rule : CorrectionRule, optional
        When a new tangent is due.
    tell : callable, optional
        Told in a few words of each new tangent, which may take long.

    Attributes
    ----------
    layout : Layout
        Of the dofs.
    held : list of dolfinx.fem.DirichletBC
        Constraints.
    stopwatch : Stopwatch
        As handed in.
    """

    def __init__(
        self,
        solid: Solid,
        held: Sequence[fem.DirichletBC],
        *,
        iteration_limit: int = 20,
        options: str = "",
        stopwatch: Stopwatch | None = None,
        rule: CorrectionRule | None = None,
        tell: Callable[[str], None] = lambda doing: None,
    ) -> None:
        self.solid, self.layout = solid, Layout(solid.space)
        self.held = list(held)
        self._iteration_limit = iteration_limit
        self._rule = CorrectionRule() if rule is None else rule
        self._tell = tell
        self._viscosity: Viscosity | None = None
        self._added: AddedForce | None = None
        self._summed: PETSc.Mat | None = None
        self._handed_out: Factors | None = None
        self.stopwatch = Stopwatch() if stopwatch is None else stopwatch
        self._options = UserOptions(options, DEFAULT_OPTIONS, PREFIX)
        with ExitStack() as stack:
            self._create(stack)
            self._resources = stack.pop_all()

    def _create(self, stack: ExitStack) -> None:
        """Make what PETSc solves with; the stack frees it."""
        self._r = self.layout.create_vector()
        self._matrix = create_tangent_matrix(self.solid.coupling, self.held)
        self._ksp = PETSc.KSP().create(self.layout.comm)
        for made in (self._r, self._matrix, self._ksp):
            stack.callback(made.destroy)
        self._ksp.setOptionsPrefix(PREFIX)
        with self._options.apply():
            self._ksp.setFromOptions()

    def close(self) -> None:
        """Free what PETSc holds."""
        self._take_factors_back()
        self._keep_sum(None)
        self._resources.close()

    def __enter__(self) -> "Newton":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def solve(
        self,
        guess: State,
        tolerance: float,
        factors: Factors | None = None,
        *,
        iteration_limit: int | None = None,
        rule: CorrectionRule | None = None,
    ) -> NewtonOutcome:
        """Iterate from a guess until the norm of the residual falls to `tolerance`.

        Parameters
        ----------
        guess : State
            Where it begins.
        tolerance : float
            Norm of the residual of a solution, N.
        factors : Factors, optional
            Of a tangent near the guess, for the first corrections; this solver made them last.
        iteration_limit : int, optional
            Instead of the solver's own.
        rule : CorrectionRule, optional
            Instead of the solver's own.
        """
        rule = self._rule if rule is None else rule
        if factors is None:
            self._take_factors_back()
            self.solid.tangent.reset_extrapolation()  # else from where these were made
        with signals_put_off() as signals, self.stopwatch.time_solution():
            limit = self._iteration_limit if iteration_limit is None else iteration_limit
            begin = Iterate.begin(self, guess)
            return self._iterate(begin, tolerance, factors, limit, rule, signals)

    def _iterate(
        self,
        here: "Iterate",
        tolerance: float,
        factors: Factors | None,
        limit: int,
        rule: CorrectionRule,
        signals: PutOff,
    ) -> NewtonOutcome:
        """Correct, with a new factor when one is due."""
        iterations, corrections, length, reason = 0, 0, 0.0, ""
        tangents = int(factors is not None)
        bound = rule.growth_limit * here.norm
        mixing = AndersonMixing(self.layout.dot, rule.history)
        progress = Progress(rule, here.norm, tolerance)
        if not math.isfinite(here.norm):
            reason = INSIDE_OUT
        while here.norm > tolerance and not reason:
            if factors is None or progress.is_slow:
                if iterations == limit:
                    reason = "too many iterations"
                    break
                if tangents > 1 and progress.is_fruitless:
                    reason = "a new tangent does not help"
                    break
                tangents += 1
                iterations += 1
                self._tell(self._describe(iterations, here.norm / tolerance))
                factors = self._factorise(here.state)
                mixing = AndersonMixing(self.layout.dot, rule.history)
                progress = Progress(rule, here.norm, tolerance)
            reason = factors.failure
            if reason:
                break
            corrections += 1
            self.stopwatch.count_correction()
            step = mixing.step(here.state, factors.solve(here.residual))
            there = here.moved(step, rule.halvings)
            if there is None:
                reason = INSIDE_OUT
                break
            length, here = self.layout.norm(there.state - here.state), there
            progress.note(here.norm)
            if here.norm > bound:
                reason = "the residual grew beyond all bounds"
            if self._is_interrupted(signals):
                reason = "interrupted"
        if iterations:
            self._options.check_all_used()
        return NewtonOutcome(
            here.state, not reason, iterations, corrections, here.norm, length, reason
        )

    def tell(self, doing: str) -> None:
        """Say in a few words what is being done."""
        self._tell(doing)

    def _describe(self, iterations: int, residual: float) -> str:
        """Say what is being done."""
        method = "Newton iteration" if self._viscosity is None else "viscous flow, iteration"
        return f"{method} {iterations}, residual {residual:.1e} of what is accepted"

    def _is_interrupted(self, signals: PutOff) -> bool:
        """Whether any rank was asked to end, so that all end together."""
        return bool(self.layout.comm.allreduce(signals.asked_for, op=MPI.LOR))

    def factorise(self, state: State) -> Factors:
        """Factorise the exact tangent of a state."""
        self.solid.tangent.reset_extrapolation()
        with self.stopwatch.time_solution():
            return self._factorise(state)

    def _factorise(self, state: State) -> Factors:
        self._take_factors_back()
        self._go_to(state)
        self._assemble_tangent(self._matrix)
        return self._factorise_with(self._added, state)

    def _factorise_with(self, added: AddedForce | None, state: State) -> Factors:
        """Factorise the tangent that was assembled last, with that of a force at a state."""
        check_time(bool(self.layout.comm.allreduce(time_is_up(), op=MPI.LOR)))
        self._take_factors_back()
        factors = self._ksp.getPC()
        if factors.getFailedReason():
            factors.reset()  # PETSc would return the failure from then on
        matrix = self._matrix_with(added, state)
        self.stopwatch.count_factorisation()
        self._ksp.setOperators(matrix)
        failure = ""
        with self._options.apply():
            try:
                self._ksp.setUp()
            except PETSc.Error as error:
                failure = why_petsc_failed(error)
                factors.reset()
        self._handed_out = Factors(self._ksp, matrix, self.layout, failure)
        return self._handed_out

    def _matrix_with(self, added: AddedForce | None, state: State) -> PETSc.Mat:
        """Return the tangent with that of a force, which may couple any dofs of the surface."""
        part = None if added is None else added.stiffness(state, self.held_dofs)
        if part is None:
            return self._matrix
        whole = self._matrix.copy()
        whole.axpy(1.0, part, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        part.destroy()
        whole.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._keep_sum(whole)
        return whole

    def _keep_sum(self, whole: PETSc.Mat | None) -> None:
        """Keep a matrix for as long as the solver has it, in the place of the last one."""
        before, self._summed = self._summed, whole
        if before is not None:
            before.destroy()

    def _take_factors_back(self) -> None:
        if self._handed_out is not None:
            self._handed_out.release()

    @cached_property
    def held_dofs(self) -> NDArray[np.int32]:
        """Dofs of this rank that are held, its ghosts included."""
        return np.unique(np.concatenate([c.dof_indices()[0] for c in self.held] or [[]])).astype(
            np.int32
        )

    def residual(self, state: State) -> Array:
        """Return the residual of a state, that of held dofs left out."""
        self._go_to(state)
        self._assemble_residual(self._r)
        if self._added is not None:
            here = State(self.solid.unknown.x.array)
            self._r.array[:] += self._free_part(self._added.force(here))[: self.layout.owned]
        return self.layout.read(self._r)

    def _free_part(self, force: Array) -> Array:
        """Return a force without that on held dofs."""
        free = np.array(force)
        free[self.held_dofs] = 0.0
        return free

    def slowed_residual(self, state: State) -> Array:
        """Return the residual with the viscous force, if there is one at the moment."""
        residual = self.residual(state)
        return residual if self._viscosity is None else residual + self._viscosity.force(state)

    def residual_norm(self, state: State) -> float:
        """Return the norm of the residual of a state."""
        return self.layout.norm(self.residual(state))

    def potential_energy(self, state: State) -> float:
        """Return the potential energy whose derivative the residual is, J."""
        return self.solid.potential_energy(state)

    @cached_property
    def mass(self) -> AssembledMatrix:
        """The displacements' mass matrix M at unit density, m3, zero for pressures and held dofs.

        It is assembled when first needed, which is seldom.
        """
        mass = AssembledMatrix(self.solid.mass(), self.held, self.layout)
        self._resources.callback(mass.close)
        return mass

    @contextmanager
    def _with_force(self, added: AddedForce | None) -> Iterator[None]:
        """Solve with another force beside the solid's own meanwhile, or with none."""
        before, self._added = self._added, added
        try:
            yield
        finally:
            self._added = before

    def set_out_from(self, state: State) -> None:
        """Take note of where the body is; how it came there matters if it may touch itself."""

    def reach(self, start: State, end: State) -> State:
        """Return how far the body can go straight from one state toward another."""
        return end

    def passes_through(self, state: State) -> bool:
        """Whether the body passes through itself, or through anything, where it may not."""
        return False

    def touches(self, state: State) -> bool:
        """Whether the body presses on itself, or on anything, in a state."""
        return False

    @contextmanager
    def slow_down(self, k: float, origin: State) -> Iterator[Viscosity]:
        """Solve with the viscous force k M (x - origin) meanwhile."""
        self._viscosity = Viscosity(self.mass, k, origin, self.layout)
        try:
            yield self._viscosity
        finally:
            self._viscosity = None

    def _go_to(self, state: State) -> None:
        """Evaluate at a state; its held dofs get their values, so that no correction is due."""
        self.solid.move_to(state)
        for condition in self.held:
            condition.set(self.solid.unknown.x.array)
        self.solid.unknown.x.scatter_forward()

    def _assemble_residual(self, r: PETSc.Vec) -> None:
        with r.localForm() as local:
            local.set(0)
        with self.stopwatch.time_assembly():
            fem_petsc.assemble_vector(r, self.solid.residual)
        r.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        if not self.solid.nodal.is_idle:
            r.array[:] += self.solid.nodal.gradient(self.solid.unknown.x.array)
        for condition in self.held:
            dofs, owned = condition.dof_indices()
            r.array[dofs[:owned]] = 0.0

    def _assemble_tangent(self, matrix: PETSc.Mat) -> None:
        """Assemble the tangent, with that of the viscous force, where the solid is."""
        matrix.zeroEntries()
        self.solid.tangent.move_linearisation_point()
        with self.stopwatch.time_assembly():
            fem_petsc.assemble_matrix(matrix, self.solid.tangent.form, self.held)
            matrix.assemble()
        self._add_springs(matrix)
        if self._viscosity is not None:
            part = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
            matrix.axpy(self._viscosity.k, self._viscosity.mass.petsc, part)

    def _add_springs(self, matrix: PETSc.Mat) -> None:
        """Add the springs' stiffness to the diagonal of a tangent, but for that of held dofs."""
        stiffness = self.solid.nodal.stiffness.copy()
        held = self.held_dofs
        stiffness[held[held < len(stiffness)]] = 0.0
        if self.layout.comm.allreduce(bool(stiffness.any()), op=MPI.LOR):
            with self.layout.vectors(stiffness) as (diagonal,):
                matrix.setDiagonal(diagonal, PETSc.InsertMode.ADD_VALUES)


@dataclass(frozen=True, eq=False)
class Iterate:
    """A state of the iteration, its residual, and the norm of that."""

    newton: Newton
    state: State
    residual: Array
    norm: float

    @classmethod
    def begin(cls, newton: Newton, guess: State) -> "Iterate":
        """Return the first one: the guess, its held dofs with their values."""
        residual = newton.slowed_residual(guess)
        held = State(newton.solid.unknown.x.array)
        return cls(newton, held, residual, newton.layout.norm(residual))

    def moved(self, step: Array, halvings: int) -> "Iterate | None":
        """Return the state after a step, shortened until the residual is a number; None: never."""
        for _ in range(halvings + 1):
            state = self.state + step
            residual = self.newton.slowed_residual(state)
            norm = self.newton.layout.norm(residual)
            if math.isfinite(norm):
                return Iterate(self.newton, state, residual, norm)
            step = step / 2
        return None
