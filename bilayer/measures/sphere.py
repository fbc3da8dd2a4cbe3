"""The sphere that fits a surface best, geometrically, with the plane as a sphere of no curvature.

A sphere is told by its curvature k, and by the point p and normal n at which it passes a given
origin on the surface: all of these stay finite when the surface is flat. With y = x - p the signed
distance of a point is

    d = 2 P / (1 + sqrt(1 + 2 k P)),   P = n.y + k |y|^2 / 2

which is (|k y + n| - 1) / k without its cancellation, and n.y for k = 0 (Chernov and Lesort 2005,
Least squares fitting of circles, J. Math. Imaging Vision 23, eq. 16, for circles).
"""

import math
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sphere:
    """A fitted sphere.

    Parameters
    ----------
    radius : float
        m; infinite for a plane.
    rmse : float
        Area-weighted root mean square of the distances from it, m.
    distances : ndarray, shape (n,)
        Of the nodes from it, outside positive, m.
    """

    radius: float
    rmse: float
    distances: Array = field(compare=False, repr=False)


def fit_sphere(surface: Surface) -> Sphere:
    """Return the sphere with the least area-weighted sum of squared distances from the nodes.

    Parameters
    ----------
    surface : Surface
        Its nodes count by their lumped areas.

    Raises
    ------
    InputError
        There are fewer nodes than a sphere needs.
    """
    if len(surface.points) < 4:
        raise InputError(f"mesh has {len(surface.points)} nodes: expected at least 4 for a sphere")
    weights = surface.node_areas / surface.node_areas.sum()
    points = surface.points - _point_on(surface)
    size = float(np.sqrt(weights @ np.sum(points**2, axis=1)))
    scaled: Array = np.divide(points, size)
    start, axes = _algebraic_fit(scaled, weights)
    points, root_weights = scaled @ axes.T, np.sqrt(weights)

    def residuals(unknowns: Array) -> Array:
        return root_weights * _distance(points, *unknowns)

    def slopes(unknowns: Array) -> Array:
        return root_weights[:, None] * _distance_slopes(points, *unknowns)

    near = scipy.optimize.least_squares(
        residuals, start, slopes, method="lm", ftol=1e-12, xtol=1e-12
    ).x
    # round-off hides the least sum of squares within 1e-8; the zero of its gradient is sharp
    best = scipy.optimize.root(
        lambda unknowns: slopes(unknowns).T @ residuals(unknowns), near, tol=1e-14
    ).x
    curvature = abs(best[0]) / size
    return Sphere(
        radius=float(1 / curvature) if curvature > 0 else math.inf,
        rmse=float(np.linalg.norm(residuals(best))) * size,
        distances=math.copysign(size, best[0]) * _distance(points, *best),
    )


def _point_on(surface: Surface) -> Array:
    """Return the node nearest to the centroid: near the sphere, so far from its centre."""
    return surface.points[np.argmin(np.sum((surface.points - surface.centroid) ** 2, axis=1))]


def _distance(points: Array, curvature: float, offset: float, tilt: float, tip: float) -> Array:
    """Signed distance of points from a sphere whose normal (tilt, tip, 1) is near the z axis."""
    normal, _ = _unit_normal(tilt, tip)
    y = points - offset * normal
    P = y @ normal + 0.5 * curvature * np.sum(y**2, axis=1)
    return 2 * P / (1 + _gradient_norm(curvature, P))


def _distance_slopes(
    points: Array, curvature: float, offset: float, tilt: float, tip: float
) -> Array:
    """Return the derivatives of `_distance` by its four unknowns, shape (n, 4)."""
    normal, normal_slopes = _unit_normal(tilt, tip)
    y = points - offset * normal
    along, square = y @ normal, np.sum(y**2, axis=1)
    P = along + 0.5 * curvature * square
    q = _gradient_norm(curvature, P)
    by_curvature = square / (1 + q) - 2 * P * (P + 0.5 * curvature * square) / (q * (1 + q) ** 2)
    by_offset = -(1 + curvature * along) / q
    by_normal = (1 - curvature * offset) * (y @ normal_slopes) / q[:, None]
    return np.column_stack([by_curvature, by_offset, by_normal])


def _gradient_norm(curvature: float, P: Array) -> Array:
    """|k y + n| = sqrt(1 + 2 k P), kept from zero, where the sphere's centre is."""
    return np.sqrt(np.maximum(1 + 2 * curvature * P, 1e-24))


def _unit_normal(tilt: float, tip: float) -> tuple[Array, Array]:
    """Return the unit vector along (tilt, tip, 1), and its derivatives by both, (3, 2)."""
    length = math.sqrt(tilt**2 + tip**2 + 1)
    normal = np.array([tilt, tip, 1.0]) / length
    return normal, (np.eye(3, 2) - np.outer(normal, normal[:2])) / length


def _algebraic_fit(points: Array, weights: Array) -> tuple[Array, Array]:
    """Return Pratt's algebraic fit: the unknowns of `_distance` and the axes, z along its normal.

    Of A |x|^2 + b.x + c it minimises the mean square under |b|^2 - 4 A c = 1, which admits planes
    (Pratt 1987, Direct least-squares fitting of algebraic surfaces, SIGGRAPH 21(4)).
    """
    terms = np.column_stack([np.sum(points**2, axis=1), points, np.ones(len(points))])
    constraint = np.diag([0.0, 1.0, 1.0, 1.0, 0.0])
    constraint[0, 4] = constraint[4, 0] = -2.0
    values, vectors = scipy.linalg.eig(terms.T @ (weights[:, None] * terms), constraint)
    values, vectors = values.real, vectors.real
    norms = np.einsum("ij,ik,kj->j", vectors, constraint, vectors)
    best = np.argmin(np.where(norms > 0, values, np.inf))
    A, *b, c = vectors[:, best] / math.sqrt(norms[best])
    slope = float(np.linalg.norm(b))  # of the algebraic distance at the origin, 1 on the sphere
    normal = np.array(b) / slope
    start = np.array([2 * A, -2 * c / (1 + slope), 0.0, 0.0])
    return start, np.vstack([scipy.linalg.null_space(normal[None]).T, normal])
