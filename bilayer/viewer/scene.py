"""What a page shows: the shapes of one or two results, as small numbers."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.figures.regions import region_colours, region_name, regions_of
from bilayer.figures.result_looks import plain_name
from bilayer.geometry.alignment import align
from bilayer.geometry.surface import Surface
from bilayer.measures.sphere import fit_sphere
from bilayer.mechanics.selection import ScalarField
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.comparison import result_label
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import MM_PER_M, Shape, released_shapes
from bilayer.results.schema import result_mesh

STEPS = 32767
"""Positions are whole numbers up to this, of the largest: 1.2 um for a sheet of 80 mm."""
FLATTEST = 50.0
"""Spheres larger than so many times the sheet show no distance."""


@dataclass(frozen=True)
class Field:
    """Numbers at the nodes of all shapes.

    Parameters
    ----------
    name, unit : str
        For the legend.
    values : ndarray, shape (shapes, nodes)
        Not a number where there is none.
    """

    name: str
    unit: str
    values: NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """A result as it is shown.

    Parameters
    ----------
    name : str
        Its solver and model.
    mesh : PlanarMesh
        Its mesh.
    shapes : list of Shape
        One for each milestone.
    """

    name: str
    mesh: PlanarMesh
    shapes: list[Shape]

    @classmethod
    def of(cls, whole: xr.Dataset) -> "Model":
        """Return the model of a result; raise InputError if it holds no shape."""
        result = along_milestones(whole)
        mesh = result_mesh(result)
        return cls(plain_name(result_label(result)), mesh, released_shapes(result, mesh))

    @cached_property
    def positions(self) -> NDArray[np.float64]:
        """Of the nodes of all shapes, mm, shape (shapes, nodes, 3)."""
        return np.array([shape.surface.points for shape in self.shapes])


def scene_of(results: list[xr.Dataset], coloured_by: Sequence[ScalarField] = ()) -> dict[str, Any]:
    """Return the scene of some results, ready to be written as JSON.

    Parameters
    ----------
    results : list of Dataset
        One or two; see `bilayer.results.schema`. The second is shown where it has the prestretch
        of the first; on the same mesh it is laid over it as near as a rigid motion brings it, and
        the first can be coloured by the distance.
    coloured_by : sequence of ScalarField
        Further fields of the first; those of the faces are shown by their means at the nodes.

    Raises
    ------
    InputError
        A result holds no shape.
    """
    first, *others = [Model.of(result) for result in results]
    fields, models = node_fields(first), []
    fields += [_at_nodes(field, first) for field in coloured_by]
    for other in others:
        places = _places(first, other)
        if other.mesh.same_as(first.mesh):
            other, distance = _laid_over(first, other, places)
            fields += [Field(f"distance from {other.name}", "mm", distance)]
        models.append(_packed(other, []) | {"places": places})
    return {"models": [_packed(first, fields), *models]}


def _at_nodes(field: ScalarField, model: Model) -> Field:
    """Return a field of the faces or nodes as one of the nodes of a model's shapes."""
    values = field.on_nodes(model.mesh)[[shape.milestone for shape in model.shapes]]
    return Field(field.words, field.unit, values)


def _places(first: Model, other: Model) -> list[int]:
    """Return the place in another result of each shape with the same prestretch, -1 for none."""
    titles = [shape.title for shape in other.shapes]
    return [titles.index(s.title) if s.title in titles else -1 for s in first.shapes]


def _laid_over(first: Model, other: Model, places: list[int]) -> tuple[Model, NDArray[np.float64]]:
    """Return another result moved onto the first, and the distance of the nodes, mm."""
    weights = flat_surface(first.mesh).node_areas
    distance = np.full(first.positions.shape[:2], np.nan)
    shapes = list(other.shapes)
    for number, place in enumerate(places):
        if place < 0:
            continue
        fixed = first.shapes[number].surface.points
        moved = align(shapes[place].surface.points, fixed, weights)
        distance[number] = np.linalg.norm(moved - fixed, axis=1)
        surface = Surface(moved, other.mesh.triangles)
        shapes[place] = replace(shapes[place], surface=surface)
    return replace(other, shapes=shapes), distance


def _packed(model: Model, fields: list[Field]) -> dict[str, Any]:
    """Return a result: faces by region, shapes and fields."""
    mesh, positions = model.mesh, model.positions
    size = float(np.abs(positions).max())
    regions = regions_of(mesh)
    faces = [mesh.triangles[mesh.region == region] for region in regions]
    colours = region_colours(mesh)
    known = [field for field in fields if np.isfinite(field.values).any()]
    return {
        "name": model.name,
        "nodes": len(mesh.points),
        "titles": [shape.title for shape in model.shapes],
        "notes": [shape.note for shape in model.shapes],
        "scale": size / STEPS,
        "positions": packed(np.rint(positions / size * STEPS), "<i2"),
        "flat": packed(MM_PER_M * (mesh.points - mesh.points.mean(axis=0)), "<f4"),
        "faces": packed(np.concatenate(faces), "<u4"),
        "regions": [
            {"name": region_name(mesh, region), "colour": colours[region], "count": len(own)}
            for region, own in zip(regions, faces, strict=True)
        ],
        "fields": [_packed_field(field) for field in known],
    }


def node_fields(model: Model) -> list[Field]:
    """Return what the shapes can be coloured by: height, distance from the best sphere."""
    z = model.positions[:, :, 2]
    height = z - z.min(axis=1, keepdims=True)
    distances = np.array([_from_sphere(shape) for shape in model.shapes])
    return [
        Field("height", "mm", height),
        Field("distance from the best sphere", "mm", distances),
    ]


def _from_sphere(shape: Shape) -> NDArray[np.float64]:
    """Return the distance of each node from the sphere that fits best, outside positive, mm."""
    sphere = fit_sphere(shape.surface)
    size = np.ptp(shape.surface.points, axis=0).max()
    if sphere.radius < FLATTEST * size:
        return sphere.distances
    return np.full(len(sphere.distances), np.nan)


def _packed_field(field: Field) -> dict[str, Any]:
    """Return a field as 16-bit numbers between its bounds, one scale for all shapes."""
    known = field.values[np.isfinite(field.values)]
    low, high = float(known.min()), float(known.max())
    span = high - low or 1.0
    steps = np.nan_to_num(np.rint((field.values - low) / span * STEPS), nan=-1)
    return {
        "name": field.name, "unit": field.unit, "low": low, "high": high,
        "values": packed(steps, "<i2"),
    }  # fmt: skip


def packed(values: Any, kind: str) -> str:
    """Return numbers of a NumPy type as base64 text."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")
