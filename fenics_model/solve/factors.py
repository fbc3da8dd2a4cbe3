"""The factors of one tangent, handed to whoever solves with them or counts their pivots."""

from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from bilayer.errors import ComputationError
from fenics_model.solve.layout import Layout

_ERROR, _NEGATIVE_PIVOTS = 1, 12
"""MUMPS' INFOG(1), and INFOG(12) for symmetric matrices."""

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


_PETSC_FAILURES = {
    55: "out of memory",
    71: "a pivot is zero",
    72: "not a number",
    76: "MUMPS failed",
}
"""PETSc's error codes for what a shorter step may avoid."""


class ExpiredFactorsError(RuntimeError):
    """The factors were released, or their solver has factorised another tangent since."""


class Factors:
    """The factors L D L' of a tangent, until they are released or the next tangent is factorised.

    They live in the memory of the solver that made them, which has room for one tangent.

    Parameters
    ----------
    solver : PETSc KSP
        Holds them.
    matrix : PETSc Mat
        The tangent.
    layout : Layout
        Of its vectors.
    failure : str
        Why PETSc made none; empty if it went through.
    """

    def __init__(
        self, solver: PETSc.KSP, matrix: PETSc.Mat, layout: Layout, failure: str = ""
    ) -> None:
        self._solver, self._matrix, self._layout = solver, matrix, layout
        self._failure = failure
        self._is_valid = True

    def __enter__(self) -> "Factors":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()

    def release(self) -> None:
        """Give the memory back to the solver."""
        self._is_valid = False

    @property
    def solver(self) -> PETSc.KSP:
        """The linear solver that solves with them."""
        self._check()
        return self._solver

    @property
    def matrix(self) -> PETSc.Mat:
        """The tangent itself."""
        self._check()
        return self._matrix

    @property
    def layout(self) -> Layout:
        """Of the tangent's vectors."""
        return self._layout

    @property
    def failure(self) -> str:
        """The reason why the factorisation failed; empty if it did not."""
        return self._failure or why_factorisation_failed(self._preconditioner)

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative pivots; None if the factorisation failed or does not tell."""
        if self.failure:
            return None
        factors = self._preconditioner
        tells = (
            factors.getType() == PETSc.PC.Type.CHOLESKY
            and factors.getFactorSolverType() == PETSc.Mat.SolverType.MUMPS
        )
        return int(factors.getFactorMatrix().getMumpsInfog(_NEGATIVE_PIVOTS)) if tells else None

    def solve(self, right: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the change of state for a right side, both with ghosts.

        Raises
        ------
        ComputationError
            There are no factors, because the factorisation failed.
        """
        if self.failure:
            raise ComputationError(self.failure)
        with self._layout.vectors(right, None) as (side, change):
            try:
                self.solver.solve(side, change)
            except PETSc.Error as error:
                raise ComputationError(
                    f"the linear solver failed (PETSc's error {error.ierr})"
                ) from error
            return self._layout.read(change)

    @property
    def _preconditioner(self) -> PETSc.PC:
        return self.solver.getPC()

    def _check(self) -> None:
        if not self._is_valid:
            raise ExpiredFactorsError("these factors are no longer there")


def why_petsc_failed(error: PETSc.Error) -> str:
    """Return in words why PETSc gave up a factorisation, if a shorter step may avoid that.

    Raises
    ------
    PETSc.Error
        Nothing of the kind.
    """
    if error.ierr not in _PETSC_FAILURES:
        raise error
    return f"PETSc: {_PETSC_FAILURES[error.ierr]}"


def why_factorisation_failed(factors: PETSc.PC) -> str:
    """Return in words what went wrong in a factorisation, by MUMPS' own number if it has one.

    It is empty if nothing did. Source: MUMPS Users' guide, section "Error and warning diagnostics".
    """
    kind = factors.getFailedReason()
    if not kind:
        return ""
    if factors.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
        return f"the linear solver failed, PETSc's reason {kind}"
    number = factors.getFactorMatrix().getMumpsInfog(_ERROR)
    return f"the factorisation failed: {_MUMPS_FAILURES.get(number, f'error {number} of MUMPS')}"
