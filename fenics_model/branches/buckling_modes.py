"""The unstable modes of an equilibrium: K d = k M d with k < 0, by SLEPc.

K is the mixed tangent and M the displacements' mass matrix, which is zero for the pressures: these
follow each mode in balance, so the eigenvalues are those of the displacements alone. Shift and
invert about 0 needs the factors of K, which the count of the unstable modes has made. The inverse
has an end of its spectrum for each sign, so the few negative eigenvalues are found soon, however
many soft stable modes lie nearer to 0.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

from fenics_model.solve.factors import Factors
from fenics_model.solve.layout import AssembledMatrix, Layout

ACCURACY = 1e-6
"""Relative, of an eigenvalue: a mode is a direction to leave in, no result."""

Array = NDArray[np.float64]
Key = Callable[[float], tuple[bool, float]]
"""Of an eigenvalue; those of the least are sought."""


@dataclass(frozen=True, eq=False)
class BucklingMode:
    """A direction in which the body leaves an unstable equilibrium.

    Parameters
    ----------
    stiffness : float
        k < 0, Pa/m2.
    direction : array of float
        Change of the state, its displacements of rms 1 m over the body.
    """

    stiffness: float
    direction: Array


def buckling_modes(
    factors: Factors, mass: AssembledMatrix, count: int, side: Array
) -> list[BucklingMode]:
    """Compute the unstable modes of an equilibrium, the most unstable one first.

    Parameters
    ----------
    factors : Factors
        Of its tangent.
    mass : AssembledMatrix
        M.
    count : int
        Number of unstable modes, see `stability.unstable_modes`.
    side : array of float
        A change of the state; each mode points to its side.

    Returns
    -------
    list of BucklingMode
        Fewer than `count` if SLEPc does not find them all.
    """
    pairs = _eigenpairs(factors, mass, side, count, _unstable_first)
    unstable = [_mode(*pair, mass, factors.layout, side) for pair in pairs if pair[0] < 0]
    return sorted(unstable, key=lambda mode: mode.stiffness)


def least_stiffness(factors: Factors, mass: AssembledMatrix, start: Array) -> float:
    """Compute the k nearest to 0 of an equilibrium, Pa/m2.

    Parameters
    ----------
    factors : Factors
        Of its tangent.
    mass : AssembledMatrix
        M.
    start : array of float
        A change of the state that the iteration starts with.
    """
    return _eigenpairs(factors, mass, start, 1, _nearest_first)[0][0]


def _nearest_first(value: float) -> tuple[bool, float]:
    return False, abs(value)


def _unstable_first(value: float) -> tuple[bool, float]:
    """Return a key by which no soft stable mode hides an unstable one that is far from 0."""
    return value >= 0, abs(value)


def _eigenpairs(
    factors: Factors, mass: AssembledMatrix, start: Array, wanted: int, key: Key
) -> list[tuple[float, Array]]:
    """Return some eigenvalues and their eigenvectors, those of the least key first."""
    layout = factors.layout
    with (
        layout.vectors(start, None) as (first, vector),
        _eigenvalue_solver(factors, mass, first, wanted, key) as solver,
    ):
        solver.solve()
        return [
            (float(solver.getEigenpair(index, vector).real), layout.read(vector))
            for index in range(solver.getConverged())
        ]


@contextmanager
def _eigenvalue_solver(
    factors: Factors, mass: AssembledMatrix, first: PETSc.Vec, wanted: int, key: Key
) -> Iterator[SLEPc.EPS]:
    """Set up SLEPc to invert with the factors meanwhile."""

    def compare(one: complex, other: complex, _: object) -> int:
        keys = key(one.real), key(other.real)
        return int(keys[0] > keys[1]) - int(keys[0] < keys[1])

    linear, solver = factors.solver, SLEPc.EPS().create(factors.layout.comm)
    try:
        solver.setOperators(factors.matrix, mass.petsc)
        solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
        transform = solver.getST()
        transform.setType(SLEPc.ST.Type.SINVERT)
        transform.setKSP(linear)
        solver.setTarget(0.0)
        solver.setWhichEigenpairs(SLEPc.EPS.Which.USER)
        solver.setEigenvalueComparison(compare)
        solver.setDimensions(nev=wanted)
        solver.setTolerances(ACCURACY)
        solver.setInitialSpace([first])
        yield solver
    finally:
        solver.destroy()
        linear.setErrorIfNotConverged(False)  # which SLEPc switched on


def _mode(
    stiffness: float, direction: Array, mass: AssembledMatrix, layout: Layout, side: Array
) -> BucklingMode:
    toward = layout.dot(mass.times(direction), side)
    scale = np.copysign(rms_displacement(direction, mass, layout), toward)
    return BucklingMode(stiffness, direction / scale)


def rms_displacement(change: Array, mass: AssembledMatrix, layout: Layout) -> float:
    """Return the root mean square of the displacements in a change of state, over the body, m."""
    ones = np.ones_like(change)
    thrice_volume = layout.dot(mass.times(ones), ones)  # of (1, 1, 1) everywhere
    return float(np.sqrt(3 * layout.dot(mass.times(change), change) / thrice_volume))
