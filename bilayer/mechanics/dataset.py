"""The fields of a result as variables with units, by name, layer and height.

On the faces, for each layer (dimension `sheet_layer`) and height in it (`level`): strain, stress,
pressure, volume ratio. On the faces for each layer: energy density, thickness, prestretch. On the
nodes of the reference surface: normal, curvatures, distances. Where a layer does not lie, and at
milestones that were not reached, they are not numbers.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.geometry.alignment import align
from bilayer.geometry.curvature import curvatures
from bilayer.geometry.surface import Surface
from bilayer.measures.sphere import fit_sphere
from bilayer.mechanics.layer_state import LEVELS, LayerState
from bilayer.mechanics.stress import cauchy_stress, green_strain
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.milestones import along_milestones
from bilayer.results.other_mesh import positions_on
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.specimen.layer import BondedLayer
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
"""Components of a symmetric tensor, in the order of VTK."""
_ROWS, _COLUMNS = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)
PRINCIPAL = ("first", "second", "third")
"""Principal values, the largest first."""
FLATTEST = 50.0
"""Best spheres larger than so many times the sheet are planes: there is no distance."""
TENSOR = ("sheet_layer", "level", "face", "component")
VALUES = ("sheet_layer", "level", "face", "principal")
AXES = ("sheet_layer", "level", "face", "principal", "xyz")
SCALAR = ("sheet_layer", "level", "face")
MEAN = ("sheet_layer", "face")
_AXES_TEXT = "along the axes of the flat sheet as they turn with the material"
LAYER_FIELDS: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "green_strain": (TENSOR, "1", "elastic Green strain from the layer's natural state"),
    "principal_strain": (VALUES, "1", "principal values of green_strain"),
    "principal_strain_direction": (AXES, "1", "their directions, in the axes of position"),
    "cauchy_stress": (TENSOR, "Pa", f"Cauchy stress, {_AXES_TEXT}"),
    "principal_stress": (VALUES, "Pa", "principal values of cauchy_stress"),
    "principal_stress_direction": (AXES, "1", "their directions, in the axes of position"),
    "pressure": (SCALAR, "Pa", "minus the mean of the principal stresses"),
    "volume_ratio": (SCALAR, "1", "present over natural volume, J"),
    "energy_density": (MEAN, "J m-3", "strain energy over natural volume, mean over the height"),
    "natural_volume": (MEAN, "m3", "natural volume of the layer on the face"),
    "layer_thickness": (MEAN, "m", "present thickness of the layer"),
}
"""Dimensions after `prestretch`, unit and meaning of the fields of the layers."""
SHAPE_FIELDS: Mapping[str, tuple[tuple[str, ...], str, str]] = {
    "normal": (("node", "xyz"), "1", "upward unit normal, in the axes of position"),
    "mean_curvature": (("node",), "m-1", "mean curvature, positive where the surface bulges up"),
    "gaussian_curvature": (("node",), "m-2", "Gaussian curvature"),
    "sphere_distance": (("node",), "m", "distance from the best sphere, outside positive"),
}
"""The same of the reference surface."""
PRESTRETCH_FIELD = "layer_prestretch"
DISTANCE_FIELD = "distance_to_other"
SCAN_FIELD = "distance_to_scan"
"""Made by `bilayer.scan.field.distance_to_scan`."""


def shape_fields(result: xr.Dataset, other: xr.Dataset | None = None) -> xr.Dataset:
    """Return the fields that follow from the shapes and the specimen alone, for any result.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    other : Dataset, optional
        Another result of the same flat sheet: the distance to it is a field, at the milestones that
        both have, each shape of it laid onto that of the first.

    Returns
    -------
    Dataset
        The fields of `SHAPE_FIELDS`, the prestretch of the layers, and `distance_to_other`.

    Raises
    ------
    InputError
        It is no result.
    """
    result = along_milestones(result)
    mesh, specimen = result_mesh(result), result_specimen(result)
    positions = result["position"].values
    rows = [_shape_row(mesh, position) for position in positions]
    variables = _variables(SHAPE_FIELDS, rows, "node")
    variables[PRESTRETCH_FIELD] = _prestretch_variable(specimen, result)
    if other is not None:
        variables[DISTANCE_FIELD] = _distance_variable(mesh, result, along_milestones(other))
    return _dataset(result, variables)


def layer_fields(result: xr.Dataset, states: Sequence[Sequence[LayerState] | None]) -> xr.Dataset:
    """Return the fields of the layers.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    states : sequence of sequences of LayerState or None
        For each milestone of the result, in its order; None: not known.
    """
    result = along_milestones(result)
    specimen, faces = result_specimen(result), result.sizes["face"]
    rows = [
        _layer_row(specimen, faces, pair, state)
        for pair, state in zip(_pairs(result), states, strict=True)
    ]
    return _dataset(result, _variables(LAYER_FIELDS, rows, "face"))


def _dataset(result: xr.Dataset, variables: dict[str, Any]) -> xr.Dataset:
    coordinates: dict[str, Any] = {
        "level": ("level", list(LEVELS), {"long_name": "height in the layer"}),
        "component": ("component", list(COMPONENTS)),
        "principal": ("principal", list(PRINCIPAL)),
    }
    names = np.array(result_specimen(result).layer_names, dtype=object)
    coordinates["sheet_layer"] = ("sheet_layer", names, {"long_name": "layers from the bottom up"})
    used = {dim for dims, *_ in variables.values() for dim in dims}
    found = xr.Dataset(variables, coords={k: v for k, v in coordinates.items() if k in used})
    kept = ["prestretch", "prestretch_x", "prestretch_y", "xyz"]
    return found.assign_coords({name: result[name] for name in kept if name in result.variables})


def _variables(
    known: Mapping[str, tuple[tuple[str, ...], str, str]],
    rows: Sequence[Mapping[str, Array]],
    location: str,
) -> dict[str, Any]:
    on = {"mesh": "midsurface", "location": location}
    return {
        name: (
            ("prestretch", *dims),
            np.array([row[name] for row in rows]),
            {"units": unit, "long_name": text, **on},
        )
        for name, (dims, unit, text) in known.items()
    }


def _shape_row(mesh: PlanarMesh, position: Array) -> dict[str, Array]:
    surface = Surface(position, mesh.triangles)
    if not np.isfinite(position).all():
        nothing = np.full(len(position), np.nan)
        return dict.fromkeys(SHAPE_FIELDS, nothing) | {"normal": np.full_like(position, np.nan)}
    found = curvatures(surface)
    sphere = fit_sphere(surface)
    flat = sphere.radius >= FLATTEST * np.ptp(position, axis=0).max()
    distance = np.full(len(position), np.nan) if flat else sphere.distances
    return {
        "normal": found.normal,
        "mean_curvature": found.mean,
        "gaussian_curvature": found.gaussian,
        "sphere_distance": distance,
    }


def _prestretch_variable(specimen: Specimen, result: xr.Dataset) -> Any:
    """Return the stretch of each layer when bonded, (prestretch, sheet_layer, component)."""
    tensors = [
        [isochoric(layer) for layer in specimen.bonded_layers(pair)] for pair in _pairs(result)
    ]
    text = "stretch of the layer from its natural state to the flat bonded one, the volume kept"
    dims = ("prestretch", "sheet_layer", "component")
    return dims, _components(np.array(tensors)), {"units": "1", "long_name": text}


def _distance_variable(mesh: PlanarMesh, result: xr.Dataset, other: xr.Dataset) -> Any:
    """Return the distance at the nodes from the same places of another result."""
    weights, found = flat_surface(mesh).node_areas, np.full(result["position"].shape[:2], np.nan)
    places = {pair: k for k, pair in enumerate(_pairs(other))}
    shapes = positions_on(mesh, result_mesh(other), other["position"].values)
    for row, pair in enumerate(_pairs(result)):
        place = places.get(pair)
        if place is None:
            continue
        own, its = result["position"].values[row], shapes[place]
        if np.isfinite(own).all() and np.isfinite(its).all():
            found[row] = np.linalg.norm(align(its, own, weights) - own, axis=1)
    on = {"mesh": "midsurface", "location": "node"}
    text = "distance from the same place of another result, laid onto this one"
    return ("prestretch", "node"), found, {"units": "m", "long_name": text, **on}


def _pairs(result: xr.Dataset) -> list[StretchPair]:
    both = zip(result["prestretch_x"].values, result["prestretch_y"].values, strict=True)
    return [(float(x), float(y)) for x, y in both]


def isochoric(layer: BondedLayer) -> Array:
    """Return the stretch of a layer when bonded, its volume kept, (3, 3)."""
    whole = np.zeros((3, 3))
    whole[:2, :2] = layer.stretch
    whole[2, 2] = 1 / np.linalg.det(whole[:2, :2])
    return whole


def _layer_row(
    specimen: Specimen, faces: int, stretch: StretchPair, states: Sequence[LayerState] | None
) -> dict[str, Array]:
    """Return the fields of all layers at a milestone, by name."""
    layers = specimen.bonded_layers(stretch)
    sizes = {"sheet_layer": len(layers), "level": len(LEVELS), "face": faces, "xyz": 3}
    sizes |= {"component": len(COMPONENTS), "principal": 3}
    row = {
        name: np.full([sizes[dim] for dim in dims], np.nan)
        for name, (dims, _, _) in LAYER_FIELDS.items()
    }
    numbers = {layer.name: number for number, layer in enumerate(layers)}
    for state in states or ():
        number = numbers[state.name]
        for name, values in _of_layer(layers[number], state).items():
            at = row[name][number]  # (level, face, ...) or (face,)
            if LAYER_FIELDS[name][0] == MEAN:
                at[state.faces] = values
            else:
                at[:, state.faces] = values
    return row


def _of_layer(layer: BondedLayer, state: LayerState) -> dict[str, Array]:
    """Return the fields of a layer on its own faces."""
    law, prestretch = layer.layer.material, isochoric(layer)
    strain = green_strain(law, state.stretch, prestretch)
    stress = cauchy_stress(law, state.stretch, prestretch, state.pressure, state.memory)
    strains, strain_axes = _principal(strain, state.rotation)
    stresses, stress_axes = _principal(stress, state.rotation)
    across = np.sqrt(np.linalg.inv(state.stretch)[..., 2, 2])
    natural = (layer.top - layer.bottom) / prestretch[2, 2]
    return {
        "green_strain": _components(strain),
        "principal_strain": strains,
        "principal_strain_direction": strain_axes,
        "cauchy_stress": _components(stress),
        "principal_stress": stresses,
        "principal_stress_direction": stress_axes,
        "pressure": -np.einsum("...ii", stress) / 3,
        "volume_ratio": np.sqrt(np.linalg.det(state.stretch)),
        "energy_density": state.energy / state.volume,
        "natural_volume": state.volume,
        "layer_thickness": natural * _over_height(1 / across),
    }


def _over_height(values: Array) -> Array:
    """Return the mean over the height of values at its two ends and its middle, by Simpson."""
    return np.asarray(values[0] + 4 * values[1] + values[2]) / 6


def _components(tensors: Array) -> Array:
    return np.asarray(tensors[..., _ROWS, _COLUMNS])


def _principal(tensors: Array, rotation: Array) -> tuple[Array, Array]:
    """Return principal values, the largest first, and the unit vectors along them in space."""
    values, axes = np.linalg.eigh(tensors)
    turned = np.swapaxes(rotation @ axes, -1, -2)
    return values[..., ::-1], turned[..., ::-1, :]
