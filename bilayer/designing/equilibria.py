"""Shapes of designs, and the gradient of a function of the shape by their variables.

A shape is searched from that of a design nearby, on the same planar mesh, moved. With the factor of
the equilibrium's stiffness one solution gives the adjoint, and that gives the derivative by every
variable: no further equilibrium is computed.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.self_contact import self_contact_gap
from bilayer.contact.skin import BondedBody
from bilayer.designing.mesh_motion import move_points
from bilayer.designing.variables import is_of_the_sheet, value_of, with_values
from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh
from bilayer.solvers.contract import (
    Equilibrium,
    Linearised,
    Saved,
    ShapeLinearised,
    Solver,
    SpecimenPath,
)
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

NOT_COUNTED = np.array(-1)
SMALL_CHANGE = 1e-6
"""Of a number of the sheet, relative, for the motion of the mesh."""


@dataclass(frozen=True, eq=False)
class SheetMesh:
    """A planar mesh that moves with the design.

    Parameters
    ----------
    specimen : Specimen
        What it was made for.
    mesh : PlanarMesh
        Its mesh.
    """

    specimen: Specimen
    mesh: PlanarMesh

    def of(self, specimen: Specimen) -> PlanarMesh:
        """Return the mesh of a specimen nearby.

        Raises
        ------
        InputError
            A triangle would turn over.
        """
        points = move_points(self.mesh.points, self.specimen, specimen)
        return self.mesh if points is self.mesh.points else self.mesh.with_points(points)

    def least_area_ratio(self, specimen: Specimen) -> float:
        """Return the least ratio of a triangle's area, moved, to what it was."""
        points = move_points(self.mesh.points, self.specimen, specimen)
        a, b, c = np.moveaxis(points[self.mesh.triangles], 1, 0)
        doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        return float((doubled / 2 / self.mesh.areas).min())

    def velocity(self, specimen: Specimen, name: str) -> Array:
        """Return the derivative of the nodes' flat places by a number of the sheet, (n, 2)."""
        value = value_of(specimen, name)
        step = SMALL_CHANGE * max(abs(value), 1e-3)
        ahead, behind = (
            move_points(
                self.mesh.points, self.specimen, with_values(specimen, {name: value + sign * step})
            )
            for sign in (1.0, -1.0)
        )
        return np.asarray((ahead - behind) / (2 * step))


class DesignShape:
    """A design's equilibrium, live.

    Parameters
    ----------
    specimen : Specimen
        With one milestone.
    mesh : SheetMesh
        Its moving mesh.
    path : SpecimenPath
        At the equilibrium.
    equilibrium : Equilibrium
        Where the path is.
    """

    def __init__(
        self, specimen: Specimen, mesh: SheetMesh, path: SpecimenPath, equilibrium: Equilibrium
    ) -> None:
        self.specimen, self._mesh = specimen, mesh
        self._path, self.equilibrium = path, equilibrium

    @property
    def surface(self) -> Surface:
        """The reference surface, m."""
        return Surface(self.equilibrium.position, self._path.mesh.triangles)

    @property
    def mesh(self) -> PlanarMesh:
        """Its planar mesh."""
        return self._path.mesh

    @cached_property
    def gap(self) -> float:
        """Smallest distance of the body from itself, m; see `self_contact_gap`."""
        body = BondedBody.of(self.specimen, self.mesh, self.equilibrium.stretch)
        return self_contact_gap(body, self.equilibrium.position)

    @cached_property
    def linearised(self) -> Linearised:
        """The equations near it, the stiffness factorised."""
        return self.equilibrium.linearised()

    def gradient(self, position_gradient: Array, names: Sequence[str]) -> Array:
        """Return the derivatives of a function of the shape by numbers of the design.

        Parameters
        ----------
        position_gradient : (n, 3) array of float
            Of the function, by the position. A rigid motion does not change it.
        names : sequence of str
            See `bilayer.designing.variables`.
        """
        equations = self.linearised
        adjoint = equations.solve(equations.state_gradient(position_gradient))
        by_points = None
        derivatives = []
        for name in names:
            if is_of_the_sheet(name):
                if by_points is None:
                    by_points = _shape_equations(equations).points_gradient(
                        adjoint, position_gradient
                    )
                velocity = self._mesh.velocity(self.specimen, name)
                derivatives.append(float(np.sum(by_points * velocity)))
            else:
                direct = np.sum(position_gradient * equations.position_by(name))
                derivatives.append(float(direct - adjoint @ equations.residual_by(name)))
        return np.array(derivatives)

    def changes(self, names: Sequence[str]) -> Array:
        """Return the derivatives of the position by numbers of the design, (k, n, 3).

        Each takes one solution with the factor that is there.
        """
        return np.array([self._change(name) for name in names])

    def _change(self, name: str) -> Array:
        equations = self.linearised
        if is_of_the_sheet(name):
            of_shape = _shape_equations(equations)
            velocity = self._mesh.velocity(self.specimen, name)
            residual, position = (
                of_shape.residual_along(velocity),
                of_shape.position_along(velocity),
            )
        else:
            residual, position = equations.residual_by(name), equations.position_by(name)
        return position - equations.position_change(equations.solve(residual))


def _shape_equations(equations: Linearised) -> ShapeLinearised:
    if not isinstance(equations, ShapeLinearised):
        raise InputError("solver: expected one that is differentiated by the flat sheet: 'dshell'")
    return equations


def find_shape(
    solver: Solver, settings: Any, specimen: Specimen, mesh: SheetMesh, near: Saved | None = None
) -> DesignShape:
    """Return the shape of a design.

    Parameters
    ----------
    solver, settings
        What computes.
    specimen : Specimen
        With one milestone.
    mesh : SheetMesh
        Of a design nearby.
    near : mapping, optional
        A saved equilibrium of a design nearby on the same moving mesh; from flat if left out.

    Raises
    ------
    ComputationError
        There is none nearby.
    InputError
        The mesh cannot be moved so far.
    """
    path = solver.open_path(
        specimen, settings, mesh=mesh.of(specimen), start=None, comm=None, progress=None
    )
    with closing(path):
        if near is not None:
            path.restore({**near, "unstable_modes": NOT_COUNTED})
        *_, last = path.approach(specimen.prestretch.milestones[-1])
        return DesignShape(specimen, mesh, path, last)
