"""The unstable modes of an equilibrium: K d = k M d with k < 0, by SLEPc.

K is the mixed tangent and M the displacements' mass matrix, which is zero for the pressures: these
follow each mode in balance, so the eigenvalues are those of the displacements alone. Shift and
invert about 0 needs the factors of K, which the count of the unstable modes has left.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

from fenics_model.solve.newton import Newton

BESIDE = 4
"""Eigenvalues that are asked for beyond the unstable ones: stable modes may lie nearer to 0."""

ACCURACY = 1e-6
"""Relative, of an eigenvalue: a mode is a direction to leave in, no result."""


@dataclass(frozen=True)
class BucklingMode:
    """A direction in which the body leaves an unstable equilibrium.

    Parameters
    ----------
    stiffness : float
        k < 0, Pa/m2.
    direction : array of float
        Change of this rank's own dofs, its displacements of rms 1 m over the body.
    """

    stiffness: float
    direction: NDArray[np.float64]


def buckling_modes(
    newton: Newton, mass: PETSc.Mat, count: int, side: NDArray[np.float64]
) -> list[BucklingMode]:
    """Compute the unstable modes of the solver's present state, the most unstable one first.

    Parameters
    ----------
    newton : Newton
        Its state is an equilibrium, whose tangent it has just factorised.
    mass : PETSc Mat
        M; its rows of held dofs are zero, see `Newton.assembled`.
    count : int
        Number of unstable modes, see `stability.unstable_modes`.
    side : array of float
        A change of the state, this rank's own dofs first; each mode points to its side.

    Returns
    -------
    list of BucklingMode
        Fewer than `count` where stable modes that are as soft hide the others.
    """
    toward = newton.vector()
    toward.array[:] = side[: toward.local_size]
    solver = _eigenvalue_solver(newton, mass, toward, count + BESIDE)
    _solve(solver, newton)
    found = [_mode(solver, index, mass, toward) for index in range(solver.getConverged())]
    solver.destroy()
    unstable = [mode for mode in found if mode.stiffness < 0]
    return sorted(unstable, key=lambda mode: mode.stiffness)


def least_stiffness(newton: Newton, mass: PETSc.Mat) -> float:
    """Compute the k nearest to 0 of the solver's present state, Pa/m2.

    Parameters
    ----------
    newton : Newton
        Its state is an equilibrium, whose tangent it has just factorised.
    mass : PETSc Mat
        M, see `buckling_modes`.
    """
    solver = _eigenvalue_solver(newton, mass, newton.vector(), 1)
    _solve(solver, newton)
    stiffness = float(solver.getEigenvalue(0).real)
    solver.destroy()
    return stiffness


def _solve(solver: SLEPc.EPS, newton: Newton) -> None:
    solver.solve()
    newton.snes.getKSP().setErrorIfNotConverged(False)  # which SLEPc switched on


def _eigenvalue_solver(newton: Newton, mass: PETSc.Mat, begin: PETSc.Vec, wanted: int) -> SLEPc.EPS:
    solver = SLEPc.EPS().create(newton.matrix.comm)
    solver.setOperators(newton.matrix, mass)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    transform.setKSP(newton.snes.getKSP())  # with its factors
    solver.setTarget(0.0)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setDimensions(nev=wanted)
    solver.setTolerances(ACCURACY)
    solver.setInitialSpace([begin])
    return solver


def _mode(solver: SLEPc.EPS, index: int, mass: PETSc.Mat, toward: PETSc.Vec) -> BucklingMode:
    direction, inertia = toward.duplicate(), toward.duplicate()
    stiffness = float(solver.getEigenpair(index, direction).real)
    mass.mult(direction, inertia)
    scale = np.copysign(rms_displacement(direction, mass), inertia.dot(toward))
    return BucklingMode(stiffness, direction.array_r / scale)


def rms_displacement(change: PETSc.Vec, mass: PETSc.Mat) -> float:
    """Root mean square of the displacements in a change of the state, over the body, m."""
    ones, image = change.duplicate(), change.duplicate()
    ones.set(1.0)
    mass.mult(ones, image)
    thrice_volume = image.dot(ones)  # of (1, 1, 1) everywhere
    mass.mult(change, image)
    return float(np.sqrt(3 * image.dot(change) / thrice_volume))
