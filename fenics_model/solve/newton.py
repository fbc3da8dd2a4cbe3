"""Newton's method on a residual and its tangent: PETSc's SNES, open to the user's options."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from fenics_model.api.dolfinx_api import RESIDUAL_IS_NO_NUMBER
from fenics_model.solid.tangent import ExtrapolatedTangent
from fenics_model.solve.interruption import Interruption, interruption_put_off
from fenics_model.solve.petsc_options import UserOptions
from fenics_model.solve.work import Stopwatch

PREFIX = "bilayer_"
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

_MUMPS_FAILURES = {
    -5: "out of memory",
    -7: "out of memory",
    -8: "its workspace is too small",
    -9: "its workspace is too small",
    -10: "the tangent is singular",
    -13: "out of memory",
    -19: "more memory needed than allowed",
    -20: "its buffer is too small",
}


@dataclass(frozen=True)
class NewtonOutcome:
    """How a solution ended.

    Parameters
    ----------
    converged : bool
        Whether the residual fell to the tolerance.
    iterations : int
        Factorisations that it took.
    residual : float
        Final norm of the residual.
    correction : float
        Norm of the last correction.
    reason : str
        Why it failed, in a few words; empty where it converged.
    """

    converged: bool
    iterations: int
    residual: float
    correction: float
    reason: str


class Viscosity:
    """A force k M (x - origin) beside the residual.

    Parameters
    ----------
    mass : PETSc Mat
        M, with the sparsity of the tangent, see `Newton.assembled`.
    k : float
        Viscosity over time step.
    origin : PETSc Vec
        Where the motion starts.
    """

    def __init__(self, mass: PETSc.Mat, k: float, origin: PETSc.Vec) -> None:
        self.mass, self.k, self._origin = mass, k, origin
        self._motion, self._force = origin.duplicate(), origin.duplicate()

    def force(self, x: PETSc.Vec) -> PETSc.Vec:
        """Return the force at x."""
        self._motion.waxpy(-1.0, self._origin, x)
        self.mass.mult(self._motion, self._force)
        self._force.scale(self.k)
        return self._force

    def norm_and_work(self, x: PETSc.Vec) -> tuple[float, float]:
        """Return the norm of the force at x, N, and the work that the motion took, J."""
        force = self.force(x)
        return float(force.norm()), float(force.dot(self._motion))

    def destroy(self) -> None:
        """Free what PETSc holds, but for the mass."""
        for held in (self._origin, self._motion, self._force):
            held.destroy()


class Newton:
    """Solves residual(state) = 0 with some dofs of the state held.

    Parameters
    ----------
    residual : dolfinx.fem.Form
        Of a symmetric problem.
    tangent : ExtrapolatedTangent
        Its derivative.
    state : dolfinx.fem.Function
        The unknown: initial guess before, solution after.
    held : sequence of dolfinx.fem.DirichletBC
        Constraints.
    iteration_limit : int
        Iterations after which it has failed.
    options : str
        PETSc options that win over `DEFAULT_OPTIONS` and over the global options database.
    stopwatch : Stopwatch, optional
        Told of the work.
    """

    def __init__(
        self,
        residual: fem.Form,
        tangent: ExtrapolatedTangent,
        state: fem.Function,
        held: Sequence[fem.DirichletBC],
        *,
        iteration_limit: int = 20,
        options: str = "",
        stopwatch: Stopwatch | None = None,
    ) -> None:
        self._residual_form, self._extrapolated = residual, tangent
        self.state, self._held = state, list(held)
        self._x, self._r = (_vector_of(state) for _ in range(2))
        self.matrix = fem_petsc.create_matrix(tangent.form)
        self.matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self.matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        self.snes = PETSc.SNES().create(state.function_space.mesh.comm)
        self.snes.setOptionsPrefix(PREFIX)
        self.snes.setFunction(self._residual, self._r)
        self.snes.setJacobian(self._tangent, self.matrix)
        self.snes.setTolerances(max_it=iteration_limit)
        self._viscosity: Viscosity | None = None
        self._interruption = Interruption()
        self._stopwatch = Stopwatch() if stopwatch is None else stopwatch
        self._options = UserOptions(options, DEFAULT_OPTIONS, PREFIX)
        with self._options.in_force():
            self.snes.setFromOptions()

    def destroy(self) -> None:
        """Free what PETSc holds."""
        for held in (self.snes, self.matrix, self._x, self._r):
            held.destroy()

    def solve(self, tolerance: float) -> NewtonOutcome:
        """Iterate until the norm of the residual falls to `tolerance`.

        Where that fails the state is where the iteration left it.
        """
        self._apply_held()
        self._extrapolated.forget()
        self._drop_failed_factors()
        self.snes.setTolerances(atol=tolerance)
        self._x.array[:] = self.state.x.array[: self._x.local_size]
        reason = self._iterate()
        self._set_state(self._x)
        iterations = self.snes.getIterationNumber()
        if iterations:
            self._options.check_all_used()
        return NewtonOutcome(
            converged=not reason,
            iterations=iterations,
            residual=float(self.snes.getFunctionNorm()),
            correction=float(self.snes.getSolutionUpdate().norm()) if iterations else 0.0,
            reason=reason,
        )

    def _iterate(self) -> str:
        """Run PETSc's iteration from `_x`; return why it failed, or an empty text."""
        with (
            interruption_put_off() as self._interruption,
            self._stopwatch.solving(),
            self._options.in_force(),
        ):
            try:
                self.snes.solve(None, self._x)
            except PETSc.Error as error:
                if error.ierr not in _FAILURES:
                    raise
                return f"PETSc: {_FAILURES[error.ierr]}"
        reason = self.snes.getConvergedReason()
        if reason > 0:
            return ""
        if reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE:
            return why_factorisation_failed(self.factors)
        return _in_words(reason)

    def residual_norm(self) -> float:
        """Norm of the residual of the present state, held dofs left out."""
        self._apply_held()
        self._assemble_residual(self._r)
        return float(self._r.norm())

    def factorise(self) -> PETSc.PC:
        """Factorise the tangent of the present state and return what holds the factors."""
        self._apply_held()
        self._extrapolated.forget()
        self._drop_failed_factors()
        self._x.array[:] = self.state.x.array[: self._x.local_size]
        self._tangent(self.snes, self._x, self.matrix, self.matrix)
        solver = self.snes.getKSP()
        solver.setOperators(self.matrix)
        with self._stopwatch.solving(), self._options.in_force():
            solver.setUp()
        return solver.getPC()

    def _drop_failed_factors(self) -> None:
        """Begin anew after a failed factorisation: PETSc would return it from then on."""
        if self.factors.getFailedReason():
            self.factors.reset()

    def corrections(self, *right: PETSc.Vec) -> list[PETSc.Vec]:
        """Solve with the factors of the last tangent for one or more right-hand sides."""
        found = [side.duplicate() for side in right]
        for side, correction in zip(right, found, strict=True):
            self.factors.apply(side, correction)
        return found

    @property
    def factors(self) -> PETSc.PC:
        """What holds the factors of the last tangent."""
        return self.snes.getKSP().getPC()

    @contextmanager
    def slowed(self, mass: PETSc.Mat, k: float) -> Iterator[Viscosity]:
        """Solve with a viscous force against leaving the present state meanwhile."""
        self._viscosity = Viscosity(mass, k, self.vector())
        try:
            yield self._viscosity
        finally:
            self._viscosity.destroy()
            self._viscosity = None

    def move_to(self, x: PETSc.Vec) -> None:
        """Make x the present state."""
        self._set_state(x)

    def residual(self) -> PETSc.Vec:
        """Return the residual of the present state, held dofs left out."""
        self._apply_held()
        self._assemble_residual(self._r)
        return self._r.copy()

    def vector(self) -> PETSc.Vec:
        """Return a copy of the present state."""
        copy = self._x.duplicate()
        copy.array[:] = self.state.x.array[: copy.local_size]
        return copy

    def assembled(self, form: fem.Form) -> PETSc.Mat:
        """Assemble a form on the same space; the rows and columns of held dofs are zero."""
        matrix = fem_petsc.create_matrix(form)
        fem_petsc.assemble_matrix(matrix, form, self._held, 0.0)
        matrix.assemble()
        return matrix

    def _apply_held(self) -> None:
        """Give the held dofs their values, so that no correction is due there."""
        for condition in self._held:
            condition.set(self.state.x.array)
        self.state.x.scatter_forward()

    def _set_state(self, x: PETSc.Vec) -> None:
        self.state.x.array[: x.local_size] = x.array_r
        self.state.x.scatter_forward()

    def _residual(self, snes: PETSc.SNES, x: PETSc.Vec, r: PETSc.Vec) -> None:
        self._set_state(x)
        self._assemble_residual(r)
        if self._viscosity is not None:
            r.axpy(1.0, self._viscosity.force(x))
        if self._interruption.asked_for:
            r.set(math.nan)  # ends the iteration

    def _assemble_residual(self, r: PETSc.Vec) -> None:
        with r.localForm() as local:
            local.set(0)
        with self._stopwatch.assembling():
            fem_petsc.assemble_vector(r, self._residual_form)
        r.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        for condition in self._held:
            dofs, owned = condition.dof_indices()
            r.array[dofs[:owned]] = 0.0

    def _tangent(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        self._set_state(x)
        P.zeroEntries()
        self._extrapolated.advance()
        with self._stopwatch.assembling():
            fem_petsc.assemble_matrix(P, self._extrapolated.form, self._held)
            P.assemble()
        self._stopwatch.count_factorisation()
        if self._viscosity is not None:
            same = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
            P.axpy(self._viscosity.k, self._viscosity.mass, same)


def _vector_of(state: fem.Function) -> PETSc.Vec:
    """Return a new ghosted vector laid out as the function's dofs."""
    dofs = state.function_space.dofmap
    block, index_map = dofs.index_map_bs, dofs.index_map
    sizes = index_map.size_local * block, index_map.size_global * block
    ghosts = index_map.ghosts.astype(PETSc.IntType)
    return PETSc.Vec().createGhost(ghosts, sizes, bsize=block, comm=state.function_space.mesh.comm)


def why_factorisation_failed(factors: PETSc.PC) -> str:
    """Return in words what went wrong in a factorisation, by MUMPS' own number if it has one.

    Source: MUMPS Users' guide, section "Error and warning diagnostics".
    """
    kind = factors.getFailedReason()
    if factors.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
        return f"the linear solver failed, PETSc's reason {kind}"
    number = factors.getFactorMatrix().getMumpsInfog(1)
    return f"the factorisation failed: {_MUMPS_FAILURES.get(number, f'error {number} of MUMPS')}"


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
