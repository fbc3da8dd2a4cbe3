"""The deformation of the layers of a solid, for the fields of a result.

The gradient of a quadratic displacement is linear in a tetrahedron, and so is the pressure: their
values at its vertices tell all. Each is taken over the centroids of the planar triangles, at the
faces of the layers and in their middle.
"""

from dataclasses import dataclass

import basix.ufl
import numpy as np
from numpy.typing import NDArray

from bilayer.mechanics.layer_state import LayerState, polar_rotation
from bilayer.mechanics.memory import ELASTIC, Memory
from bilayer.specimen.prestretch import StretchPair
from fenics_model.api import dolfinx_api
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.release.specimen_solid import SpecimenSolid, natural_state
from fenics_model.solid.solid import SolidLayer
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import NOTHING

Array = NDArray[np.float64]

PRISM = 3
"""Tetrahedra in a prism, see `fenics_model.mesh.volume_mesh`."""
ENDS = ((0, (1, 1, 1, 0)), (2, (0, 1, 1, 1)))
"""The tetrahedron of a prism that has its first end as a face, and the vertices there; its last."""
MIDDLE = (1, (1 / 3, 1 / 6, 1 / 6, 1 / 3))
"""The tetrahedron that the centroid of a prism lies in, and its barycentric coordinates there."""


@dataclass(frozen=True, eq=False)
class _Vertices:
    """Values at the four vertices of all cells of the volume mesh, in its order."""

    gradient: Array  # (c, 4, 3, 3)
    pressure: Array  # (c, 4), Pa
    dead: Array  # (c, 4, 3, 3), what is remembered of the stress, Pa


def layer_states(body: SpecimenSolid, stretch: StretchPair, state: State) -> list[LayerState]:
    """Return the deformation of each layer, the same on every rank.

    Parameters
    ----------
    body : SpecimenSolid
        With the natural states of the prestretch.
    stretch : (float, float)
        The prestretch.
    state : State
        The equilibrium.
    """
    solid, specimen = body.solid, body.specimen
    rule = specimen.prestretch.thickness
    at_vertices = [_gather(solid.mesh, part) for part in _cell_values(body, state)]
    gradient, pressures, energies, dead = at_vertices
    volumes = _cell_volumes(solid.mesh)
    found = []
    for number, name in enumerate(body.layer_names):
        own = solid.mesh.volume.layer == number
        natural = _natural(natural_state(specimen.bonded_layer(name, stretch).stretch, rule))
        values = _Vertices(gradient[own], pressures[own, number], dead[own])
        faces = body.mesh.faces_of(name)
        elastic, pressure, pull = _at_levels(values, len(faces), _is_mirrored(solid.mesh, own))
        elastic = elastic @ natural
        shape = (-1, len(faces), PRISM)
        found.append(
            LayerState(
                name,
                faces,
                np.swapaxes(elastic, -1, -2) @ elastic,
                polar_rotation(elastic),
                pressure,
                energies[own, 0].reshape(shape).sum(axis=(0, 2)),
                volumes[own].reshape(shape).sum(axis=(0, 2)) / np.linalg.det(natural),
                _memory(solid.layers[number], pull, natural),
            )
        )
    return found


def _natural(state: tuple[float, float, float, float]) -> Array:
    x, shear, y, across = state
    return np.array([[x, shear, 0], [shear, y, 0], [0, 0, across]])


def _memory(layer: SolidLayer, pull: Array, natural: Array) -> Memory:
    """Return what a layer remembers, with the flat bonded state as reference of its dead stress."""
    if layer.memory is NOTHING:
        return ELASTIC
    volume = float(np.linalg.det(natural))
    bonded = np.diag([1.0, 1.0, 1 / volume])  # grad(x)
    return Memory(float(layer.memory.factor.value), volume * (bonded @ pull @ bonded))


