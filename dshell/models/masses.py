"""The mass of the shell, lumped at its nodes."""

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from dshell.energies.topology import sum_at_nodes


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
        per_area[mesh.faces_of(part.name)] += part.layer.density * part.thickness
    return sum_at_nodes(mesh.triangles, per_area * mesh.areas / 3)
