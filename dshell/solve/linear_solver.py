"""Sparse symmetric systems: one small interface, by PETSc if it is installed, else by SciPy.

There are two factorisations. L L' of a positive definite matrix: its failure shows the static
solver that a state is not stable. L D L' of any matrix: it shows the number of negative eigenvalues
(by Sylvester's law of inertia, that of the negative pivots in D). PETSc's solvers find their
ordering once for all matrices of one sparsity pattern that follow each other.
"""

from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from bilayer.errors import ComputationError
from bilayer.runtime.petsc import start_petsc

Array = NDArray[np.float64]


_MUMPS_ERROR, _MUMPS_NEGATIVE_PIVOTS = 1, 12  # places in INFOG
_MUMPS_ORDERING_TAKEN = 7
MUMPS_ORDERINGS = {
    "automatic": 7,
    "amd": 0,
    "amf": 2,
    "scotch": 3,
    "pord": 4,
    "metis": 5,
    "qamd": 6,
}
"""MUMPS's numbers, ICNTL(7), of its orderings; it takes another if one was not built in."""
_PETSC_BAD_CHOLESKY_PIVOT = 81  # PETSC_ERR_MAT_CH_ZRPVT


class SingularMatrixError(ComputationError):
    """A matrix has no factorisation."""


class NotPositiveDefiniteError(ComputationError):
    """A matrix has an eigenvalue that is not positive."""


class Factor(Protocol):
    """A factorised matrix, good until its solver factorises the next one in the same way."""

    def solve(self, right_side: Array) -> Array:
        """Return the solution of the system."""


class IndefiniteFactor(Factor, Protocol):
    """A factor L D L'."""

    negative: int
    """Number of negative eigenvalues."""


class LinearSolver(Protocol):
    """Factorises symmetric matrices that share one sparsity pattern."""

    name: str

    def cholesky(self, matrix: csc_matrix) -> Factor:
        """Return a factor of a positive definite matrix, or raise NotPositiveDefiniteError."""

    def factor(self, matrix: csc_matrix) -> IndefiniteFactor:
        """Return a factor of any matrix; SingularMatrixError if there is none."""


class SuperLUSolver:
    """SciPy's SuperLU with pivots on the diagonal, so that U's diagonal is D of L D L'."""

    name = "superlu"

    def cholesky(self, matrix: csc_matrix) -> Factor:
        """See `LinearSolver`."""
        return _factor_definite(self, matrix)

    def factor(self, matrix: csc_matrix) -> IndefiniteFactor:
        """See `LinearSolver`."""
        return _SuperLUFactor(matrix)


class _SuperLUFactor:
    def __init__(self, matrix: csc_matrix) -> None:
        try:
            self._factors = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SingularMatrixError(f"the stiffness is singular ({error})") from error
        self.solve = self._factors.solve
        self.negative = int(np.count_nonzero(self._factors.U.diagonal() < 0))


class MumpsSolver:
    """MUMPS through PETSc: L D L' of any matrix.

    Parameters
    ----------
    ordering : str
        One of `MUMPS_ORDERINGS`.
    """

    def __init__(self, ordering: str = "automatic") -> None:
        self.name = f"mumps {ordering}"
        self._petsc = _PetscSystem("mumps", {"icntl_7": MUMPS_ORDERINGS[ordering]})

    @property
    def used_ordering(self) -> str:
        """The ordering that MUMPS took for the last matrix."""
        number = self._petsc.package_data.getMumpsInfog(_MUMPS_ORDERING_TAKEN)
        return {code: name for name, code in MUMPS_ORDERINGS.items()}.get(number, str(number))

    def cholesky(self, matrix: csc_matrix) -> Factor:
        """See `LinearSolver`."""
        return _factor_definite(self, matrix)

    def factor(self, matrix: csc_matrix) -> IndefiniteFactor:
        """See `LinearSolver`."""
        self._petsc.factorise(matrix)
        return _MumpsFactor(self._petsc)


class CholmodSolver:
    """CHOLMOD through PETSc: L L' by supernodes; it has no L D L', which is left to MUMPS."""

    name = "cholmod"

    def __init__(self) -> None:
        # supernodes at any size, because the other way does not notice negative pivots
        self._petsc = _PetscSystem("cholmod", {"supernodal_switch": 0, "print": 0})
        self._mumps = MumpsSolver()

    def cholesky(self, matrix: csc_matrix) -> Factor:
        """See `LinearSolver`."""
        try:
            self._petsc.factorise(matrix)
        except self._petsc.Error as error:
            if error.ierr != _PETSC_BAD_CHOLESKY_PIVOT:
                raise
            raise NotPositiveDefiniteError("the stiffness is not positive definite") from error
        return self._petsc

    def factor(self, matrix: csc_matrix) -> IndefiniteFactor:
        """See `LinearSolver`."""
        return self._mumps.factor(matrix)


