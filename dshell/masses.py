"""The mass of the shell, lumped at its nodes."""

import numpy as np
from numpy.typing import NDArray

from bilayer.planar_mesh import KIRIGAMI, PlanarMesh
from bilayer.specimen import Specimen
from dshell.topology import sum_at_nodes


def lumped_masses(specimen: Specimen, mesh: PlanarMesh, thickness: float) -> NDArray[np.float64]:
    """Return the mass of each node, kg: a third of each of its triangles, both layers.

    Parameters
    ----------
    specimen : Specimen
        Densities and the kirigami layer's thickness.
    mesh : PlanarMesh
        The flat bonded disc.
    thickness : float
        Of the bonded substrate, m.
    """
    per_area = specimen.substrate.density * thickness + np.where(
        mesh.region == KIRIGAMI, specimen.kirigami.density * specimen.kirigami.thickness, 0.0
    )
    return sum_at_nodes(mesh.triangles, per_area * mesh.areas / 3)
