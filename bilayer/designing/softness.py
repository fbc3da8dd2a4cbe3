"""The least stiffness of a shape: how near it is to a loss of stability.

A pressure in the shape of a displacement u bends an equilibrium by u. The least ratio of the two,

    mu = min u . K u / integral of u^2 over the flat area,

rigid motions left out, is the stiffness that `bilayer states` lists. It does not depend on the
mesh, and it is zero where stability is lost. It is computed from the inverse: forces on the
reference surface that are in equilibrium with each other, and the displacements that they cause. So
all that a solver needs is `bilayer.solvers.contract.Linearised`, whatever its other unknowns are.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from bilayer.errors import ComputationError
from bilayer.solvers.contract import Equilibrium, Linearised

Array = NDArray[np.float64]

TOLERANCE = 1e-5
"""Of the eigenvalue, relative; displacements are central differences."""


def least_stiffness(equilibrium: Equilibrium, equations: Linearised, node_areas: Array) -> float:
    """Return the least stiffness of an equilibrium, N/m3; negative if it is unstable.

    Parameters
    ----------
    equilibrium : Equilibrium
        Of a body that is not held.
    equations : Linearised
        Its equations there.
    node_areas : (n,) array of float
        Of the flat sheet, m2.

    Raises
    ------
    ComputationError
        The eigenvalue is not found.
    """
    roots = np.sqrt(node_areas)[:, None]
    rigid = np.linalg.qr((roots[..., None] * rigid_motions(equilibrium.position)).reshape(-1, 6))[0]

    def beyond_rigid(scaled: Array) -> Array:
        return scaled - rigid @ (rigid.T @ scaled)

    def give_way(scaled: Array) -> Array:
        force = roots * beyond_rigid(scaled.reshape(-1)).reshape(-1, 3)
        change = equations.position_change(equations.solve(equations.state_gradient(force)))
        return beyond_rigid((roots * change).reshape(-1))

    size = 3 * len(node_areas)
    begin = np.random.default_rng(0).normal(size=size)
    compliance = LinearOperator((size, size), matvec=give_way, dtype=float)
    try:
        (largest,) = eigsh(compliance, 1, v0=begin, tol=TOLERANCE, return_eigenvectors=False)
    except ArpackError as error:
        raise ComputationError(f"the least stiffness is not found ({error})") from error
    return float(1 / largest)


def rigid_motions(points: Array) -> Array:
    """Return the displacements of points in the six rigid motions, (n, 3, 6)."""
    axes: Array = np.eye(3)
    shifts = np.broadcast_to(axes, (len(points), 3, 3))
    arms = points - points.mean(axis=0)
    turns = np.stack([np.cross(axis, arms) for axis in axes], axis=2)
    return np.concatenate([shifts, turns], axis=2)
