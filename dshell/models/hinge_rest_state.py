"""The rest state of hinges and springs by laminate theory: what the printed method was meant to be.

In place of the printed balance of energies (paper, eqs. 6 and 7) the natural lengths and angles
are those of the free laminate. Of the layers with moduli E_i, thicknesses t_i, mid-heights z_i and
natural strains e_i (by their laws: 1 / lambda - 1 if stretched, but sqrt(1 - 2 (lambda - 1)) - 1
of the linear law; 0 if not), about the neutral axis,
where B vanishes (Timoshenko 1925; Reddy, Mechanics of Laminated Composite Plates, ch. 3),

    A = sum E t,  D = sum E' (t^3 / 12 + t z^2),  E' = E / (1 - nu^2),
    natural strain e0 = sum E t e / A,            natural curvature k0 = - sum E' t z e / D

(positive where it bulges upward), both tensors where lambda_x and lambda_y differ. On an
equilateral lattice of edge a (numbers tested in tests/dshell) that is

    spring  k_s = 3 A (area of the edge) = sqrt(3)/2 A a^2,   L = l |t + e0 t|
    hinge   k_b = D a^2 / (3 (area of the edge)) = 2/sqrt(3) D,
            theta_bar = d (3 n . k0 n - t . k0 t) / 2,        d = a / sqrt(3),

t along the edge, n across it in the plane. The area of an edge is a third of its triangles', and
d the distance of their circumcentres, so a sphere has these angles on every Delaunay mesh. Edges
between bare and covered triangles share their areas' A, D, A e0 and D k0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.layer import BondedLayer
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.two_layers import KIRIGAMI, TWO_LAYERS, TwoLayers
from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges
from dshell.energies.topology import FaceNeighbours, Topology

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Section:
    """The stiffness and the natural strain and curvature of a laminate.

    Parameters
    ----------
    stretching : float
        A, N/m.
    bending : float
        D about the neutral axis, N m.
    strain : (2,) array of float
        Natural strain of the neutral axis along x and y.
    curvature : (2,) array of float
        Natural curvature along x and y, 1/m.
    neutral_axis : float
        Height above the bond, m.
    """

    stretching: float
    bending: float
    strain: Array
    curvature: Array
    neutral_axis: float

    @classmethod
    def of(cls, layers: Sequence[BondedLayer]) -> "Section":
        """Return the section of a pile of layers."""
        materials = [part.layer.material for part in layers]
        modulus = np.array([material.young_modulus for material in materials])
        plane = modulus / (1 - np.array([material.poisson_ratio for material in materials]) ** 2)
        bottom, top = np.array([(part.bottom, part.top) for part in layers]).T
        scale = np.array([part.layer.material.natural_scale(part.axial_stretch) for part in layers])
        natural = scale[:, :2] - 1
        thickness, middle = top - bottom, (top + bottom) / 2
        axis = (plane * thickness) @ middle / (plane @ thickness)
        stretching = modulus @ thickness
        bending = plane @ (thickness**3 / 12 + thickness * (middle - axis) ** 2)
        return cls(
            float(stretching),
            float(bending),
            (modulus * thickness) @ natural / stretching,
            (plane * thickness * (middle - axis)) @ natural / bending,
            float(axis),
        )


def specimen_sections(specimen: Specimen, stretch: tuple[float, float]) -> tuple[Section, Section]:
    """Return the section of the bare substrate and that of the bilayer."""
    TwoLayers.of(specimen, "model = 'hinge'")
    layers = specimen.bonded_layers(stretch)
    bare, bilayer = (
        Section.of([part for part in layers if part.name in there]) for there in TWO_LAYERS
    )
    return bare, bilayer


def laminate_springs_and_hinges(
    mesh: PlanarMesh, bare: Section, bilayer: Section
) -> tuple[EdgeSprings, Hinges]:
    """Return springs on all edges and hinges on all inner ones, with their rest state.

    Parameters
    ----------
    mesh : PlanarMesh
        The flat bonded state.
    bare, bilayer : Section
        Of the triangles without and with kirigami.
    """
    topology = Topology.of(mesh.triangles)
    edges = FaceNeighbours.of(mesh.triangles).edges
    sections = [bilayer if tag == KIRIGAMI else bare for tag in (0, 1)]

    def shared(values: list[Array | float]) -> Array:
        """Sum a value of the sections over the thirds of the triangles at each edge."""
        per_face = np.asarray(values, dtype=float)[mesh.region]
        thirds = per_face * (mesh.areas / 3).reshape(-1, *[1] * (per_face.ndim - 1))
        total = np.zeros((topology.edges.shape[0], *per_face.shape[1:]))
        np.add.at(total, edges.reshape(-1), np.repeat(thirds, 3, axis=0))
        return total

    stretching, bending = (
        shared([s.stretching for s in sections]),
        shared([s.bending for s in sections]),
    )
    strain = shared([s.stretching * s.strain for s in sections]) / stretching[:, None]
    curvature = shared([s.bending * s.curvature for s in sections]) / bending[:, None]
    area = shared([1.0, 1.0])
    along = mesh.points[topology.edges[:, 1]] - mesh.points[topology.edges[:, 0]]
    length = np.linalg.norm(along, axis=1)
    tt = (along / length[:, None]) ** 2  # of the diagonal tensors: t . a t = tt @ a
    natural = np.linalg.norm((1 + strain) * along, axis=1)
    springs = EdgeSprings(topology.edges, 3 * stretching, natural)
    inner = topology.hinge_edges
    bend = 1.5 * (1 - tt) * curvature - 0.5 * tt * curvature  # n . k n has x and y exchanged
    angle = circumcentre_distances(mesh, topology) * bend[inner].sum(axis=1)
    stiffness = bending[inner] * length[inner] ** 2 / (3 * area[inner] ** 2)
    turn_dofs = 3 * len(mesh.points) + np.arange(len(angle))
    return springs, Hinges(topology.hinges, stiffness, angle, turn_dofs)


def circumcentre_distances(mesh: PlanarMesh, topology: Topology) -> Array:
    """Return the signed distance of the circumcentres of each hinge's triangles, m.

    a (cot alpha + cot beta) / 2 with the angles at the two apexes; negative where the mesh is not
    Delaunay.
    """
    start, end, *apexes = np.moveaxis(mesh.points[topology.hinges], 1, 0)
    total = np.zeros(len(start))
    for apex in apexes:
        u, v = start - apex, end - apex
        total += (u * v).sum(axis=1) / np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return np.linalg.norm(end - start, axis=1) * total / 2
