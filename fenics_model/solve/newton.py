"""Newton's method on a residual and its tangent: PETSc's SNES, open to the user's options."""

import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType

import numpy as np
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from numpy.typing import NDArray
from petsc4py import PETSc

from bilayer.runtime.termination import PutOff, signals_put_off
from fenics_model.api.dolfinx_api import RESIDUAL_IS_NO_NUMBER
from fenics_model.plain_options import PREFIX
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State
from fenics_model.solve.factors import Factors, why_factorisation_failed
from fenics_model.solve.layout import AssembledMatrix, Layout
from fenics_model.solve.petsc_options import UserOptions
from fenics_model.solve.stopwatch import Stopwatch

DEFAULT_OPTIONS = {
    "snes_type": "newtonls",
    "snes_linesearch_type": "basic",  # full steps
    "snes_rtol": "0",
    "snes_stol": "0",  # the residual alone decides
    "snes_divergence_tolerance": "1e10",
    "ksp_type": "preonly",
    "pc_type": "cholesky",  # of an indefinite matrix: L D L'
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_13": "1",  # no ScaLAPACK at the root, so that its pivots' signs are counted
    "mat_mumps_icntl_14": "50",  # percent of extra workspace for delayed pivots
}

_FAILURES = {55: "out of memory", 71: "a pivot is zero", 72: "not a number", 76: "MUMPS failed"}
"""PETSc's error codes for what a shorter step may avoid."""

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
        Factorisations that it took.
    residual : float
        Final norm of the residual.
    correction : float
        Norm of the last correction.
    reason : str
        Why it failed, in a few words; empty if it converged.
    factors : Factors or None
        Of the last iteration's tangent, until the solver is used again; None without an iteration.
    """

    state: State
    converged: bool
    iterations: int
    residual: float
    correction: float
    reason: str
    factors: Factors | None


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
        Iterations after which it has failed.
    options : str
        PETSc options that win over `DEFAULT_OPTIONS` and over the global options database.
    stopwatch : Stopwatch, optional
        Told of the work.

    Attributes
    ----------
    layout : Layout
        Of the dofs.
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
    ) -> None:
        self.solid, self.layout = solid, Layout(solid.space)
        self._held = list(held)
        self._viscosity: Viscosity | None = None
        self._handed_out: Factors | None = None
        self._signals = PutOff()
        self.stopwatch = Stopwatch() if stopwatch is None else stopwatch
        self._options = UserOptions(options, DEFAULT_OPTIONS, PREFIX)
        with ExitStack() as stack:
            self._create(iteration_limit, stack)
            self._resources = stack.pop_all()

    def _create(self, iteration_limit: int, stack: ExitStack) -> None:
        """Make what PETSc solves with; the stack frees it."""
        self._x, self._r = self.layout.create_vector(), self.layout.create_vector()
        self._matrix = fem_petsc.create_matrix(self.solid.tangent.form)
        self._matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self._matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        self._snes = PETSc.SNES().create(self.layout.comm)
        for made in (self._x, self._r, self._matrix, self._snes):
            stack.callback(made.destroy)
        self._snes.setOptionsPrefix(PREFIX)
        self._snes.setFunction(self._residual, self._r)
        self._snes.setJacobian(self._tangent, self._matrix)
        self._snes.setTolerances(max_it=iteration_limit)
        with self._options.apply():
            self._snes.setFromOptions()
        self._ksp = self._snes.getKSP()
        stack.callback(self._ksp.destroy)

    def close(self) -> None:
        """Free what PETSc holds."""
        self._take_factors_back()
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

    def solve(self, guess: State, tolerance: float) -> NewtonOutcome:
        """Iterate from a guess until the norm of the residual falls to `tolerance`."""
        self._start_anew(guess)
        self._snes.setTolerances(atol=tolerance)
        reason = self._iterate()
        iterations = self._snes.getIterationNumber()
        if iterations:
            self._options.check_all_used()
        return NewtonOutcome(
            State(self.layout.read(self._x)),
            converged=not reason,
            iterations=iterations,
            residual=float(self._snes.getFunctionNorm()),
            correction=float(self._snes.getSolutionUpdate().norm()) if iterations else 0.0,
            reason=reason,
            factors=self._hand_out_factors() if iterations else None,
        )

    def _iterate(self) -> str:
        """Run PETSc's iteration from `_x`; return why it failed, or an empty text."""
        with (
            signals_put_off() as self._signals,
            self.stopwatch.time_solution(),
            self._options.apply(),
        ):
            try:
                self._snes.solve(None, self._x)
            except PETSc.Error as error:
                if error.ierr not in _FAILURES:
                    raise
                return f"PETSc: {_FAILURES[error.ierr]}"
        reason = self._snes.getConvergedReason()
        if reason > 0:
            return ""
        if reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE:
            return why_factorisation_failed(self._ksp.getPC())
        return _in_words(reason)

    def factorise(self, state: State) -> Factors:
        """Factorise the tangent of a state."""
        self._start_anew(state)
        self._tangent(self._snes, self._x, self._matrix, self._matrix)
        self._ksp.setOperators(self._matrix)
        with self.stopwatch.time_solution(), self._options.apply():
            self._ksp.setUp()
        return self._hand_out_factors()

    def _start_anew(self, state: State) -> None:
        """Forget the tangents so far, and go to a state.

        PETSc would return a failed factorisation from then on, so it is dropped.
        """
        self._take_factors_back()
        self.solid.tangent.reset_extrapolation()
        factors = self._ksp.getPC()
        if factors.getFailedReason():
            factors.reset()
        self._go_to(state)
        self._x.array[:] = self.solid.unknown.x.array[: self.layout.owned]

    def _hand_out_factors(self) -> Factors:
        self._handed_out = Factors(self._ksp, self._matrix, self.layout)
        return self._handed_out

    def _take_factors_back(self) -> None:
        if self._handed_out is not None:
            self._handed_out.release()

    @cached_property
    def held_dofs(self) -> NDArray[np.int32]:
        """Dofs of this rank that are held, its ghosts included."""
        return np.unique(np.concatenate([c.dof_indices()[0] for c in self._held] or [[]])).astype(
            np.int32
        )

    def residual(self, state: State) -> Array:
        """Return the residual of a state, that of held dofs left out."""
        self._go_to(state)
        self._assemble_residual(self._r)
        return self.layout.read(self._r)

    def residual_norm(self, state: State) -> float:
        """Return the norm of the residual of a state."""
        return self.layout.norm(self.residual(state))

    @cached_property
    def mass(self) -> AssembledMatrix:
        """The displacements' mass matrix M at unit density, m3, zero for pressures and held dofs.

        It is assembled when first needed, which is seldom.
        """
        mass = AssembledMatrix(self.solid.mass(), self._held, self.layout)
        self._resources.callback(mass.close)
        return mass

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
        for condition in self._held:
            condition.set(self.solid.unknown.x.array)
        self.solid.unknown.x.scatter_forward()

    def _go_to_vector(self, x: PETSc.Vec) -> None:
        """Evaluate at what a vector holds, which PETSc may have locked."""
        self.solid.unknown.x.array[: self.layout.owned] = x.array_r
        self.solid.unknown.x.scatter_forward()

    def _residual(self, snes: PETSc.SNES, x: PETSc.Vec, r: PETSc.Vec) -> None:
        self._go_to_vector(x)
        self._assemble_residual(r)
        if self._viscosity is not None:
            force = self._viscosity.force(State(self.solid.unknown.x.array))
            r.array[:] += force[: self.layout.owned]
        if self._signals.asked_for:
            r.set(math.nan)  # ends the iteration

    def _assemble_residual(self, r: PETSc.Vec) -> None:
        with r.localForm() as local:
            local.set(0)
        with self.stopwatch.time_assembly():
            fem_petsc.assemble_vector(r, self.solid.residual)
        r.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        for condition in self._held:
            dofs, owned = condition.dof_indices()
            r.array[dofs[:owned]] = 0.0

    def _tangent(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        self._go_to_vector(x)
        P.zeroEntries()
        self.solid.tangent.move_linearisation_point()
        with self.stopwatch.time_assembly():
            fem_petsc.assemble_matrix(P, self.solid.tangent.form, self._held)
            P.assemble()
        self.stopwatch.count_factorisation()
        if self._viscosity is not None:
            same = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
            P.axpy(self._viscosity.k, self._viscosity.mass.petsc, same)


def _in_words(reason: int) -> str:
    """Say why an iteration ended."""
    kinds = PETSc.SNES.ConvergedReason
    words = {
        RESIDUAL_IS_NO_NUMBER: "an element was turned inside out",
        kinds.DIVERGED_DTOL: "the residual grew beyond all bounds",
        kinds.DIVERGED_MAX_IT: "too many iterations",
        kinds.DIVERGED_LINE_SEARCH: "no step of the line search lowers the residual",
    }
    names = {getattr(kinds, name): name for name in dir(kinds) if name.isupper()}
    return words.get(reason, f"PETSc's reason {names.get(reason, reason)}")
