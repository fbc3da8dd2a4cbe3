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
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.assembly import coordinates_of
from dshell.membrane import FlatTriangles
from dshell.through_thickness import Laminate
from dshell.topology import FaceNeighbours
from dshell.turns import Turn

Array = NDArray[np.float64]

_FOLDS = ((1, 2, 0, 3), (2, 0, 1, 3), (0, 1, 2, 3))
"""Ends and apexes of the hinge over each edge, among the face's corners and the far apex."""
_POSITIONS = 18  # coordinates of six nodes; three edge displacements follow


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
        self._flat = FlatTriangles(points[triangles])
        self._turns = 0.5 * self._flat.lengths**2 * around.shared
        self._shares = around.side
        nodes = np.column_stack([triangles, around.apexes])
        self.dofs = np.column_stack(
            [coordinates_of(nodes).reshape(len(nodes), -1), 3 * len(points) + around.edges]
        )
        x, y = np.moveaxis(self._flat.outward, 2, 0)
        self._bending = (
            np.stack([x * x, y * y, 2 * x * y], axis=1) / self._flat.areas[:, None, None]
        )

    def made_of(self, laminate: Laminate) -> "MorleyFaces":
        """Return the same faces of another laminate; what they share is not computed anew."""
        faces = copy(self)
        faces.laminate = laminate
        return faces

    def energy(self, values: Array) -> Array:
        """Return each face's energy, J, shape (m,), from values of shape (m, 21) in m."""
        return self._flat.areas * self.laminate.energy(self.strains(values))

    def layer_energies(self, values: Array) -> dict[str, float]:
        """Return the energy of each layer by its name, J."""
        s = self.strains(values)
        totals = {}
        for layer in self.laminate.layers:
            on = layer.covered
            density = self.laminate.layer_energy(layer, s[:, on])
            totals[layer.name] = float(self._flat.areas[on] @ density)
        return totals

    def gradient(self, values: Array) -> Array:
        """Return the derivative of the energy by the values, N, shape (m, 21)."""
        corners, folds = self._geometry(values)
        forces = self._flat.areas * self.laminate.resultants(self._strains(values, folds))
        return (forces.T[:, None] @ self._strain_gradient(corners, folds))[:, 0]

    def hessian(self, values: Array) -> Array:
        """Return the second derivative by the values, N/m, shape (m, 21, 21)."""
        corners, folds = self._geometry(values)
        s = self._strains(values, folds)
        resultants, stiffness = self.laminate.resultants_and_stiffness(s)
        hessian = self._material_part(stiffness, corners, folds)
        forces = self._flat.areas * resultants
        _add_to_corners(hessian, self._flat.strain_hessian(forces[:3]))
        moments = self._turns * np.einsum("mki,km->mi", self._bending, forces[3:])
        for edge, fold in enumerate(folds):
            _add_fold(hessian, edge, fold.sharpness_hessian(moments[:, edge]))
        return hessian

    def convex_hessian(self, values: Array) -> Array:
        """Return the Hessian with what can make it indefinite left out.

        Negative eigenvalues of the laminate's stiffness and of the membrane forces count as zero,
        and so does the second derivative of the turns.
        """
        corners, folds = self._geometry(values)
        s = self._strains(values, folds)
        # strain and thickness times curvature are comparable, so that is what is projected
        units = np.repeat([1.0, 1 / self.laminate.thickness], 3)
        scale = np.multiply.outer(units, units)
        resultants, stiffness = self.laminate.resultants_and_stiffness(s)
        convex = _without_negative(np.moveaxis(stiffness, 2, 0) * scale) / scale
        hessian = self._material_part(np.moveaxis(convex, 0, 2), corners, folds)
        tension = _tension(self._flat.areas * resultants[:3])
        _add_to_corners(hessian, self._flat.strain_hessian(tension))
        return hessian

    def strains(self, values: Array) -> Array:
        """Return strain and curvature (Exx, Eyy, 2 Exy, kxx, kyy, 2 kxy), shape (6, m)."""
        return self._strains(values, self._geometry(values)[1])

    def _geometry(self, values: Array) -> tuple[Array, list[Turn]]:
        nodes = values[:, :_POSITIONS].reshape(-1, 6, 3)
        folds = [Turn(nodes[:, [0, 1, 2, 3 + edge]], ends) for edge, ends in enumerate(_FOLDS)]
        return nodes[:, :3], folds

    def _strains(self, values: Array, folds: list[Turn]) -> Array:
        sharpness = np.column_stack([fold.sharpness for fold in folds])
        turns = self._turns * sharpness + self._shares * values[:, _POSITIONS:]
        curvature = (self._bending @ turns[:, :, None])[:, :, 0]
        return np.concatenate([self._flat.strain(values[:, :9].reshape(-1, 3, 3)), curvature.T])

    def _strain_gradient(self, corners: Array, folds: list[Turn]) -> Array:
        """Return the derivative of strain and curvature by the values, shape (m, 6, 21)."""
        turns = np.zeros((len(corners), 3, 21))  # l_i a_i
        for edge, fold in enumerate(folds):
            slope = self._turns[:, edge, None, None] * fold.sharpness_gradient
            turns[:, edge, :9] = slope[:, :3].reshape(-1, 9)
            turns[:, edge, _apex(edge)] = slope[:, 3]
            turns[:, edge, _POSITIONS + edge] = self._shares[:, edge]
        slope = np.zeros((len(corners), 6, 21))
        slope[:, :3, :9] = self._flat.strain_gradient(corners).reshape(-1, 3, 9)
        slope[:, 3:] = self._bending @ turns
        return slope

    def _material_part(self, stiffness: Array, corners: Array, folds: list[Turn]) -> Array:
        slope = self._strain_gradient(corners, folds)
        stiffness = np.moveaxis(self._flat.areas * stiffness, 2, 0)
        return slope.transpose(0, 2, 1) @ (stiffness @ slope)


def _add_to_corners(hessian: Array, pairs: Array) -> None:
    """Add what couples corners (m, 3, 3), the same for each coordinate."""
    for axis in range(3):
        hessian[:, axis:9:3, axis:9:3] += pairs


def _add_fold(hessian: Array, edge: int, part: Array) -> None:
    """Add what couples the corners and the apex beyond an edge, (m, 12, 12)."""
    apex = _apex(edge)
    hessian[:, :9, :9] += part[:, :9, :9]
    hessian[:, :9, apex] += part[:, :9, 9:]
    hessian[:, apex, :9] += part[:, 9:, :9]
    hessian[:, apex, apex] += part[:, 9:, 9:]


def _apex(edge: int) -> slice:
    """Coordinates of the apex beyond an edge, among a face's values."""
    return slice(9 + 3 * edge, 12 + 3 * edge)


def _without_negative(matrices: Array) -> Array:
    """Return symmetric matrices with their negative eigenvalues set to zero."""
    values, vectors = np.linalg.eigh(matrices)
    return (vectors * np.maximum(values, 0.0)[:, None]) @ vectors.transpose(0, 2, 1)


def _tension(force: Array) -> Array:
    """Return membrane forces (3, m) without their pressure."""
    tensor = np.stack([force[0], force[2], force[2], force[1]], axis=1).reshape(-1, 2, 2)
    pulled = _without_negative(tensor)
    return np.stack([pulled[:, 0, 0], pulled[:, 1, 1], pulled[:, 0, 1]])
