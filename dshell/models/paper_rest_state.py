"""The rest state of the paper's discrete shell: stiffnesses, natural lengths and natural angles.

Everything as printed, eqs. 2, 3, 5 and 7; what is wrong with it stands in docs/theory-dshell.md.

    k_s = sqrt(3)/2 Y_s t_s l^2                     (2)
    L = l / lambda                                  (3)
    k_b = 2/sqrt(3) Y_k I_eff                       (5)
    theta_bar = sqrt(k_s (lambda - 1)^2 / k_b)      (7)

l is the length of the edge in the flat bonded mesh, whose substrate is stretched; it stays as it
is while L changes with time. I_eff is the moment of inertia per unit width of the two layers about
their common neutral axis, the substrate's width scaled by Y_s / Y_k ("composite beam theory").
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.two_layers import KIRIGAMI, LAYERS
from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges
from dshell.energies.topology import Topology

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Ramp:
    """Energies whose natural lengths and angles go linearly from the flat mesh's to the final ones.

    Parameters
    ----------
    springs : EdgeSprings
        With their final natural lengths.
    hinges : Hinges
        With their final natural angles.
    flat_length : (e,) array of float
        Edge lengths of the flat mesh, m.
    """

    springs: EdgeSprings
    hinges: Hinges
    flat_length: Array

    def at(self, share: float) -> tuple[EdgeSprings, Hinges]:
        """Return the energies at a share of the ramp: 0 the flat mesh, 1 the final rest state."""
        length = (1 - share) * self.flat_length + share * self.springs.natural_length
        return (
            replace(self.springs, natural_length=length),
            replace(self.hinges, natural_angle=share * self.hinges.natural_angle),
        )


def rest_state(specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float]) -> Ramp:
    """Return the paper's springs and hinges with their rest state for one prestretch.

    Parameters
    ----------
    specimen : Specimen
        Moduli and thicknesses of the two layers.
    mesh : PlanarMesh
        The flat bonded mesh; its hinges bend where both triangles carry kirigami.
    stretch : (float, float)
        (lambda_x, lambda_y). Where they differ, which the paper has not: an edge's natural length
        is that of its vector with either component released, and lambda in eq. 7 is their mean.
    """
    topology = Topology.of(mesh.triangles)
    edge = mesh.points[topology.edges[:, 1]] - mesh.points[topology.edges[:, 0]]
    length = np.linalg.norm(edge, axis=1)
    thickness = specimen.bonded_layer("substrate", stretch).thickness
    substrate = specimen.layer("substrate").material
    stretching = edge_stiffness(substrate.young_modulus, thickness, length)
    springs = EdgeSprings(topology.edges, stretching, np.linalg.norm(edge / stretch, axis=1))
    bilayer = np.all(mesh.region[topology.hinge_faces] == KIRIGAMI, axis=1)
    bending = hinge_stiffness(specimen, thickness)
    angle = natural_angle(stretching[topology.hinge_edges[bilayer]], bending, sum(stretch) / 2)
    hinges = Hinges(topology.hinges[bilayer], np.full(len(angle), bending), angle)
    return Ramp(springs, hinges, length)


def edge_stiffness(young_modulus: float, thickness: float, length: Array) -> Array:
    """Return k_s of edges, J (eq. 2)."""
    return math.sqrt(3) / 2 * young_modulus * thickness * length**2


def hinge_stiffness(specimen: Specimen, substrate_thickness: float) -> float:
    """Return k_b of the bilayer's hinges, J (eq. 5)."""
    substrate, kirigami = (specimen.layer(name) for name in LAYERS)
    inertia = effective_inertia(
        substrate_thickness,
        kirigami.thickness,
        substrate.material.young_modulus / kirigami.material.young_modulus,
    )
    return 2 / math.sqrt(3) * kirigami.material.young_modulus * inertia


def effective_inertia(substrate: float, kirigami: float, modular_ratio: float) -> float:
    """Return I_eff of the transformed section, per unit width.

    With n = Y_s / Y_k, areas A = (n h_s, h_k) and centres z = (-h_s/2, h_k/2) from the bond, the
    neutral axis lies at z_n = sum A z / sum A, and I_eff = sum A (h^2/12 + (z - z_n)^2): the
    parallel axis theorem (Timoshenko and Gere, composite beams).

    Parameters
    ----------
    substrate, kirigami : float
        Thicknesses h_s and h_k, m.
    modular_ratio : float
        n = Y_s / Y_k.

    Returns
    -------
    float
        m3 (m4 per metre of width).
    """
    thickness = np.array([substrate, kirigami])
    area = np.array([modular_ratio, 1.0]) * thickness
    centre = np.array([-substrate, kirigami]) / 2
    neutral_axis = area @ centre / area.sum()
    return float(area @ (thickness**2 / 12 + (centre - neutral_axis) ** 2))


def natural_angle(edge_stiffness: Array, hinge_stiffness: float, stretch: float) -> Array:
    """Return theta_bar of hinges, rad (eq. 7), each from the stretching stiffness of its own edge.

    The root is taken as printed, so a stretch below 1 bends the same way as one above.
    """
    return np.sqrt(edge_stiffness * (stretch - 1) ** 2 / hinge_stiffness)
