"""The sparse solvers: solutions, and negative eigenvalues against a dense count."""

from importlib.util import find_spec

import numpy as np
import pytest
from scipy.sparse import csc_matrix, diags, random

from dshell.solve.linear_solver import (
    CholmodSolver,
    MumpsSolver,
    NotPositiveDefiniteError,
    SingularMatrixError,
    SuperLUSolver,
)

SOLVERS = [SuperLUSolver]
if find_spec("petsc4py"):
    SOLVERS += [MumpsSolver, CholmodSolver]


@pytest.fixture(params=SOLVERS)
def solver(request):
    return request.param()


def symmetric(seed, shift):
    rough = random(60, 60, density=0.08, random_state=seed)
    return csc_matrix(rough + rough.T + diags(np.full(60, shift)))


def test_solutions_and_negative_eigenvalues(solver):
    for shift in (3.0, 0.7, -0.2):
        matrix = symmetric(1, shift)
        factor = solver.factor(matrix)
        assert factor.negative == np.count_nonzero(np.linalg.eigvalsh(matrix.toarray()) < 0)
        right = np.arange(60.0)
        assert matrix @ factor.solve(right) == pytest.approx(right, abs=1e-9)


def test_cholesky_tells_whether_all_eigenvalues_are_positive(solver):
    for shift in (3.0, -0.2, 2.5, 0.7, 3.5):
        matrix = symmetric(1, shift)
        right = np.arange(60.0)
        if np.linalg.eigvalsh(matrix.toarray())[0] > 0:
            assert matrix @ solver.cholesky(matrix).solve(right) == pytest.approx(right, abs=1e-9)
        else:
            with pytest.raises(NotPositiveDefiniteError):
                solver.cholesky(matrix)


def test_no_stiffness_at_all_is_singular(solver):
    zero = csc_matrix((np.zeros(3), np.arange(3), np.arange(4)), shape=(3, 3))
    with pytest.raises(SingularMatrixError, match="singular"):
        solver.factor(zero)
    with pytest.raises(NotPositiveDefiniteError):
        solver.cholesky(zero)
