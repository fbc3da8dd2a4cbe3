"""Stability from the inertia of the tangent, which the factorisation L D L' shows.

At a stable equilibrium the mixed tangent has one negative pivot for each pressure (the energy is
minimal in the displacements, maximal in the pressures); every further one is an unstable mode.
"""

from petsc4py import PETSc

from bilayer.results.schema import UNKNOWN_STABILITY
from fenics_model.solve.newton import Newton

_NEGATIVE_PIVOTS = 12  # MUMPS' INFOG(12) for symmetric matrices


def unstable_modes(newton: Newton, number_of_pressures: int) -> int:
    """Count the unstable modes of the solver's present state, by one factorisation.

    Parameters
    ----------
    newton : Newton
        Its state is an equilibrium.
    number_of_pressures : int
        Pressure unknowns that are not held; those that are have a positive unit diagonal.

    Returns
    -------
    int
        -1 where the factorisation failed, or the user's options chose another, which does not tell.
    """
    return unstable_modes_of(newton.factorise(), number_of_pressures)


def unstable_modes_of(factors: PETSc.PC, number_of_pressures: int) -> int:
    """Count the unstable modes that a factorisation made earlier shows; see `unstable_modes`."""
    tells = (
        factors.getType() == PETSc.PC.Type.CHOLESKY
        and factors.getFactorSolverType() == PETSc.Mat.SolverType.MUMPS
        and not factors.getFailedReason()
    )
    if not tells:
        return UNKNOWN_STABILITY
    factor = factors.getFactorMatrix()
    return int(factor.getMumpsInfog(_NEGATIVE_PIVOTS)) - number_of_pressures
