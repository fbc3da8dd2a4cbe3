"""Rigid alignment of two point sets that correspond, and the distance that is left."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def best_rotation(moving: Array, fixed: Array, weights: Array) -> Rotation:
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
    return Rotation.align_vectors(_centred(fixed, weights), _centred(moving, weights), weights)[0]


def aligned(moving: Array, fixed: Array, weights: Array) -> Array:
    """Return `moving` after the rigid motion that brings it nearest to `fixed`, shape (n, 3)."""
    rotation = best_rotation(moving, fixed, weights)
    return rotation.apply(_centred(moving, weights)) + np.average(fixed, axis=0, weights=weights)


def rms_distance(moving: Array, fixed: Array, weights: Array) -> float:
    """Return the weighted rms distance of two point sets after rigid alignment, m.

    Parameters
    ----------
    moving, fixed : (n, 3) array of float
        Points that correspond, m.
    weights : (n,) array of float
        Weight of each pair, for example the lumped area around a node.
    """
    apart = aligned(moving, fixed, weights) - fixed
    return float(np.sqrt(np.average(np.sum(apart**2, axis=1), weights=weights)))


def _centred(points: Array, weights: Array) -> Array:
    return points - np.average(points, axis=0, weights=weights)
