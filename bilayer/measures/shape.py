"""Measures of a released shape: spans in its own frame, best sphere, quality as a hemisphere.

docs/measures.md has the formulas, their sources, and shapes that they misjudge.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface
from bilayer.measures.body_frame import body_frame
from bilayer.measures.hemisphere import hemisphere_distance
from bilayer.measures.sphere import Sphere, fit_sphere
from bilayer.mesh.planar import PlanarMesh

FLAT_SPHERE_RATIO = 50.0
"""A sphere of more than this many flat radii is a flat sheet, of quality 1."""


@dataclass(frozen=True)
class ShapeMeasures:
    """The measures of one shape; lengths in m.

    `span` is the extent (x, y, z) in the body frame, `height` its z.
    """

    quality: float
    sphere_radius: float
    sphere_rmse: float
    hemisphere_distance: float
    span: NDArray[np.float64]
    height: float

    @classmethod
    def undefined(cls) -> "ShapeMeasures":
        """Return the measures of a shape that was not computed: all NaN."""
        nan = math.nan
        return cls(nan, nan, nan, nan, span=np.full(3, nan), height=nan)


def measure_shape(
    mesh: PlanarMesh, position: NDArray[np.float64], flat_radius: float
) -> ShapeMeasures:
    """Return the measures of a released shape.

    Parameters
    ----------
    mesh : PlanarMesh
        The flat state.
    position : (n, 3) array of float
        The reference surface on the nodes of the mesh, m.
    flat_radius : float
        Radius of the flat disc, m; for any other outline that of the circle of its area, see
        `bilayer.specimen.outline.Outline.characteristic_length`.

    Returns
    -------
    ShapeMeasures
        The same for a shape that was moved rigidly.
    """
    surface = Surface(np.asarray(position, dtype=np.float64), mesh.triangles)
    frame = body_frame(mesh, surface.points)
    sphere = fit_sphere(surface)
    span = frame.span(surface.points)
    return ShapeMeasures(
        quality=quality(sphere, span, flat_radius),
        sphere_radius=sphere.radius,
        sphere_rmse=sphere.rmse,
        hemisphere_distance=hemisphere_distance(surface, frame, flat_radius),
        span=span,
        height=float(span[2]),
    )


def quality(sphere: Sphere, span: NDArray[np.float64], flat_radius: float) -> float:
    """Return the quality of a shape: 0 is a hemisphere, 1 is flat.

    A reading of the paper's section VII, which compares the spans with the radius of a hemisphere
    and adds the root mean square error, without a formula: the mean of |1 - Lx/2a|, |1 - Ly/2a|
    and |1 - Lz/a|, plus RMSE/a, at most 1.

    Parameters
    ----------
    sphere : Sphere
        The best sphere, of radius a.
    span : (3,) array of float
        Extents Lx, Ly, Lz in the body frame, m.
    flat_radius : float
        See `measure_shape`; with a beyond `FLAT_SPHERE_RATIO` times it the shape is flat.
    """
    a = sphere.radius
    if a > FLAT_SPHERE_RATIO * flat_radius:
        return 1.0
    misfit = np.mean(np.abs(1 - span / np.array([2 * a, 2 * a, a])))
    return float(min(1.0, misfit + sphere.rmse / a))
