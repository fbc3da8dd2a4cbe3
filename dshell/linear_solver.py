"""Sparse symmetric systems: one small interface, PETSc where it is there, SciPy elsewhere.

A factor also tells the number of negative eigenvalues of its matrix (Sylvester's law of inertia:
as many as negative pivots of L D L'), which is how the static solver sees an unstable state.
"""

from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, triu
from scipy.sparse.linalg import splu

from bilayer.errors import ComputationError

Array = NDArray[np.float64]


_MUMPS_ERROR, _MUMPS_NEGATIVE_PIVOTS = 1, 12  # places in INFOG


class SingularMatrixError(ComputationError):
    """A matrix has no factorisation."""


class Factor(Protocol):
    """A factorised matrix."""

    negative: int
    """Number of negative eigenvalues."""

    def solve(self, right_side: Array) -> Array:
        """Return the solution of the system."""


class LinearSolver(Protocol):
    """Factorises symmetric matrices that share one sparsity pattern."""

    name: str

    def factor(self, matrix: csc_matrix) -> Factor:
        """Return the factor, good until the next call; SingularMatrixError where there is none."""


class SuperLUSolver:
    """SciPy's SuperLU with pivots on the diagonal, so that U's diagonal is D of L D L'."""

    name = "superlu"

    def factor(self, matrix: csc_matrix) -> Factor:
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
    """MUMPS through PETSc: L D L' of the upper half, whose ordering is found once."""

    name = "mumps"

    def __init__(self) -> None:
        from petsc4py import PETSc

        self._petsc = PETSc
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setType(PETSc.KSP.Type.PREONLY)
        preconditioner = self._solver.getPC()
        preconditioner.setType(PETSc.PC.Type.CHOLESKY)
        preconditioner.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        self._matrix: Any = None

    def factor(self, matrix: csc_matrix) -> Factor:
        """See `LinearSolver`."""
        upper = triu(matrix, format="csr")
        pattern = (kind.astype(self._petsc.IntType) for kind in (upper.indptr, upper.indices))
        csr = (*pattern, upper.data)
        if self._matrix is None:
            comm = self._petsc.COMM_SELF
            self._matrix = self._petsc.Mat().createSBAIJ(upper.shape, 1, csr=csr, comm=comm)
        else:
            self._matrix.setValuesCSR(*csr)
            self._matrix.assemble()
        self._solver.setOperators(self._matrix)
        self._solver.setUp()
        return _MumpsFactor(self._solver, self._petsc)


class _MumpsFactor:
    def __init__(self, solver: Any, petsc: Any) -> None:
        self._solver, self._petsc = solver, petsc
        factor = solver.getPC().getFactorMatrix()
        if factor.getMumpsInfog(_MUMPS_ERROR) < 0:
            raise SingularMatrixError(
                f"the stiffness is singular (MUMPS: {factor.getMumpsInfog(_MUMPS_ERROR)})"
            )
        self.negative = int(factor.getMumpsInfog(_MUMPS_NEGATIVE_PIVOTS))

    def solve(self, right_side: Array) -> Array:
        """See `Factor`."""
        vector, comm = self._petsc.Vec(), self._petsc.COMM_SELF
        solution = np.empty_like(right_side)
        self._solver.solve(
            vector.createWithArray(right_side, comm=comm),
            self._petsc.Vec().createWithArray(solution, comm=comm),
        )
        return solution


def best_linear_solver() -> LinearSolver:
    """Return MUMPS where petsc4py is there, SuperLU otherwise."""
    return MumpsSolver() if find_spec("petsc4py") else SuperLUSolver()
