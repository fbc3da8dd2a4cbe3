"""Six held coordinates that remove the rigid motion and nothing else.

One node is held in x, y and z, a far one in y and z, and a third, not on their line, in z. Elastic
forces are in balance. At an equilibrium without a load the reactions vanish, and the shape is free.
"""

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.support import HeldNodes, choose_nodes_at_centre
from dshell.energies.assembly import coordinates_of

Array = NDArray[np.float64]


def choose_far_nodes(mesh: PlanarMesh) -> HeldNodes:
    """Return the nodes that are held: the centre, a far one along x, one that spans the most.

    The far one lies in the direction of x, unless the sheet reaches twice as far in the other.
    """
    centre = mesh.centre_node
    arms = mesh.points - mesh.points[centre]
    along = arms[:, 0]
    far = int(np.argmax(np.where(along > 0, 2 * along, -along)))
    side = int(np.argmax(np.abs(arms[far, 0] * arms[:, 1] - arms[far, 1] * arms[:, 0])))
    return centre, far, side


def choose_held_nodes(specimen: Specimen, mesh: PlanarMesh) -> HeldNodes:
    """Return the nodes where a specimen is held: see `bilayer.specimen.support`."""
    if specimen.is_placed:
        return choose_nodes_at_centre(mesh.points, mesh.centroid)
    return choose_far_nodes(mesh)


def held_coordinates(nodes: HeldNodes) -> NDArray[np.int64]:
    """Return the six coordinates that are held at nodes, by their places in the state."""
    a, b, c = coordinates_of(np.array(nodes))
    return np.concatenate([a, b[1:], c[2:]])
