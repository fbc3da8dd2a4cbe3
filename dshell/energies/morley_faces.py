"""A shell of flat triangles that bend by Morley's rule: the accurate model's only energy.

Unknowns are the positions of the nodes and one displacement p per edge. Edge i of a face, of flat
length l_i and outward in-plane normal n_i, turns by

    a_i = t_i / 2 + p_i / l_i   in its first face,      t_i / 2 - p_i / l_i   in its second,

t = theta l / l' the angle across it (0 at the boundary) by how much the edge has stretched (see
`dshell.energies.turns`), so p / l shares that turn out between the faces; the curvature of a face
of area A is

    k = sum_i (l_i / A) a_i  n_i (x) n_i.

That is Morley's triangle (1968) for small deflections: constant curvature is exact on any mesh.
With the constant strain of the membrane, a laminate gives the energy of each face.

About a clamped edge the shell cannot turn. Beyond it lies, for each of its faces, a fixed flat
triangle. The angle to that is the whole turn, a_i = t_i, and nothing is shared out.

The energy of a face needs six nodes, its corners and the apexes beyond its edges, and three edges.
The angle across an edge serves both of its faces, so it is computed once, and so is its second
derivative, times the moment of both.
"""

from copy import copy
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.energies.assembly import coordinates_of, sum_at
from dshell.energies.hinges import fold_dofs, fold_product
from dshell.energies.membrane import FlatTriangles
from dshell.energies.through_thickness import Laminate
from dshell.energies.topology import FaceNeighbours
from dshell.energies.turns import Turn
from dshell.energies.whole_turns import turns_in

Array = NDArray[np.float64]

NO_EDGES = np.empty((0, 2), dtype=np.int64)
WALLS = "beside walls"
"""Name of the energy of the zones beside walls, in a result."""
FAR_BEYOND = 10.0
"""Distance of a fixed node from its clamped edge, over the length of that."""
_FOLDS = ((1, 2, 0, 3), (2, 0, 1, 4), (0, 1, 2, 5))
"""The hinge over each edge, among the face's six nodes: its corners and the apexes beyond them.

First the hinge's ends, then the apex of the face and that beyond the edge."""
_VIEWS = ((0, 1), (1, 0), (2, 3), (3, 2))
"""The nodes of a hinge in the order of its first and of its second face."""
_POSITIONS = 18  # x of the six nodes, y, z; three edge displacements follow


