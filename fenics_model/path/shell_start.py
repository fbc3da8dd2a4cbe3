"""An initial guess of the solid's state from the shape of another result on the same planar mesh.

The reference surface is extruded along its normals, each fibre shortened by what the surface has
stretched (the layers keep their volume), and the pressures are those of a plane stress state.
What this leaves of shear and of squeezed fibres is relaxed with that surface held (`relax_guess`);
released with it, Newton's method would wander.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem, la
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from fenics_model.api.jit import compiled_form
from fenics_model.mesh.layered_mesh import EDGES
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import natural_determinant
from fenics_model.solve.newton import Newton, NewtonOutcome
from fenics_model.solve.stopwatch import Stopwatch


def relax_guess(
    solid: Solid,
    held: Sequence[fem.DirichletBC],
    guess: State,
    tolerance: float,
    *,
    iteration_limit: int = 20,
    options: str = "",
    stopwatch: Stopwatch | None = None,
) -> NewtonOutcome:
    """Solve for everything but the reference surface, which stays where a guess has it."""
    here = solid.function_of(guess)
    surface = [
        fem.dirichletbc(
            here, solid.mesh.dofs_at(solid.component(axis), solid.mesh.volume.reference_surface)
        )
        for axis in range(3)
    ]
    with Newton(
        solid,
        [*held, *surface],
        iteration_limit=iteration_limit,
        options=options,
        stopwatch=stopwatch,
    ) as newton:
        return newton.solve(guess, tolerance)


class Extrusion:
    """Makes states of the solid from shapes of its reference surface.

    Parameters
    ----------
    solid : Solid
        Made of an extrusion of `mesh`.
    mesh : PlanarMesh
        The planar mesh.
    """

    def __init__(self, solid: Solid, mesh: PlanarMesh) -> None:
        self._solid, self._mesh = solid, mesh

    def extrude(self, shape: NDArray[np.float64]) -> State:
        """Return the state of a shape, with the natural states of the moment.

        Parameters
        ----------
        shape : (n, 3) array of float
            The deformed reference surface on the nodes, m.
        """
        solid = self._solid
        fibres = _Fibres(solid, self._mesh, shape)
        corners = solid.mesh.cell_vertices
        ends = corners[:, EDGES]
        flat = solid.mesh.volume.points
        moved = np.concatenate(
            [
                fibres.at_vertices(corners) - flat[corners],
                fibres.at_midpoints(ends) - flat[ends].mean(axis=2),
            ],
            axis=1,
        )
        values = np.zeros_like(solid.unknown.x.array)
        for axis in range(3):
            values[solid.component(axis).dofmap.list] = moved[:, :, axis]
        return self._with_plane_stress(State(values))

    def _with_plane_stress(self, state: State) -> State:
        """Set each pressure so that the fibre's own traction vanishes, averaged at vertices."""
        with self._solid.at(state):
            summed, weighed = (_assemble(form) for form in self._pressure_forms)
        there, values = weighed > 0, np.array(state.values)
        values[there] = summed[there] / weighed[there]
        return State(values)

    @cached_property
    def _pressure_forms(self) -> list[fem.Form]:
        """Pressures and weights, summed at the vertices.

        The stress is linear in the pressure, S = S0 + p S1; with the fibre g = F e_z and P = F S,
        the condition g . P e_z = 0 gives p = -(g . F S0 e_z) / (g . F S1 e_z).
        """
        solid = self._solid
        weights = ufl.TestFunctions(solid.space)[1:]
        F = solid.gradient
        sums = [0, 0]
        for index, (layer, weight) in enumerate(zip(solid.layers, weights, strict=True)):
            without, with_one = (ufl.dot(F[:, 2], (F * layer.stress(F, p))[:, 2]) for p in (0, 1))
            pressure = -without / (with_one - without) / solid.pressure_scale
            sums[0] += pressure * weight * solid.dx(index)
            sums[1] += weight * solid.dx(index)
        return [compiled_form(integral) for integral in sums]


def bonded_heights(solid: Solid) -> NDArray[np.float64]:
    """Return the height of each level of the mesh in the flat bonded state, m, (levels,)."""
    volume = solid.mesh.volume
    shrinking = np.array([1 / natural_determinant(layer.natural.value) for layer in solid.layers])
    steps = np.diff(volume.heights) * shrinking[volume.layer_between]
    heights = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(heights - heights[volume.reference_level])


class _Fibres:
    """The normals of the deformed surface, along which the layers' vertices lie."""

    def __init__(self, solid: Solid, mesh: PlanarMesh, shape: NDArray[np.float64]) -> None:
        volume = solid.mesh.volume
        self._surface = shape
        self._normal, area_stretch = _normals_and_stretch(mesh, shape)
        level, node = np.nonzero(volume.vertex_at >= 0)
        vertex = volume.vertex_at[level, node]
        self._node = np.empty(len(volume.points), dtype=np.int64)
        self._node[vertex] = node
        self._offset = np.empty(len(volume.points))
        self._offset[vertex] = bonded_heights(solid)[level] / area_stretch[node]

    def at_vertices(self, vertices: NDArray[np.int64]) -> NDArray[np.float64]:
        """Deformed positions of vertices, m."""
        node = self._node[vertices]
        return self._surface[node] + self._offset[vertices][..., None] * self._normal[node]

    def at_midpoints(self, ends: NDArray[np.int64]) -> NDArray[np.float64]:
        """Deformed positions of the middles of edges, m, by cubic Hermite interpolation."""
        a, b = self._node[ends[..., 0]], self._node[ends[..., 1]]
        chord = self._surface[b] - self._surface[a]
        bulge = _along(chord, self._normal[b]) - _along(chord, self._normal[a])
        normal = self._normal[a] + self._normal[b]
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        offset = self._offset[ends].mean(axis=-1)[..., None]
        return (self._surface[a] + self._surface[b]) / 2 + bulge / 8 + offset * normal


def _along(vector: NDArray[np.float64], unit: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sum(vector * unit, axis=-1, keepdims=True) * unit


def _normals_and_stretch(
    mesh: PlanarMesh, shape: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Area-weighted normals (n, 3) and deformed over flat area (n,) at the nodes."""
    a, b, c = np.moveaxis(shape[mesh.triangles], 1, 0)
    doubled = np.cross(b - a, c - a)
    vectors, after, before = np.zeros_like(shape), np.zeros(len(shape)), np.zeros(len(shape))
    for corner in mesh.triangles.T:
        np.add.at(vectors, corner, doubled)
        np.add.at(after, corner, np.linalg.norm(doubled, axis=1) / 2)
        np.add.at(before, corner, mesh.areas)
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True), after / before


def _assemble(form: fem.Form) -> NDArray[np.float64]:
    vector = fem.assemble_vector(form)
    vector.scatter_reverse(la.InsertMode.add)
    vector.scatter_forward()
    return vector.array
