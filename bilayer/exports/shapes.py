"""One shape of a result as a mesh with data: the reference surface, or the layers as a volume.

The volume is that of the finite-element model if the result has it. Else it is made of the layers
on both sides of the reference surface, as prisms that keep their volume (`bilayer.contact.skin`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.contact.skin import BondedBody, side_points, sides_of
from bilayer.exports.frame import Axes, Placing
from bilayer.geometry.surface import Surface
from bilayer.mechanics.selection import every_scalar, unit_text
from bilayer.mesh.planar import flat_surface
from bilayer.results.schema import result_mesh, result_specimen

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Data = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class MeshData:
    """A mesh with data on its points and cells.

    Parameters
    ----------
    points : (n, 3) array of float
        In the unit of the file.
    kind : {"triangle", "tetra", "wedge"}
        Of all cells, as meshio calls it.
    cells : (c, k) array of int
        Their points.
    point_data, cell_data : dict of str to array
        By name.
    """

    points: Array
    kind: str
    cells: Indices
    point_data: Data = field(default_factory=dict)
    cell_data: Data = field(default_factory=dict)


def midsurface(shape: xr.Dataset, axes: Axes, fields: xr.Dataset | None = None) -> MeshData:
    """Return the reference surface of one milestone.

    Parameters
    ----------
    shape : Dataset
        One milestone of a result.
    axes : Axes
        Of the points.
    fields : Dataset, optional
        The same milestone of `bilayer.fields`: all of them become data.
    """
    placing = axes.of(shape)
    reference = shape["reference_position"].values
    points = placing.points(shape["position"].values)
    on_points = _moved(placing, reference, points)
    on_cells: Data = {"region": shape["region"].values.astype(np.int32)}
    if fields is not None:
        for name, values in every_scalar(fields):
            data = on_points if "node" in values.dims else on_cells
            data[f"{name}{unit_text(values)}"] = _values(values, placing)
    return MeshData(points, "triangle", shape["face_nodes"].values, on_points, on_cells)


def volume(shape: xr.Dataset, axes: Axes, fields: xr.Dataset | None = None) -> MeshData:
    """Return the layers of one milestone as cells; see `midsurface` for the parameters.

    The fields of the layers become data of the cells, each that of its own layer: strain and
    stress in the middle of the layer.
    """
    made = _tetrahedra(shape) if "volume_position" in shape else _prisms(shape)
    placing = axes.of(shape)
    points = placing.points(made.points)
    on_cells: Data = {"layer": made.layer.astype(np.int32)}
    if fields is not None:
        on_cells |= _layer_data(fields, made, placing)
    on_points = _moved(placing, made.reference, points)
    return MeshData(points, made.kind, made.cells, on_points, on_cells)


PARTS: Mapping[str, Callable[..., MeshData]] = {"midsurface": midsurface, "volume": volume}
"""What can be written of a shape."""


@dataclass(frozen=True, eq=False)
class _Body:
    """The layers as cells: their places and flat places, m, each cell's layer and face."""

    kind: str
    points: Array
    reference: Array
    cells: Indices
    layer: Indices  # as the result numbers it
    sheet_layer: Indices  # from the bottom up
    face: Indices


def _tetrahedra(shape: xr.Dataset) -> _Body:
    """Return the volume that the finite-element model has written."""
    names = shape["layer"].attrs.get("flag_meanings", "").split()
    known = result_specimen(shape).layer_names
    number = np.array([known.index(n) if n in known else 0 for n in names] or [0])
    layer, cells = shape["layer"].values, shape["volume_cells"].values
    reference = shape["volume_reference_position"].values
    return _Body(
        "tetra",
        shape["volume_position"].values,
        reference,
        cells,
        layer,
        number[np.minimum(layer, len(number) - 1)],
        _faces_below(shape, reference, cells),
    )


def _faces_below(shape: xr.Dataset, reference: Array, cells: Indices) -> Indices:
    """Return the planar triangle under each tetrahedron."""
    from scipy.spatial import cKDTree  # slow to load

    mesh = result_mesh(shape)
    node = cKDTree(mesh.points).query(reference[:, :2])[1][cells]
    corners = np.sort(node, axis=1)
    repeated = np.concatenate([np.zeros((len(corners), 1), bool), np.diff(corners) == 0], axis=1)
    three = corners[~repeated].reshape(len(cells), 3)
    size = len(mesh.points)
    order = np.argsort(keys := _keys(np.sort(mesh.triangles, axis=1), size))
    return np.asarray(order[np.searchsorted(keys[order], _keys(three, size))])


def _keys(triangles: Indices, size: int) -> Indices:
    a, b, c = triangles.T.astype(np.int64)
    return np.asarray((a * size + b) * size + c)


def _prisms(shape: xr.Dataset) -> _Body:
    """Return the layers as prisms on the triangles of the planar mesh."""
    mesh, specimen = result_mesh(shape), result_specimen(shape)
    stretch = float(shape["prestretch_x"]), float(shape["prestretch_y"])
    body = BondedBody.of(specimen, mesh, stretch)
    sides, ends = sides_of(body)
    points = np.concatenate(side_points(body, Surface(shape["position"].values, mesh.triangles)))
    flat = flat_surface(mesh).points
    heights = [0.0, *(side.height for side in sides)]
    reference = np.concatenate([flat + np.array([0.0, 0.0, height]) for height in heights])
    n = len(mesh.points)
    corners = [mesh.triangles[sheet.faces] for sheet in body.sheets]
    cells = [
        np.hstack([triangles + n * lower, triangles + n * upper])
        for triangles, (lower, upper) in zip(corners, ends, strict=True)
    ]
    layer = np.repeat(np.arange(len(cells)), [len(part) for part in cells])
    face = np.concatenate([sheet.faces for sheet in body.sheets])
    used, numbered = np.unique(np.concatenate(cells), return_inverse=True)
    kept = numbered.reshape(-1, 6)
    return _Body("wedge", points[used], reference[used], kept, layer, layer, face)


def _layer_data(fields: xr.Dataset, made: _Body, placing: Placing) -> Data:
    """Return the fields of the layers on the cells, each that of its own layer and face."""
    found: Data = {}
    own = fields.isel(level=[1]) if "level" in fields.dims else fields
    for name in own.data_vars:
        values = own[name]
        if "sheet_layer" not in values.dims:
            continue
        places = {"sheet_layer": xr.DataArray(made.sheet_layer, dims="face")}
        if "face" in values.dims:
            places["face"] = xr.DataArray(made.face, dims="face")
        for part_name, part in every_scalar(xr.Dataset({name: values.isel(places)})):
            words = [word for word in part_name.split(".") if word != "middle"]
            found[".".join(words) + unit_text(part)] = _values(part, placing)
    return found


def _values(values: xr.DataArray, placing: Placing) -> NDArray[Any]:
    place = next(dim for dim in ("node", "face") if dim in values.dims)
    array = values.transpose(place, ...).values
    return placing.directions(array) if "xyz" in values.dims else array


def _moved(placing: Placing, reference: Array, points: Array) -> Data:
    flat = placing.per_metre * reference
    return {"reference_position": flat, "displacement": points - flat}