class MorleyFaces:
    """The energy of every face as a function of its own six nodes and three edges.

    Parameters
    ----------
    points : (n, 2) array of float
        The flat bonded reference surface, m.
    triangles : (m, 3) array of int
        Counterclockwise.
    laminate : Laminate
        What the faces are made of.
    clamped : (c, 2) array of int, optional
        The clamped edges, as ascending pairs of nodes.

    Attributes
    ----------
    beyond : (k, 2) array of float
        Flat places of the fixed nodes beyond clamped edges, m. They are numbered after all others.
    idle_dofs : array of int
        Displacements of clamped edges, which have no part in the energy.
    """

    name: ClassVar[str] = "elastic"

    def __init__(
        self,
        points: Array,
        triangles: NDArray[np.int64],
        laminate: Laminate,
        clamped: NDArray[np.int64] = NO_EDGES,
    ) -> None:
        around = FaceNeighbours.of(triangles)
        sides = _sides_at(triangles, clamped)
        around = around.cut_at(sides, first=len(points))
        self.laminate = laminate
        self.edge_count = around.edge_count
        self.flat = FlatTriangles(points[triangles])
        self.beyond = _places_beyond(points[triangles], self.flat, sides)
        self.turn_factors = (0.5 + 0.5 * sides.T) * self.flat.lengths**2 * around.shared.T
        self.shares = np.where(sides.T, 0.0, around.side.T)
        x, y = self.flat.outward
        self.bending = np.stack([x * x, y * y, 2 * x * y]) / self.flat.areas
        self._nodes = np.column_stack([triangles, around.apexes])
        self.edge_dofs = 3 * (len(points) + len(self.beyond)) + around.edges.T
        self.idle_dofs = np.unique(self.edge_dofs[sides.T])
        """Displacements of the faces' edges in the state, (3, m)."""
        self._find_folds()

    def _find_folds(self) -> None:
        """Give a number to the fold over each edge, which one of its faces is the first to see."""
        _, first, fold = np.unique(self.edge_dofs, return_index=True, return_inverse=True)
        edge, face = np.divmod(first, len(self._nodes))
        hinges = self._nodes[face[:, None], np.take(_FOLDS, edge, axis=0)]
        self.fold_dofs = fold_dofs(hinges)
        """Coordinates of the folds' nodes in the state, (3, 4, f)."""
        self.inner_folds = hinges[:, 2] != hinges[:, 3]
        """Whether there are two faces at each fold; at the boundary the angle means nothing."""
        self.turn_dofs = self.edge_dofs.reshape(-1)[first] + self.edge_count
        """Place of the whole turns of each fold in the state, behind the edges, (f,)."""
        self.folds = fold.reshape(self.edge_dofs.shape)
        """The fold over each edge of each face, (3, m)."""
        seen = np.where(first[self.folds] == np.arange(fold.size).reshape(self.folds.shape), 0, 1)
        self.fold_nodes = np.take(_VIEWS, seen, axis=1) * len(first) + self.folds
        """Its nodes in the face's order among all nodes of folds, (4, 3, m)."""
        at_nodes = coordinates_of(self._nodes).transpose(2, 1, 0)
        self.corner_dofs = np.ascontiguousarray(at_nodes[:, :3])
        """Coordinates of the faces' corners in the state, (3, 3, m): xyz, corner."""
        self.stencils = [
            np.concatenate([at_nodes.reshape(_POSITIONS, -1), self.edge_dofs]).T,
            self.fold_dofs.reshape(12, -1).T,
        ]
        self.force_dofs = np.concatenate(
            [part.reshape(-1) for part in (self.corner_dofs, self.fold_dofs, self.edge_dofs)]
        )

    @property
    def corners(self) -> NDArray[np.int64]:
        """Nodes of the faces, (m, 3)."""
        return self._nodes[:, :3]

    def with_laminate(self, laminate: Laminate) -> "MorleyFaces":
        """Return the same faces of another laminate; what they share is not computed anew."""
        faces = copy(self)
        faces.laminate = laminate
        return faces

    def part(self, block: slice) -> "MorleyFaces":
        """Return some of the faces."""
        faces = copy(self)
        faces.laminate = self.laminate.part(block)
        faces.flat = self.flat.part(block)
        faces.turn_factors, faces.shares = self.turn_factors[:, block], self.shares[:, block]
        faces.bending, faces.edge_dofs = self.bending[:, :, block], self.edge_dofs[:, block]
        faces._nodes = self._nodes[block]
        faces._find_folds()
        return faces

    def at(self, state: Array) -> "BentFaces":
        """Return the faces in a state; see `dshell.energies.assembly.Energy`."""
        return BentFaces(self, state)


