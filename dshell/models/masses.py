"""The mass of the shell, lumped at its nodes."""

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from dshell.energies.topology import sum_at_nodes
from dshell.models.shares import share_on_faces


def lumped_masses(
    specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float]
) -> NDArray[np.float64]:
    """Return the mass of each node, kg: a third of each of its triangles, all layers.

    Parameters
    ----------
    specimen : Specimen
        Densities and thicknesses.
    mesh : PlanarMesh
        The flat bonded sheet.
    stretch : (float, float)
        (lambda_x, lambda_y) of the prestretch, which thins the layers that it stretches.
    """
    per_area = np.zeros(len(mesh.triangles))
    for part in specimen.bonded_layers(stretch):
        faces = mesh.faces_of(part.name)
        share = share_on_faces(part.layer.pattern, mesh, faces)
        mass = part.layer.density * part.thickness
        per_area[faces] += mass if share is None else mass * share
    return sum_at_nodes(mesh.triangles, per_area * mesh.areas / 3)