def _cell_values(body: SpecimenSolid, state: State) -> tuple[Array, Array, Array, Array]:
    """Return gradients and pressures at the vertices of this rank's cells, and their energies.

    Then the dead stresses at the vertices.
    """
    solid = body.solid
    mesh, values = solid.mesh.mesh, state.values
    corners = np.eye(4)[:, 1:]  # of the reference tetrahedron
    quadratic = basix.ufl.element("Lagrange", "tetrahedron", 2)
    slopes = quadratic.tabulate(1, corners)[1:]  # (3, 4, 10)
    nodes = mesh.geometry.x[dolfinx_api.geometry_dofmap(mesh)]
    frame = np.moveaxis(nodes[:, 1:] - nodes[:, :1], 1, 2)  # columns are the edges from vertex 0
    dofs = np.stack([solid.component(axis).dofmap.list for axis in range(3)], axis=1)
    by_reference = np.einsum("cid,rvd->cvir", values[dofs], slopes)
    gradient = np.eye(3) + by_reference @ np.linalg.inv(frame)[:, None]
    layers = range(len(solid.layers))
    scale = float(solid.pressure_scale.value)
    pressures = [values[solid.pressure_space(i).dofmap.list[:, :4]] for i in layers]
    energies = sum(solid.cell_energies(i, state) for i in layers)
    ordered = _volume_order(solid.mesh)
    none = np.zeros((*ordered.shape, 3, 3))
    dead = none if body.memory is None else body.memory.dead_stress_at_vertices()
    return (
        np.take_along_axis(gradient, ordered[:, :, None, None], axis=1),
        scale * np.stack([np.take_along_axis(p, ordered, axis=1) for p in pressures], axis=1),
        np.asarray(energies)[:, None],
        np.take_along_axis(dead, ordered[:, :, None, None], axis=1),
    )


def _volume_order(mesh: LayeredMesh) -> NDArray[np.int64]:
    """Return where in its cell on this rank each vertex of the volume mesh's cells is, (c, 4)."""
    wanted = mesh.volume.cells[mesh.mesh.topology.original_cell_index]
    own = np.argsort(mesh.cell_vertices, axis=1)
    rank = np.argsort(np.argsort(wanted, axis=1), axis=1)
    return np.take_along_axis(own, rank, axis=1)


def _gather(mesh: LayeredMesh, values: Array) -> Array:
    """Return values of this rank's cells for all cells of the volume mesh, on every rank."""
    owned = mesh.mesh.topology.index_map(3).size_local
    numbers = mesh.mesh.topology.original_cell_index[:owned]
    whole = np.zeros((len(mesh.volume.cells), *values.shape[1:]))
    for cells, part in mesh.mesh.comm.allgather((numbers, values[:owned])):
        whole[cells] = part
    return whole


def _cell_volumes(mesh: LayeredMesh) -> Array:
    """Return the volumes of all cells of the volume mesh, m3."""
    corners = mesh.volume.points[mesh.volume.cells]
    return np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6


def _is_mirrored(mesh: LayeredMesh, own: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return for each element through a layer whether its prisms are cut from the top down."""
    points, cells = mesh.volume.points, mesh.volume.cells[own]
    first = points[
        cells[::PRISM], 2
    ]  # of the first tetrahedron, three vertices of which are an end
    return np.asarray(first[:, 0] > first[:, 3])


def _at_levels(values: _Vertices, faces: int, mirrored: NDArray[np.bool_]) -> tuple[Array, ...]:
    """Return gradient, pressure and dead stress at bottom, middle and top of a layer, by face."""
    gradient = values.gradient.reshape(-1, faces, PRISM, 4, 3, 3)
    pressure = values.pressure.reshape(-1, faces, PRISM, 4)
    dead = values.dead.reshape(-1, faces, PRISM, 4, 3, 3)
    turned = mirrored.reshape(-1, faces)[:, 0]
    count = len(turned)
    half = count // 2

    def at(element: int, place: str) -> tuple[Array, Array, Array]:
        ends = ENDS[::-1] if turned[element] else ENDS
        cell, weights = {"bottom": ends[0], "middle": MIDDLE, "top": ends[1]}[place]
        share = np.array(weights) / sum(weights)
        return (
            np.einsum("v,fvij->fij", share, gradient[element, :, cell]),
            pressure[element, :, cell] @ share,
            np.einsum("v,fvij->fij", share, dead[element, :, cell]),
        )

    middle = [at(half, "middle")] if count % 2 else [at(half - 1, "top"), at(half, "bottom")]
    mean = tuple(sum(part) / len(middle) for part in zip(*middle, strict=True))
    levels = [at(0, "bottom"), mean, at(count - 1, "top")]
    return tuple(np.array(part) for part in zip(*levels, strict=True))