class BentFaces:
    """Morley's faces in some state.

    Parameters
    ----------
    faces : MorleyFaces
        What is bent.
    state : (dofs,) array of float
        All degrees of freedom, m.
    """

    def __init__(self, faces: MorleyFaces, state: Array) -> None:
        self._faces = faces
        self._size = len(state)
        self._triangles = faces.flat.at(state[faces.corner_dofs])
        self._folds = Turn(state[faces.fold_dofs], turns_in(state, faces.turn_dofs))
        self._state_at_edges = state[faces.edge_dofs]
        self._turns = faces.turn_factors * self._folds.sharpness[faces.folds]
        self._turns += faces.shares * self._state_at_edges
        curvature = (faces.bending * self._turns).sum(axis=1)
        self.strains = np.concatenate([self._triangles.strain(), curvature])
        """Strain and curvature (Exx, Eyy, 2 Exy, kxx, kyy, 2 kxy), shape (6, m)."""
        self.laminate = faces.laminate.at(self.strains)
        """The layers on the faces, as they are bent."""

    @property
    def tangents(self) -> Array:
        """Images of the unit vectors of the flat sheet, shape (2, 3, m)."""
        return self._triangles.tangents

    @property
    def areas(self) -> Array:
        """Flat areas, m2, shape (m,)."""
        return self._faces.flat.areas

    @property
    def turn_dofs(self) -> NDArray[np.int64]:
        """See `dshell.energies.whole_turns.Folded`."""
        return self._faces.turn_dofs

    @property
    def angles(self) -> Array:
        """See `dshell.energies.whole_turns.Folded`."""
        return np.where(self._faces.inner_folds, self._folds.angle, 0.0)

    def energy(self) -> Array:
        """Return each face's energy, J, shape (m,)."""
        return self._faces.flat.areas * self.laminate.energy()

    def layer_energies(self) -> dict[str, float]:
        """Return the energy of each layer by its name, and of the zones beside walls, J."""
        areas, laminate = self.areas, self.laminate
        energies = {
            bent.layer.name: float(areas[bent.layer.face_numbers] @ bent.energy())
            for bent in laminate.layers
        }
        if self._faces.laminate.zones is not None:
            energies[WALLS] = float(np.sum(areas * laminate.zone_energy()))
        return energies

    def gradient(self) -> Array:
        """Return the derivative of the energy by the state, N, shape (dofs,)."""
        parts = [
            self._triangles.forces(self._forces[:3]),
            self._torques * self._folds.sharpness_gradient,
            self._faces.shares * self._moments,
        ]
        forces = np.concatenate([part.reshape(-1) for part in parts])
        return sum_at(self._faces.force_dofs, forces, self._size)

    def flat_gradient(self) -> Array:
        """Return the derivative of the energy by the flat corners, the state fixed, N, (2, 3, m).

        A motion of the corners with the gradient G over a face of area A changes the energy A w by
        Q : G. With the deformation F, C = F^T F, the forces N and moments M of the face, its sides
        s, and u = J s turned by a right angle, so that l n = u,

            Q = A (w - M:k) 1 - A C N
                + sum_i [2 c_i (J^T M u_i) s_i^T - 2 d_i (u_i.M u_i) s_i s_i^T],

        c_i = a_i / l_i and d_i = p_i / l_i^4 for the turns a_i with the displacements p_i.
        """
        flat = self._faces.flat
        stretch = _tensors(self.strains[:3] * [[2.0], [2.0], [1.0]]) + np.eye(2)[:, :, None]
        pull, moment = _tensors(self._forces[:3]), _tensors(self._forces[3:])
        bent = (self._forces[3:] * self.strains[3:]).sum(axis=0)
        by_gradient = -np.einsum("abm,bcm->acm", stretch, pull)
        by_gradient += (self.energy() - bent) * np.eye(2)[:, :, None]
        u = flat.outward * flat.lengths
        sides = np.stack([-u[1], u[0]])
        bent_u = np.einsum("abm,bem->aem", moment, u)
        turned = np.stack([-bent_u[1], bent_u[0]])
        per_length = self._turns / flat.lengths**2 / flat.areas
        moved = self._faces.shares * self._state_at_edges / flat.lengths**4 / flat.areas
        by_gradient += np.einsum("em,aem,bem->abm", 2 * per_length, turned, sides)
        along = -2 * moved * (u * bent_u).sum(axis=0)
        by_gradient += np.einsum("em,aem,bem->abm", along, sides, sides)
        return np.asarray(np.einsum("abm,bim->aim", by_gradient, flat.slopes))

    def hessian(self) -> list[Array]:
        """Return the second derivative, N/m: of the faces (m, 21, 21), of the folds (f, 12, 12)."""
        faces = self._material_part(self.laminate.stiffness())
        self._add_membrane_forces(faces, self._forces[:3])
        left, right = self._folds.sharpness_hessian_rows()
        left *= self._torques
        return [faces, fold_product(left, right)]

    def convex_hessian(self) -> list[Array]:
        """Return the Hessian with what can make it indefinite left out.

        Negative eigenvalues of the laminate's stiffness and of the membrane forces count as zero,
        and so does the second derivative of the turns.
        """
        # strain and thickness times curvature are comparable, so that is what is projected
        units = np.repeat([1.0, 1 / self._faces.laminate.thickness], 3)
        scale = np.multiply.outer(units, units)
        stiffness = np.moveaxis(self.laminate.stiffness(), 2, 0)
        convex = _clip_eigenvalues(stiffness * scale) / scale
        faces = self._material_part(np.moveaxis(convex, 0, 2))
        self._add_membrane_forces(faces, _tension(self._forces[:3]))
        return [faces, np.zeros((self._faces.fold_dofs.shape[2], 12, 12))]

    @cached_property
    def _forces(self) -> Array:
        """Derivative of the energy by strain and curvature, (6, m)."""
        return self._faces.flat.areas * self.laminate.resultants()

    @cached_property
    def _moments(self) -> Array:
        """Derivative of the energy by the turns l_i a_i, (3, m)."""
        return (self._faces.bending * self._forces[3:, None]).sum(axis=0)

    @cached_property
    def _torques(self) -> Array:
        """Derivative of the energy by the sharpness of each fold, from both of its faces, (f,)."""
        faces = self._faces
        return sum_at(faces.folds, faces.turn_factors * self._moments, faces.fold_dofs.shape[2])

    def _strain_gradient(self) -> Array:
        """Return the derivative of strain and curvature by the stencil, shape (6, 21, m)."""
        faces = self._faces
        slope = np.zeros((6, 21, faces.folds.shape[1]))
        at_nodes = slope[:, :_POSITIONS].reshape(6, 3, 6, -1)
        at_nodes[:3, :, :3] = self._triangles.strain_gradient()
        sharpness = self._folds.sharpness_gradient.reshape(3, -1)[:, faces.fold_nodes]
        turns = faces.turn_factors * sharpness
        for edge, nodes in enumerate(_FOLDS):
            per_turn = faces.bending[:, edge]
            at_nodes[3:, :, nodes] += per_turn[:, None, None] * turns[:, :, edge]
            slope[3:, _POSITIONS + edge] = per_turn * faces.shares[edge]
        return slope

    def _material_part(self, stiffness: Array) -> Array:
        """Return the part of the Hessian that a laminate's stiffness (6, 6, m) makes."""
        parts = self._faces.flat.areas * stiffness, self._strain_gradient()
        # matrix products are many times slower where a face's numbers are not side by side
        stiff, slope = (np.ascontiguousarray(part.transpose(2, 0, 1)) for part in parts)
        return slope.transpose(0, 2, 1) @ (stiff @ slope)

    def _add_membrane_forces(self, hessian: Array, forces: Array) -> None:
        """Add membrane forces (3, m) times the second derivative of the strain."""
        pairs = self._faces.flat.strain_hessian(forces)
        for first in range(0, _POSITIONS, 6):
            corners = slice(first, first + 3)
            hessian[:, corners, corners] += pairs


