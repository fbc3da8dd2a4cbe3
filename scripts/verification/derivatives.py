"""Energies of the shells against finite differences, and under rigid motion."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bilayer import PlanarMesh
from dshell.energies.assembly import Assembly, Energy

Array = NDArray[np.float64]
ROUGHNESS = 3e-4  # m
STEP = 1e-6  # m


def derivative(function: Callable[[Array], Array], state: Array, step: float) -> Array:
    """Derivative of a function of a state, by each of its degrees of freedom in a last axis.

    Central differences of fourth order.
    """
    columns = []
    for shift in step * np.eye(len(state)):
        near = function(state + shift) - function(state - shift)
        far = function(state + 2 * shift) - function(state - 2 * shift)
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


def derivative_by_points(
    function: Callable[[Array], Array | float], points: Array, step: float
) -> Array:
    """Derivative of a function of points (n, 3), by each coordinate in a last axis."""
    return derivative(lambda x: function(x.reshape(-1, 3)), points.reshape(-1), step)


def rough_dome(mesh: PlanarMesh, extra_dofs: int) -> Array:
    """A state far from equilibrium: a dome with every degree of freedom disturbed."""
    rng = np.random.default_rng(1)
    x, y = mesh.points.T
    dome = np.column_stack([0.95 * x, 0.97 * y, -10.0 * (x**2 + y**2)])
    dome += rng.uniform(-ROUGHNESS, ROUGHNESS, dome.shape)
    rest = rng.uniform(-ROUGHNESS, ROUGHNESS, extra_dofs)
    return np.concatenate([dome.reshape(-1), rest])


def gradient_error(term: Energy, state: Array) -> float:
    """Largest difference of the gradient from finite differences, over its largest entry."""
    found = term.at(state).gradient()
    expected = derivative(lambda x: term.at(x).energy().sum(), state, STEP)
    return float(np.abs(found - expected).max() / np.abs(found).max())


def hessian_error(term: Energy, state: Array) -> float:
    """Largest difference of the Hessian from finite differences, over its largest entry."""
    found = Assembly(len(state), [term]).hessian([term.at(state)]).toarray()
    expected = derivative(lambda x: term.at(x).gradient(), state, STEP)
    return float(np.abs(found - expected).max() / np.abs(found).max())


def rigid_motion_error(term: Energy, state: Array, nodes: int) -> float:
    """Largest change of an element's energy by a rigid motion, over the largest energy."""
    turned = Rotation.from_rotvec([0.7, -1.9, 0.4]).apply(state[: 3 * nodes].reshape(-1, 3))
    moved = np.concatenate([np.add(turned, [3e-3, -2e-3, 1e-3]).reshape(-1), state[3 * nodes :]])
    before, after = (term.at(s).energy() for s in (state, moved))
    return float(np.abs(after - before).max() / np.abs(before).max())
