"""Rigid motions of a shape: onto corresponding points, onto three held ones; the rms distance."""

from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def best_rotation(moving: Array, fixed: Array, weights: Array) -> "Rotation":
    """Return the proper rotation about the centroids that brings `moving` nearest to `fixed`.

    It minimises sum w |fixed - R moving|^2 over centred points (Kabsch 1976; scipy's
    `align_vectors`), never with a reflection.

    Parameters
    ----------
    moving, fixed : (n, 3) array of float
        Points that correspond, m.
    weights : (n,) array of float
        Weight of each pair, not negative.
    """
    bodies = _centred(fixed, weights), _centred(moving, weights)
    return scipy.spatial.transform.Rotation.align_vectors(*bodies, weights)[0]


def align(moving: Array, fixed: Array, weights: Array) -> Array:
    """Return `moving` after the rigid motion that brings it nearest to `fixed`, shape (n, 3)."""
    rotation = best_rotation(moving, fixed, weights)
    return rotation.apply(_centred(moving, weights)) + np.average(fixed, axis=0, weights=weights)


def align_gradient(moving: Array, fixed: Array, weights: Array, gradient: Array) -> Array:
    """Return the gradient by `moving` of a function whose gradient by `align` is given.

    The rotation follows the points. For a small turn w of the aligned points y about the fixed ones
    f, the condition sum weights y x f = 0 of the best rotation gives

        (trace(S) 1 - S) w = sum weights dy x f,    S = sum weights y f'.

    Parameters
    ----------
    moving, fixed, weights
        As those of `align`.
    gradient : (n, 3) array of float
        Derivative of a number by the aligned points.
    """
    rotation = best_rotation(moving, fixed, weights)
    turned, target = rotation.apply(_centred(moving, weights)), _centred(fixed, weights)
    inertia = (weights[:, None] * turned).T @ target
    stiffness = np.trace(inertia) * np.eye(3) - (inertia + inertia.T) / 2
    torque = np.cross(turned, gradient).sum(axis=0)
    turn = np.linalg.solve(stiffness, torque)
    by_turned = gradient + weights[:, None] * np.cross(target, turn)
    by_turned -= np.outer(weights / weights.sum(), gradient.sum(axis=0))
    return rotation.apply(by_turned, inverse=True)


def rms_distance(moving: Array, fixed: Array, weights: Array) -> float:
    """Return the weighted rms distance of two point sets after rigid alignment, m.

    Parameters
    ----------
    moving, fixed : (n, 3) array of float
        Points that correspond, m.
    weights : (n,) array of float
        Weight of each pair, for example the lumped area around a node.
    """
    apart = align(moving, fixed, weights) - fixed
    return float(np.sqrt(np.average(np.sum(apart**2, axis=1), weights=weights)))


def move_onto_held_points(shape: Array, flat: Array, held: tuple[int, int, int]) -> Array:
    """Move a shape rigidly so that six coordinates of three points are those of a flat state.

    Parameters
    ----------
    shape : (n, 3) array of float
        Any position and orientation, m.
    flat : (n, 2) array of float
        The flat state, at z = 0, m.
    held : (int, int, int)
        Points a, b, c: a goes to its flat place, b, which lies toward +x from it, to its flat y
        and to z = 0, c to z = 0. They keep their sense of rotation.

    Returns
    -------
    (n, 3) array of float
        The shape moved, m.
    """
    a, b, c = held
    moved, arms = shape - shape[a], flat - flat[a]
    length = np.linalg.norm(moved[b])
    along = moved[b] / length
    normal = np.cross(along, moved[c])
    sense = np.sign(arms[b, 0] * arms[c, 1] - arms[b, 1] * arms[c, 0])
    normal *= sense / np.linalg.norm(normal)
    turn = np.arcsin(np.clip(arms[b, 1] / length, -1, 1))
    x = np.cos(turn) * along - np.sin(turn) * np.cross(normal, along)
    axes = np.stack([x, np.cross(normal, x), normal])
    return np.asarray(moved @ axes.T + np.append(flat[a], 0.0))


def _centred(points: Array, weights: Array) -> Array:
    return points - np.average(points, axis=0, weights=weights)
