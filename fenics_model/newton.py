"""Newton's method on a residual and its tangent: PETSc's SNES, open to the user's options."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from bilayer.errors import InputError
from fenics_model.tangent import ExtrapolatedTangent

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

_WRONG_OPTION = (56, 60, 62, 63, 83, 86, 92)
"""PETSc's codes: unsupported, unequal, wrong, out of range, unreadable, unknown or absent."""


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
        PETSc's word for how it ended.
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
        self._options = options
        with _options_in_force(options), _option_errors(options):
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
        with self._in_force():  # MUMPS reads its own when it first factorises
            self.snes.solve(None, self._x)
        self._set_state(self._x)
        reason = self.snes.getConvergedReason()
        iterations = self.snes.getIterationNumber()
        return NewtonOutcome(
            converged=reason > 0,
            iterations=iterations,
            residual=float(self.snes.getFunctionNorm()),
            correction=float(self.snes.getSolutionUpdate().norm()) if iterations else 0.0,
            reason=_reason_name(reason),
        )

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
        with self._in_force():
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

    @contextmanager
    def _in_force(self) -> Iterator[None]:
        with _options_in_force(self._options), _option_errors(self._options):
            yield

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

    def _assemble_residual(self, r: PETSc.Vec) -> None:
        with r.localForm() as local:
            local.set(0)
        fem_petsc.assemble_vector(r, self._residual_form)
        r.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        for condition in self._held:
            dofs, owned = condition.dof_indices()
            r.array[dofs[:owned]] = 0.0

    def _tangent(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        self._set_state(x)
        P.zeroEntries()
        self._extrapolated.advance()
        fem_petsc.assemble_matrix(P, self._extrapolated.form, self._held)
        P.assemble()
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


@contextmanager
def _options_in_force(text: str) -> Iterator[None]:
    """Put the defaults, what the database already holds and `text` in force, in that order."""
    database = PETSc.Options()
    before = dict(database.getAll())
    for name, value in DEFAULT_OPTIONS.items():
        if PREFIX + name not in before:
            database.setValue(PREFIX + name, value)
    database.insertString(text)
    try:
        yield
    finally:
        for name in set(database.getAll()) - set(before):
            database.delValue(name)
        for name, value in before.items():
            database.setValue(name, value)


@contextmanager
def _option_errors(text: str) -> Iterator[None]:
    """Turn PETSc's complaint about an option's value into an error in one line.

    Raises
    ------
    InputError
        An option names a method that PETSc does not have.
    """
    try:
        yield
    except PETSc.Error as error:
        if error.ierr not in _WRONG_OPTION:
            raise
        complaint = str(error).splitlines()[-1].split("] ")[-1]
        raise InputError(
            f"solver.petsc_options = {text!r}: expected options that this PETSc knows ({complaint})"
        ) from error


def _reason_name(reason: int) -> str:
    kinds = PETSc.SNES.ConvergedReason
    names = {getattr(kinds, name): name for name in dir(kinds) if name.isupper()}
    return names.get(reason, str(reason))
