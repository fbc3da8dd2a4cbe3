"""Distance of a shape from a symmetry of its flat disc. SI units."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CloughTocher2DInterpolator

from bilayer import PlanarMesh
from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import flat_surface


def asymmetry(
    mesh: PlanarMesh, shape: NDArray[np.float64], turn: float, mirrored: bool = False
) -> float:
    """Rms distance of a shape from itself, the flat disc mirrored in the x axis or turned, m.

    Nodes that fall beyond the polygon of the rim are left out.
    """
    sign = -1.0 if mirrored else 1.0
    moved = mesh.points * [1.0, sign]
    c, s = np.cos(turn), np.sin(turn)
    moved = moved @ np.array([[c, s], [-s, c]])
    image = CloughTocher2DInterpolator(mesh.points, shape)(moved) * [1.0, sign, 1.0]
    inside = ~np.isnan(image[:, 0])
    weights = flat_surface(mesh).node_areas[inside]
    return float(rms_distance(shape[inside], image[inside], weights))
