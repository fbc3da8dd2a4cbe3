"""A pressure on faces of the skin, which follows them.

    residual = p integral of n . v da  over the deformed faces, n their outward normal,

by Nanson's formula n da = cof(F) N dA. It is the derivative of p times the volume that the faces
have swept inward, if the edge of the faces is held. At an edge that moves the derivative of the
residual is not symmetric; the tangent takes its symmetric part.
"""

from typing import Any

import dolfinx
import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from numpy.typing import NDArray

from fenics_model.mesh.layered_mesh import LayeredMesh


class SkinPressure:
    """A pressure on some faces of the skin.

    Parameters
    ----------
    mesh : LayeredMesh
        The solid's.
    faces : (k, 3) array of int
        Original numbers of the faces' vertices.

    Attributes
    ----------
    value : dolfinx Constant
        Pa; it may change along a load path.
    """

    def __init__(self, mesh: LayeredMesh, faces: NDArray[np.int64]) -> None:
        self.value = fem.Constant(mesh.mesh, default_scalar_type(0.0))
        self._normal = ufl.FacetNormal(mesh.mesh)
        self._place = ufl.SpatialCoordinate(mesh.mesh)
        tags = _tags(mesh, faces)
        self._ds = ufl.Measure(
            "ds", mesh.mesh, subdomain_data=tags, metadata={"quadrature_degree": 4}
        )(1)

    def residual(self, gradient: Any, test: Any) -> Any:
        """Return its part of the residual, grad(x) and a test function given."""
        return self.value * ufl.dot(_area_vector(gradient, self._normal), test) * self._ds

    def swept(self, gradient: Any, displacement: Any) -> Any:
        """Return the form of minus the volume between the faces and the origin, m3."""
        area = _area_vector(gradient, self._normal)
        return -ufl.dot(self._place + displacement, area) / 3 * self._ds


def _area_vector(gradient: Any, normal: Any) -> Any:
    return ufl.det(gradient) * ufl.dot(ufl.inv(gradient).T, normal)


def _tags(mesh: LayeredMesh, faces: NDArray[np.int64]) -> Any:
    """Return tags of this rank's facets on the skin, 1 on the faces."""
    topology = mesh.mesh.topology
    topology.create_connectivity(2, 3)
    topology.create_connectivity(2, 0)
    outer = dolfinx.mesh.exterior_facet_indices(topology)
    found = mesh.vertices_of_facets(outer)
    chosen = outer[_rows_in(np.sort(found, axis=1), np.sort(faces, axis=1))]
    return dolfinx.mesh.meshtags(
        mesh.mesh, 2, np.sort(chosen), np.ones(len(chosen), dtype=np.int32)
    )


def _rows_in(rows: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which rows are among others."""
    size = 1 + max(rows.max(initial=0), others.max(initial=0))
    key = np.array([size * size, size, 1])
    return np.isin(rows @ key, others @ key)
