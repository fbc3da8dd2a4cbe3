"""Newton's method on a residual and its tangent: PETSc's SNES, open to the user's options."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

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


class Newton:
    """Solves residual(state) = 0 with some dofs of the state held.

    Parameters
    ----------
    residual, tangent : dolfinx.fem.Form
        Of a symmetric problem.
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
        tangent: fem.Form,
        state: fem.Function,
        held: Sequence[fem.DirichletBC],
        *,
        iteration_limit: int = 20,
        options: str = "",
    ) -> None:
        self._residual_form, self._tangent_form = residual, tangent
        self.state, self._held = state, list(held)
        self._x, self._r = (_vector_of(state) for _ in range(2))
        self.matrix = fem_petsc.create_matrix(tangent)
        self.matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        self.matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        self.snes = PETSc.SNES().create(state.function_space.mesh.comm)
        self.snes.setOptionsPrefix(PREFIX)
        self.snes.setFunction(self._residual, self._r)
        self.snes.setJacobian(self._tangent, self.matrix)
        self.snes.setTolerances(max_it=iteration_limit)
        self._options = options
        with _options_in_force(options):
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
        self.snes.setTolerances(atol=tolerance)
        self._x.array[:] = self.state.x.array[: self._x.local_size]
        with _options_in_force(self._options):  # MUMPS reads its own when it first factorises
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
        self._x.array[:] = self.state.x.array[: self._x.local_size]
        self._tangent(self.snes, self._x, self.matrix, self.matrix)
        solver = self.snes.getKSP()
        solver.setOperators(self.matrix)
        with _options_in_force(self._options):
            solver.setUp()
        return solver.getPC()

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
        fem_petsc.assemble_matrix(P, self._tangent_form, self._held)
        P.assemble()


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


def _reason_name(reason: int) -> str:
    kinds = PETSc.SNES.ConvergedReason
    names = {getattr(kinds, name): name for name in dir(kinds) if name.isupper()}
    return names.get(reason, str(reason))