class _PetscSystem:
    """The upper half of a matrix in PETSc, its direct solver, and the factor that it holds."""

    def __init__(self, package: str, options: dict[str, float]) -> None:
        start_petsc()
        from petsc4py import PETSc

        self._petsc = PETSc
        self.Error = PETSc.Error
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setType(PETSc.KSP.Type.PREONLY)
        self._solver.setOptionsPrefix("dshell_")
        preconditioner = self._solver.getPC()
        preconditioner.setType(PETSc.PC.Type.CHOLESKY)
        preconditioner.setFactorSolverType(package)
        self._options = {f"mat_{package}_{name}": value for name, value in options.items()}
        self._matrix: Any = None
        self._analysed = False

    @property
    def package_data(self) -> Any:
        """The factor as PETSc's matrix, which has its package's own data."""
        return self._solver.getPC().getFactorMatrix()

    def factorise(self, matrix: csc_matrix) -> None:
        if self._is_of_another_pattern(matrix):
            self._keep_pattern(matrix)
        # by columns the lower half is by rows the upper one, because the matrix is symmetric
        self._matrix.setValuesCSR(*self._pattern, matrix.data[self._half])
        self._matrix.assemble()
        self._solver.setOperators(self._matrix)
        try:
            self._solver.setUp()
        except self.Error:
            if not self._analysed:  # PETSc would analyse again, into a factor that is no longer new
                self._solver.reset()
            raise
        self._analysed = True

    def _is_of_another_pattern(self, matrix: csc_matrix) -> bool:
        """Whether the matrix needs an ordering of its own, as when contacts open or close."""
        if self._matrix is None:
            return True
        starts, rows = self._whole_pattern
        if starts is matrix.indptr and rows is matrix.indices:
            return False
        same = np.array_equal(starts, matrix.indptr) and np.array_equal(rows, matrix.indices)
        return not same

    def _keep_pattern(self, matrix: csc_matrix) -> None:
        if self._matrix is not None:
            self._solver.reset()
            self._matrix.destroy()
            self._analysed = False
        self._whole_pattern = matrix.indptr, matrix.indices
        for name, value in self._options.items():  # not before: PETSc warns of options not used
            self._petsc.Options("dshell_")[name] = value
        size = matrix.shape[0]
        columns = np.repeat(np.arange(size), np.diff(matrix.indptr))
        self._half = np.flatnonzero(matrix.indices >= columns)
        starts = np.searchsorted(columns[self._half], np.arange(size + 1))
        places = (starts, matrix.indices[self._half])
        self._pattern = tuple(kind.astype(self._petsc.IntType) for kind in places)
        self._matrix = self._petsc.Mat().createSBAIJ(
            matrix.shape, 1, csr=(*self._pattern, matrix.data[self._half]),
            comm=self._petsc.COMM_SELF,
        )  # fmt: skip

    def solve(self, right_side: Array) -> Array:
        """See `Factor`."""
        solution = np.empty_like(right_side)
        vectors = (
            self._petsc.Vec().createWithArray(array, comm=self._petsc.COMM_SELF)
            for array in (right_side, solution)
        )
        self._solver.solve(*vectors)
        return solution


class _MumpsFactor:
    def __init__(self, system: _PetscSystem) -> None:
        data = system.package_data
        if data.getMumpsInfog(_MUMPS_ERROR) < 0:
            raise SingularMatrixError(
                f"the stiffness is singular (MUMPS: {data.getMumpsInfog(_MUMPS_ERROR)})"
            )
        self.solve = system.solve
        self.negative = int(data.getMumpsInfog(_MUMPS_NEGATIVE_PIVOTS))


def best_linear_solver() -> LinearSolver:
    """Return CHOLMOD if petsc4py is there, SuperLU otherwise."""
    return CholmodSolver() if find_spec("petsc4py") else SuperLUSolver()


def _factor_definite(solver: LinearSolver, matrix: csc_matrix) -> Factor:
    """Return the factor L D L' of a matrix whose pivots are all positive."""
    try:
        factor = solver.factor(matrix)
    except SingularMatrixError as error:
        raise NotPositiveDefiniteError(str(error)) from error
    if factor.negative > 0:
        raise NotPositiveDefiniteError(f"the stiffness has {factor.negative} negative eigenvalues")
    return factor
