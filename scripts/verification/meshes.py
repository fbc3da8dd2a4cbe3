"""Structured meshes of the cases: rectangles, hexagons, discs, slit rings."""

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer import PlanarMesh, Polygon

Array = NDArray[np.float64]


def rectangle(x: Array, y: Array, jitter: float = 0.0) -> PlanarMesh:
    """Right triangles on a grid, diagonals alternating; inner nodes moved by a share of a cell."""
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=2)
    rng = np.random.default_rng(3)
    cell = np.array([x[1] - x[0], y[1] - y[0]])
    grid[1:-1, 1:-1] += jitter * cell * rng.uniform(-1, 1, grid[1:-1, 1:-1].shape)
    number = np.arange(grid[..., 0].size).reshape(len(x), len(y))
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    even = (np.add.outer(np.arange(len(x) - 1), np.arange(len(y) - 1)) % 2 == 0).ravel()
    first = np.where(even[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even[:, None], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    triangles = np.concatenate([first, second])
    return PlanarMesh(grid.reshape(-1, 2), triangles, np.ones(len(triangles)))


def hexagon(rings: int, edge: float) -> PlanarMesh:
    """A hexagon of equilateral triangles around the origin."""
    span = np.arange(-rings, rings + 1)
    i, j = np.meshgrid(span, span, indexing="ij")
    inside = np.abs(i + j) <= rings
    number = np.full((len(span) + 1,) * 2, -1)  # one more row and column: beyond the last
    number[:-1, :-1][inside] = np.arange(inside.sum())
    here, right = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    above, across = number[:-1, 1:].ravel(), number[1:, 1:].ravel()
    triangles = np.concatenate(
        [np.column_stack([here, right, above]), np.column_stack([right, across, above])]
    )
    triangles = triangles[(triangles >= 0).all(axis=1)]
    points = edge * np.stack([i + j / 2, j * np.sqrt(3) / 2], axis=2)[inside]
    return PlanarMesh(points, triangles, np.ones(len(triangles)))


def disc(rings: int, ring_width: float) -> PlanarMesh:
    """Concentric rings of nodes, 6 k of them on the circle of radius k times the ring's width."""
    lattice = hexagon(rings, ring_width)
    x, y = lattice.points.T
    tilted = y / np.sqrt(3)
    # the hexagon that a node lies on, by its largest lattice coordinate
    ring = np.max(np.abs([x - tilted, 2 * tilted, x + tilted]), axis=0)
    radius = np.hypot(x, y)
    stretch = np.divide(ring, radius, out=np.zeros_like(ring), where=radius > 0)
    return PlanarMesh(stretch[:, None] * lattice.points, lattice.triangles, lattice.region)


def outline_of(mesh: PlanarMesh) -> Polygon:
    """The rim of a mesh without holes as the outline of a sheet."""
    rim = [shapely.LineString(ends) for ends in mesh.points[mesh.boundary_edges]]
    (polygon,) = shapely.polygonize(rim).geoms
    return Polygon(polygon.exterior.coords[:-1])


def slit_ring(inner: float, outer: float, radial: int, angles: Array) -> PlanarMesh:
    """A ring cut along a radius: angles first to last, the two lips with nodes of their own.

    Angles over more than a full turn overlap.
    """
    flat = rectangle(angles, np.linspace(inner, outer, radial + 1))
    angle, radius = flat.points.T
    # radius runs outward and the angle clockwise, so that triangles stay counterclockwise
    points = radius[:, None] * np.column_stack([np.cos(angle), -np.sin(angle)])
    return PlanarMesh(points, flat.triangles, flat.region)
