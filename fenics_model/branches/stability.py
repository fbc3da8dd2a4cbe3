"""Stability from the inertia of the tangent, which the factorisation L D L' shows.

At a stable equilibrium the mixed tangent has one negative pivot for each pressure (the energy is
minimal in the displacements, maximal in the pressures); every further one is an unstable mode.
"""

from bilayer.results.schema import UNKNOWN_STABILITY
from fenics_model.solve.factors import Factors


def unstable_modes(factors: Factors, number_of_pressures: int) -> int:
    """Count the unstable modes of the state whose tangent was factorised.

    Parameters
    ----------
    factors : Factors
        Of the tangent.
    number_of_pressures : int
        Pressure unknowns that are not held; those that are have a positive unit diagonal.

    Returns
    -------
    int
        -1 if the factorisation failed, or the user's options chose another, which does not tell.
    """
    negative = factors.negative_pivots
    return UNKNOWN_STABILITY if negative is None else negative - number_of_pressures