def _sides_at(triangles: NDArray[np.int64], edges: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which edges of triangles, each opposite to a corner, are some edges, (m, 3)."""
    ends = np.sort(np.stack([triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]], axis=2), axis=2)
    key = np.array([triangles.max() + 1, 1])
    return np.isin(ends @ key, edges @ key)


def _places_beyond(corners: Array, flat: FlatTriangles, sides: NDArray[np.bool_]) -> Array:
    """Return a place beyond each of some edges of triangles, far enough for an edge that slides."""
    middles = (np.roll(corners, -1, axis=1) + np.roll(corners, -2, axis=1)) / 2
    outward = (flat.outward * FAR_BEYOND * flat.lengths).transpose(2, 1, 0)
    return np.asarray((middles + outward)[sides])


def _clip_eigenvalues(matrices: Array) -> Array:
    """Return symmetric matrices with their negative eigenvalues set to zero."""
    values, vectors = np.linalg.eigh(matrices)
    return (vectors * np.maximum(values, 0.0)[:, None]) @ vectors.transpose(0, 2, 1)


def _tensors(parts: Array) -> Array:
    """Return the symmetric tensors (2, 2, m) of parts (xx, yy, xy), shape (3, m)."""
    xx, yy, xy = parts
    return np.array([[xx, xy], [xy, yy]])


def _tension(force: Array) -> Array:
    """Return membrane forces (3, m) without their pressure."""
    tensor = np.stack([force[0], force[2], force[2], force[1]], axis=1).reshape(-1, 2, 2)
    pulled = _clip_eigenvalues(tensor)
    return np.stack([pulled[:, 0, 0], pulled[:, 1, 1], pulled[:, 0, 1]])
