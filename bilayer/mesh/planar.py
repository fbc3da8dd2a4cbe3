"""The planar mesh that both solvers share: points, triangles, and which layers lie on each.

The shell uses it as it is, the finite-element model extrudes it, so that two results differ by
their models and not by their meshes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.mesh.files import read_mesh_file, write_mesh_file
from bilayer.mesh.validity import check_points, check_region, check_sheet
from bilayer.specimen.two_layers import TWO_LAYERS

if TYPE_CHECKING:
    import meshio

PLANE_TOLERANCE = 1e-9
"""Range of z that a planar mesh in space may have, over its extent."""
ROUND_OFF = 1e-9
"""Distance over the extent of the mesh that counts as none."""


@dataclass(frozen=True, eq=False)
class PlanarMesh:
    """A triangulation of the bonded flat sheet. Its arrays are its own and cannot be written to.

    Parameters
    ----------
    points : (n, 2) array of float
        Node coordinates in the bonded flat state, m.
    triangles : (m, 3) array of int
        Nodes of each triangle, counterclockwise.
    region : (m,) array of int
        Number of the set of layers that lie on each triangle.
    layer_sets : sequence of frozenset of str
        The sets: names of the layers in each region. A bilayer's unless told: 0 the bare substrate,
        1 substrate and kirigami.

    Raises
    ------
    InputError
        Shapes or indices do not fit, or it is no single sheet; see `bilayer.mesh.validity`.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    region: NDArray[np.int64]
    layer_sets: tuple[frozenset[str], ...] = TWO_LAYERS

    def __post_init__(self) -> None:
        sets = tuple(frozenset(names) for names in self.layer_sets)
        object.__setattr__(self, "layer_sets", sets)
        known = tuple(number for number, names in enumerate(sets) if names)
        check_region(self.region, known)  # as given, before it becomes whole numbers
        for name, kind in (("points", np.float64), ("triangles", np.int64), ("region", np.int64)):
            own = np.array(getattr(self, name), dtype=kind, order="C")
            own.flags.writeable = False
            object.__setattr__(self, name, own)
        self._check_shapes()
        check_points(self.points)
        check_sheet(self.points, self.triangles)

    def _check_shapes(self) -> None:
        expected = {
            "points": (self.points, (len(self.points), 2)),
            "triangles": (self.triangles, (len(self.triangles), 3)),
            "region": (self.region, (len(self.triangles),)),
        }
        for name, (array, shape) in expected.items():
            if array.shape != shape or 0 in shape:
                raise InputError(f"{name} has shape {array.shape}: expected {shape}, not empty")

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """Signed area of each triangle, m2, shape (m,)."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])

    @cached_property
    def edges(self) -> NDArray[np.int64]:
        """Each edge once, as ascending node pairs in ascending order, shape (e, 2)."""
        return np.unique(self._corner_pairs, axis=0)

    @cached_property
    def boundary_edges(self) -> NDArray[np.int64]:
        """Edges that belong to a single triangle, shape (b, 2)."""
        edges, count = np.unique(self._corner_pairs, axis=0, return_counts=True)
        return edges[count == 1]

    @cached_property
    def rim_nodes(self) -> NDArray[np.int64]:
        """Nodes on the outer boundary, ascending; those on the edges of holes are not among them.

        A hole that meets the outer boundary in a node counts as a part of it.
        """
        nodes, ends = np.unique(self.boundary_edges, return_inverse=True)
        start, end = ends.reshape(-1, 2).T
        pairs = scipy.sparse.coo_array(
            (np.ones(len(start)), (start, end)), shape=(len(nodes), len(nodes))
        )
        _, loop = scipy.sparse.csgraph.connected_components(pairs, directed=False)
        outermost = np.argmax(self.points[nodes, 0])
        return nodes[loop == loop[outermost]]

    @cached_property
    def centroid(self) -> NDArray[np.float64]:
        """Centre of the sheet's area, m, shape (2,); 0 if it is not away from it but for round-off.

        It need not lie on the sheet.
        """
        centre = self.areas @ self.points[self.triangles].mean(axis=1) / self.areas.sum()
        return np.where(np.abs(centre) > ROUND_OFF * np.ptp(self.points), centre, 0.0)

    @cached_property
    def centre_node(self) -> int:
        """The node nearest to the centroid."""
        from_centre = self.points - self.centroid
        return int(np.argmin(np.einsum("ij,ij->i", from_centre, from_centre)))

    @property
    def _corner_pairs(self) -> NDArray[np.int64]:
        t = self.triangles
        return np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)

    def faces_of(self, layer: str) -> NDArray[np.int64]:
        """Return the triangles that a layer covers, ascending."""
        there = [number for number, names in enumerate(self.layer_sets) if layer in names]
        return np.flatnonzero(np.isin(self.region, there))

    def with_points(self, points: NDArray[np.float64]) -> "PlanarMesh":
        """Return the same triangles and layers with their nodes elsewhere, m, (n, 2)."""
        return replace(self, points=points)

    def same_as(self, other: "PlanarMesh") -> bool:
        """Whether the other mesh has the same nodes, triangles and regions (points to 1e-12 m)."""
        return (
            self.points.shape == other.points.shape
            and np.array_equal(self.triangles, other.triangles)
            and np.array_equal(self.region, other.region)
            and self.layer_sets == other.layer_sets
            and np.allclose(self.points, other.points, rtol=0.0, atol=1e-12)
        )


def flat_surface(mesh: PlanarMesh) -> Surface:
    """Return the bonded flat state as a surface in space, z = 0."""
    return Surface(np.pad(mesh.points, ((0, 0), (0, 1))), mesh.triangles)


def write_planar_mesh(mesh: PlanarMesh, path: str | Path) -> None:
    """Write the mesh in any format that meshio writes, chosen by the file's ending.

    The region is the cell data `region` (and, in gmsh's formats, the physical tag).

    Raises
    ------
    InputError
        The format is unknown, or the folder cannot be written.
    ComputationError
        Writing failed, for example on a full disk.
    """
    import meshio  # takes long to load, and few need it

    cells = [("triangle", mesh.triangles)]
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    is_gmsh = Path(path).suffix == ".msh"
    names = ["gmsh:physical", "gmsh:geometrical"] if is_gmsh else ["region"]
    data = {name: [mesh.region.astype(np.int32)] for name in names}
    write_mesh_file(meshio.Mesh(points, cells, cell_data=data), path)


def read_planar_mesh(
    path: str | Path, layer_sets: Sequence[frozenset[str]] = TWO_LAYERS
) -> PlanarMesh:
    """Read a mesh in any format that meshio reads; without a region all layers lie everywhere.

    Nodes of nothing but points and lines, such as a drawing's construction points, are left out.

    Parameters
    ----------
    path : path-like
        The file.
    layer_sets : sequence of frozenset of str
        The layers that its regions stand for, see `bilayer.specimen.specimen.Specimen.layer_sets`;
        a bilayer's if left out.

    Raises
    ------
    InputError
        The file cannot be read, holds other than triangles in a plane z = constant, or they make
        no valid planar mesh.
    """
    data = read_mesh_file(path)
    try:
        return _planar(data, layer_sets)
    except InputError as error:
        raise InputError(f"mesh file {path}: {error}") from error


def _planar(data: "meshio.Mesh", layer_sets: Sequence[frozenset[str]]) -> PlanarMesh:
    triangles = data.get_cells_type("triangle")
    others = [block.type for block in data.cells if block.dim > 1 and block.type != "triangle"]
    if len(triangles) == 0 or others:
        found = f"{others[0]} cells" if others else "no triangles"
        raise InputError(f"holds {found}, expected a planar mesh of triangles of 3 nodes")
    region = next(
        (
            data.get_cell_data(name, "triangle")
            for name in ("region", "gmsh:physical")
            if name in data.cell_data
        ),
        np.full(len(triangles), len(layer_sets) - 1),
    )
    drawn = [block.data.ravel() for block in data.cells if block.dim < 2]
    construction = np.setdiff1d(np.concatenate([np.empty(0, dtype=np.int64), *drawn]), triangles)
    kept = np.setdiff1d(np.arange(len(data.points)), construction)
    points = data.points[kept]
    check_points(points)
    heights, extent = points[:, 2:], np.ptp(points[:, :2], axis=0).max()
    if np.ptp(heights, axis=0).max(initial=0.0) > PLANE_TOLERANCE * extent:
        raise InputError(
            f"its z goes from {heights.min():g} to {heights.max():g} m, expected a plane"
        )
    return PlanarMesh(points[:, :2], np.searchsorted(kept, triangles), region, tuple(layer_sets))
