"""Shapes of designs, and the gradient of a function of the shape by their variables.

A shape is searched from that of a design nearby, on the same planar mesh, moved. With the factor of
the equilibrium's stiffness one solution gives the adjoint, and that gives the derivative by every
variable: no further equilibrium is computed.
"""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.self_contact import self_contact_gap
from bilayer.contact.skin import BondedBody
from bilayer.designing.mesh_motion import move_points
from bilayer.designing.variables import is_of_the_sheet, value_of, with_values
from bilayer.errors import ComputationError, InputError
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import (
    Equilibrium,
    Linearised,
    PointsLinearised,
    Saved,
    ShapeLinearised,
    Solver,
    SpecimenPath,
    Start,
)
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

SMALL_CHANGE = 1e-6
"""Of a number of the sheet, relative, for the motion of the mesh."""


@dataclass(frozen=True, eq=False)
class Model:
    """What computes the shapes of designs.

    Parameters
    ----------
    solver : Solver
        The solver.
    settings : settings dataclass
        Of one of its models.
    start : Start
        Of a shape that no shape nearby is known of.
    nearby : settings dataclass, optional
        Of a shape that is searched from one nearby, if not those.
    progress : callable, optional
        Told what is being done.
    """

    solver: Solver
    settings: Any
    start: Start = None
    nearby: Any = None
    progress: Progress | None = None


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
    """A design's equilibrium, live until it is closed.

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
        self._state_changes: dict[str, Array] = {}
        self._fixed_changes: dict[str, tuple[Array, Array]] = {}

    def close(self) -> None:
        """Free what the solver holds."""
        self._path.close()

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
        of_sheet = [is_of_the_sheet(name) for name in names]
        if any(of_sheet) and isinstance(equations, PointsLinearised):
            by_points = equations.points_gradient(adjoint, position_gradient)
        else:
            by_points = None
        derivatives: list[float] = []
        for name, moves in zip(names, of_sheet, strict=True):
            if moves and by_points is not None:
                velocity = self._mesh.velocity(self.specimen, name)
                derivatives.append(float(np.sum(by_points * velocity)))
            else:
                residual, position = self._fixed_state_changes(name)
                direct = float(np.sum(position_gradient * position))
                derivatives.append(direct - float(adjoint @ residual))
        return np.array(derivatives)

    def changes(self, names: Sequence[str]) -> Array:
        """Return the derivatives of the position by numbers of the design, (k, n, 3).

        Each takes one solution with the factor that is there.
        """
        return np.array([self._change(name) for name in names])

    def _change(self, name: str) -> Array:
        _, position = self._fixed_state_changes(name)
        return position + self.linearised.position_change(self._state_change(name))

    def state_changes(self, names: Sequence[str]) -> Array:
        """Return the derivatives of the state by numbers of the design, (k, dofs)."""
        return np.array([self._state_change(name) for name in names])

    def _state_change(self, name: str) -> Array:
        if name not in self._state_changes:
            residual, _ = self._fixed_state_changes(name)
            self._state_changes[name] = -self.linearised.solve(residual)
        return self._state_changes[name]

    def _fixed_state_changes(self, name: str) -> tuple[Array, Array]:
        """Return the derivatives of residual and position by a number, the state fixed."""
        if name not in self._fixed_changes:
            self._fixed_changes[name] = self._compute_fixed_changes(name)
        return self._fixed_changes[name]

    def _compute_fixed_changes(self, name: str) -> tuple[Array, Array]:
        equations = self.linearised
        if not is_of_the_sheet(name):
            return equations.residual_by(name), equations.position_by(name)
        of_shape = _shape_equations(equations)
        velocity = self._mesh.velocity(self.specimen, name)
        return of_shape.residual_along(velocity), of_shape.position_along(velocity)


def _shape_equations(equations: Linearised) -> ShapeLinearised:
    if not isinstance(equations, ShapeLinearised):
        raise InputError("solver: expected one that is differentiated by the flat sheet")
    return equations


def find_shape(
    model: Model,
    specimen: Specimen,
    mesh: SheetMesh,
    near: Saved | None = None,
    change: Array | None = None,
) -> DesignShape:
    """Return the shape of a design; whoever asks for it closes it.

    Parameters
    ----------
    model : Model
        What computes.
    specimen : Specimen
        With one milestone.
    mesh : SheetMesh
        Of a design nearby.
    near : mapping, optional
        A saved equilibrium of a design nearby on the same moving mesh; if left out, the model's
        start.
    change : (dofs,) array of float, optional
        By how much the state is expected to differ from that one's; if this leads nowhere, the path
        goes there by load steps.

    Raises
    ------
    ComputationError
        There is none nearby.
    InputError
        The mesh cannot be moved so far.
    """
    if near is not None and change is not None:
        try:
            return _found(model, specimen, mesh, near, change)
        except ComputationError:
            pass
    return _found(model, specimen, mesh, near)


def _found(
    model: Model,
    specimen: Specimen,
    mesh: SheetMesh,
    near: Saved | None,
    change: Array | None = None,
) -> DesignShape:
    target = specimen.prestretch.milestones[-1]
    path = model.solver.open_path(
        specimen,
        model.settings if near is None or model.nearby is None else model.nearby,
        mesh=mesh.of(specimen),
        start=model.start if near is None else None,
        comm=None,
        progress=model.progress,
    )
    with ExitStack() as opened:
        opened.callback(path.close)
        if near is not None:
            path.restore_neighbour(near, None if change is None else target, change)
        *_, last = path.approach(target)
        opened.pop_all()
    return DesignShape(specimen, mesh, path, last)
