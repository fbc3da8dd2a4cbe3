"""A shell of flat triangles that bend by Morley's rule: the accurate model's only energy.

Unknowns are the positions of the nodes and one displacement p per edge. Edge i of a face, of flat
length l_i and outward in-plane normal n_i, turns by

    a_i = t_i / 2 + p_i / l_i   in its first face,      t_i / 2 - p_i / l_i   in its second,

t = theta l / l' the angle across it (0 at the boundary) by how much the edge has stretched (see
`dshell.turns`), so p / l shares that turn out between the faces; the curvature of a face of area A
is

    k = sum_i (l_i / A) a_i  n_i (x) n_i.

That is Morley's triangle (1968) for small deflections: constant curvature is exact on any mesh.
With the constant strain of the membrane, a laminate gives the energy of each face.
"""

from copy import copy
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.assembly import coordinates_of
from dshell.hinges import symmetric_product
from dshell.membrane import FlatTriangles
from dshell.through_thickness import Laminate
from dshell.topology import FaceNeighbours
from dshell.turns import TURN_ROWS, Turn

Array = NDArray[np.float64]

_FOLDS = ((1, 2, 0, 3), (2, 0, 1, 4), (0, 1, 2, 5))
"""The hinge over each edge, among the face's six nodes: its corners and the apexes beyond them.

First the hinge's ends, then the apex of the face and that beyond the edge."""
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
    """

    name: ClassVar[str] = "elastic"

    def __init__(self, points: Array, triangles: NDArray[np.int64], laminate: Laminate) -> None:
        around = FaceNeighbours.of(triangles)
        self.laminate = laminate
        self.edge_count = around.edge_count
        self.flat = FlatTriangles(points[triangles])
        self.turn_factors = 0.5 * self.flat.lengths**2 * around.shared.T
        self.shares = around.side.T
        nodes = np.column_stack([triangles, around.apexes])
        by_axis = coordinates_of(nodes).transpose(0, 2, 1).reshape(len(nodes), -1)
        self.dofs = np.column_stack([by_axis, 3 * len(points) + around.edges])
        x, y = self.flat.outward
        self.bending = np.stack([x * x, y * y, 2 * x * y]) / self.flat.areas

    def made_of(self, laminate: Laminate) -> "MorleyFaces":
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
        faces.dofs, faces.bending = self.dofs[block], self.bending[:, :, block]
        return faces

    def at(self, values: Array) -> "BentFaces":
        """Return the faces in a state; values have shape (m, 21), in m."""
        return BentFaces(self, values)


class BentFaces:
    """Morley's faces in some state.

    Parameters
    ----------
    faces : MorleyFaces
        What is bent.
    values : (m, 21) array of float
        Their degrees of freedom, m.
    """

    def __init__(self, faces: MorleyFaces, values: Array) -> None:
        self._faces = faces
        by_dof = np.ascontiguousarray(values.T)
        nodes = by_dof[:_POSITIONS].reshape(3, 6, -1)
        self._triangles = faces.flat.at(nodes[:, :3])
        self._folds = Turn(nodes[:, np.transpose(_FOLDS)])  # (3, 4, 3, m): edge after node
        turns = faces.turn_factors * self._folds.sharpness
        turns += faces.shares * by_dof[_POSITIONS:]
        curvature = (faces.bending * turns).sum(axis=1)
        self.strains = np.concatenate([self._triangles.strain(), curvature])
        """Strain and curvature (Exx, Eyy, 2 Exy, kxx, kyy, 2 kxy), shape (6, m)."""
        self._laminate = faces.laminate.at(self.strains)

    def energy(self) -> Array:
        """Return each face's energy, J, shape (m,)."""
        return self._faces.flat.areas * self._laminate.energy()

    def layer_energies(self) -> dict[str, float]:
        """Return the energy of each layer by its name, J."""
        areas = self._faces.flat.areas
        return {
            bent.layer.name: float(areas[bent.layer.covered] @ bent.energy())
            for bent in self._laminate.layers
        }

    def gradient(self) -> Array:
        """Return the derivative of the energy by the values, N, shape (m, 21)."""
        gradient = np.zeros((21, len(self._faces.dofs)))
        at_nodes = gradient[:_POSITIONS].reshape(3, 6, -1)
        at_nodes[:, :3] = self._triangles.forces(self._forces[:3])
        torques = self._faces.turn_factors * self._moments
        for edge, nodes in enumerate(_FOLDS):
            at_nodes[:, nodes] += torques[edge] * self._folds.sharpness_gradient[:, :, edge]
        gradient[_POSITIONS:] = self._faces.shares * self._moments
        return gradient.T

    def hessian(self) -> Array:
        """Return the second derivative by the values, N/m, shape (m, 21, 21)."""
        left, right = np.zeros((2, len(self._faces.dofs), 6 + 3 * TURN_ROWS, 21))
        self._set_material_rows(left[:, :6], right[:, :6], self._laminate.stiffness())
        left_rows, right_rows = self._folds.sharpness_hessian_rows()
        left_rows *= self._faces.turn_factors * self._moments
        for edge in range(3):
            rows = slice(6 + edge * TURN_ROWS, 6 + (edge + 1) * TURN_ROWS)
            _set_fold(left[:, rows], edge, left_rows[:, :, :, edge])
            _set_fold(right[:, rows], edge, right_rows[:, :, :, edge])
        hessian = symmetric_product(left, right)
        self._add_membrane_forces(hessian, self._forces[:3])
        return hessian

    def convex_hessian(self) -> Array:
        """Return the Hessian with what can make it indefinite left out.

        Negative eigenvalues of the laminate's stiffness and of the membrane forces count as zero,
        and so does the second derivative of the turns.
        """
        # strain and thickness times curvature are comparable, so that is what is projected
        units = np.repeat([1.0, 1 / self._faces.laminate.thickness], 3)
        scale = np.multiply.outer(units, units)
        stiffness = np.moveaxis(self._laminate.stiffness(), 2, 0)
        convex = _without_negative(stiffness * scale) / scale
        left, right = np.zeros((2, len(self._faces.dofs), 6, 21))
        self._set_material_rows(left, right, np.moveaxis(convex, 0, 2))
        hessian = symmetric_product(left, right)
        self._add_membrane_forces(hessian, _tension(self._forces[:3]))
        return hessian

    @cached_property
    def _forces(self) -> Array:
        """Derivative of the energy by strain and curvature, (6, m)."""
        return self._faces.flat.areas * self._laminate.resultants()

    @cached_property
    def _moments(self) -> Array:
        """Derivative of the energy by the turns l_i a_i, (3, m)."""
        return (self._faces.bending * self._forces[3:, None]).sum(axis=0)

    def _strain_gradient(self) -> Array:
        """Return the derivative of strain and curvature by the values, shape (6, 21, m)."""
        faces = self._faces
        slope = np.zeros((6, 21, len(faces.dofs)))
        at_nodes = slope[:, :_POSITIONS].reshape(6, 3, 6, -1)
        at_nodes[:3, :, :3] = self._triangles.strain_gradient()
        for edge, nodes in enumerate(_FOLDS):
            per_turn = faces.bending[:, edge]
            turn = faces.turn_factors[edge] * self._folds.sharpness_gradient[:, :, edge]
            at_nodes[3:, :, nodes] += per_turn[:, None, None] * turn
            slope[3:, _POSITIONS + edge] = per_turn * faces.shares[edge]
        return slope

    def _set_material_rows(self, left: Array, right: Array, stiffness: Array) -> None:
        """Set the rows of which S[left^T right] is the part of the laminate's stiffness."""
        right[:] = self._strain_gradient().transpose(2, 0, 1)
        half = 0.5 * self._faces.flat.areas * stiffness
        np.matmul(np.ascontiguousarray(half.transpose(2, 0, 1)), right, out=left)

    def _add_membrane_forces(self, hessian: Array, forces: Array) -> None:
        """Add membrane forces (3, m) times the second derivative of the strain."""
        pairs = self._faces.flat.strain_hessian(forces)
        for first in range(0, _POSITIONS, 6):
            corners = slice(first, first + 3)
            hessian[:, corners, corners] += pairs


def _set_fold(rows: Array, edge: int, fold: Array) -> None:
    """Set rows over the values, (m, r, 21), to ones over the nodes of a fold, (r, 3, 4, m)."""
    at_nodes = rows[:, :, :_POSITIONS].reshape(*rows.shape[:2], 3, 6)
    for place, node in enumerate(_FOLDS[edge]):
        at_nodes[:, :, :, node] = fold[:, :, place].transpose(2, 0, 1)


def _without_negative(matrices: Array) -> Array:
    """Return symmetric matrices with their negative eigenvalues set to zero."""
    values, vectors = np.linalg.eigh(matrices)
    return (vectors * np.maximum(values, 0.0)[:, None]) @ vectors.transpose(0, 2, 1)


def _tension(force: Array) -> Array:
    """Return membrane forces (3, m) without their pressure."""
    tensor = np.stack([force[0], force[2], force[2], force[1]], axis=1).reshape(-1, 2, 2)
    pulled = _without_negative(tensor)
    return np.stack([pulled[:, 0, 0], pulled[:, 1, 1], pulled[:, 0, 1]])
