"""The share of a layer on each face, from its field of density."""

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.density_field import DensityField
from bilayer.specimen.pattern import Pattern


def share_on_faces(
    pattern: Pattern | None, mesh: PlanarMesh, faces: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Return the share of a layer on each face that it covers, None if all of it lies there.

    Parameters
    ----------
    pattern : Pattern or None
        The layer's.
    mesh : PlanarMesh
        The flat sheet.
    faces : (k,) array of int
        That the layer covers.

    Returns
    -------
    (k,) array of float or None
        At the faces' centres.
    """
    if not isinstance(pattern, DensityField):
        return None
    return pattern.share_at(mesh.points[mesh.triangles[faces]].mean(axis=1))
