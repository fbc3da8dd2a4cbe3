"""The check that a dataset has the structure of a result, whoever wrote it.

Names, dimensions, types and values of the schema (`bilayer.results.schema`) are checked here once.
Every reader of a result may therefore rely on them.
"""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.load_variables import LOAD, REACHED, RESPONSE
from bilayer.results.milestones import along_milestones
from bilayer.results.netcdf import StoredGroup
from bilayer.results.schema import (
    CONTACT_CROSSES,
    FORMAT,
    LOWER_STATE,
    NOT_MEASURED,
    REQUIRED,
    SAME_STRETCH,
    SCHEMA_VERSION,
    TIMES_FOUND,
    result_mesh,
)
from bilayer.runtime.input_file import LARGEST_TEXT

NUMBER, WHOLE, TEXT = "floating-point numbers", "whole numbers", "texts"
SIZES = {"xyz": 3, "corner": 3, "vertex": 4}
"""Lengths of the dimensions that have always the same one."""

Array = NDArray[Any]


@dataclass(frozen=True)
class Layout:
    """The place and kind of a variable's values.

    Parameters
    ----------
    kind : {"floating-point numbers", "whole numbers", "texts"}
        Of each value.
    dims : tuple of str
        Dimensions, in this order.
    """

    kind: str
    dims: tuple[str, ...]


def _layouts() -> dict[str, Layout]:
    by_milestone = ("prestretch",)
    places = {
        Layout(NUMBER, by_milestone): (
            "prestretch", "prestretch_x", "prestretch_y", "quality", "sphere_radius",
            "sphere_rmse", "hemisphere_distance", "height", "residual", "wall_time",
            "self_contact_gap", "last_prestretch", "assembly_time", "factorisation_time",
            "cpu_time", "dissipated_energy", "contact_gap", "contact_force", "contact_pairs",
            CONTACT_CROSSES, "least_stiffness", "next_stiffness", "way_length", LOWER_STATE,
        ),
        Layout(WHOLE, by_milestone): (
            "iterations", "load_steps", "unstable_modes", "converged", "factorisations",
            "stabilised_steps", "escapes", "guided_steps", "branch_taken", TIMES_FOUND,
            "found_as", "symmetry_turns", "symmetry_mirrored", "turned_over",
        ),
        Layout(TEXT, ("start",)): ("start_name",),
        Layout(WHOLE, ("start",)): ("start_state",),
        Layout(NUMBER, ("prestretch", "xyz")): ("span",),
        Layout(NUMBER, ("prestretch", "node", "xyz")): ("position", "last_position"),
        Layout(NUMBER, ("prestretch", "volume_node", "xyz")): ("volume_position",),
        Layout(NUMBER, ("prestretch", "face")): ("contact_pressure",),
        Layout(NUMBER, ("prestretch", "term")): ("energy",),
        Layout(TEXT, ("term",)): ("term",),
        Layout(TEXT, ("xyz",)): ("xyz",),
        Layout(TEXT, ("sheet_layer",)): ("sheet_layer",),
        Layout(NUMBER, ("node", "xyz")): ("reference_position",),
        Layout(NUMBER, ("node",)): ("reference_x", "reference_y"),
        Layout(WHOLE, ("face", "corner")): ("face_nodes",),
        Layout(WHOLE, ("face",)): ("region",),
        Layout(WHOLE, ("face", "sheet_layer")): ("layers_present",),
        Layout(NUMBER, ("volume_node", "xyz")): ("volume_reference_position",),
        Layout(WHOLE, ("volume_cell", "vertex")): ("volume_cells",),
        Layout(WHOLE, ("volume_cell",)): ("layer",),
    }  # fmt: skip
    return {name: layout for layout, names in places.items() for name in names}


LAYOUTS = _layouts()
"""The layout of every variable that the project reads; a file may hold others."""
TEXTS = (*REQUIRED["attribute"], "start", NOT_MEASURED, "reference_surface", "history", "title")
"""The attributes that are texts."""
SMALLEST = {"iterations": 0, "load_steps": 0, "unstable_modes": -1, "converged": 0, "region": 0}
LARGEST = {"converged": 1}
PLACES = (
    "reference_position", "position", "last_position", "volume_position",
    "volume_reference_position",
)  # fmt: skip
FARTHEST = 1e6
"""Of a node from the origin, m."""
SCALAR_DIMS = (("prestretch",), ("prestretch", "xyz"))
"""Dimensions of the variables that hold a number, or three, for each milestone."""
POSITIVE = ("prestretch", "prestretch_x", "prestretch_y")
VOLUME = ("volume_position", "volume_reference_position", "volume_cells", "layer")
"""Variables of which a result has all or none."""


def layout_of(name: str) -> Layout | None:
    """Return the layout of a variable by its name; None of one that the project does not read."""
    of_load = name.startswith((LOAD, RESPONSE, REACHED))
    return LAYOUTS.get(name, Layout(NUMBER, ("prestretch",)) if of_load else None)


def check_result(result: xr.Dataset) -> None:
    """Raise InputError unless a dataset, whole or a single milestone of one, is a result.

    The text names the attribute or variable, its value and what was expected.
    """
    check_attributes(result.attrs)
    _check_there(result.variables, REQUIRED["variable"], "variable")
    whole = along_milestones(result)
    check_variables({str(name): (v.dims, v.values) for name, v in whole.variables.items()})
    _check_shapes(whole)
    for name, variable in whole.variables.items():
        _check_texts(variable.attrs, ("units", "long_name"), f"{name}: ")
    _check_told_twice(whole, result_mesh(result))  # which refuses a bad specimen or mesh


def check_scalars(stored: StoredGroup) -> None:
    """Raise InputError unless a file of which only the scalars were read is a result's.

    Of the other variables it checks all but the values.
    """
    check_attributes(stored.attributes)
    _check_there(stored.headers, REQUIRED["variable"], "variable")
    for name, (dims, shape, kind) in stored.headers.items():
        layout = layout_of(name)
        if layout is not None:
            _check_dims(name, dims, shape, layout)
            if layout.kind != TEXT and 0 not in shape:
                _check_type(name, kind, layout.kind)
    check_variables({name: entry[:2] for name, entry in stored.variables.items()})
    for name, (_, _, attributes) in stored.variables.items():
        _check_texts(attributes, ("units", "long_name"), f"{name}: ")


def check_attributes(attributes: Mapping[str, Any]) -> None:
    """Raise InputError unless the attributes are those of a result that this version reads."""
    found = attributes.get("format")
    if not isinstance(found, str) or found != FORMAT:
        raise InputError(f"format = {found}, expected {FORMAT!r}")
    _check_version(attributes.get("schema_version"))
    _check_there(attributes, REQUIRED["attribute"], "attribute")
    _check_texts(attributes, TEXTS)
    try:
        settings = tomllib.loads(attributes["settings"])
    except (ValueError, RecursionError) as error:
        raise InputError(f"settings: not valid TOML ({error})") from error
    for name, value in settings.items():
        if not isinstance(value, (str, int, float, list)):
            raise InputError(f"settings: {name} = {value}, expected a number, a text or a list")


def check_variables(variables: Mapping[str, tuple[Iterable[Any], Array]]) -> None:
    """Raise InputError unless the variables that the schema knows are laid out as it says.

    Parameters
    ----------
    variables : mapping of str to (dims, array)
        Some or all of a result's, with the dimension `prestretch`.
    """
    for name, (dims, values) in variables.items():
        layout = layout_of(name)
        if layout is not None:
            _check_dims(name, tuple(map(str, dims)), values.shape, layout)
            _check_kind(name, values, layout.kind)
            _check_range(name, values)


def _check_texts(attributes: Mapping[str, Any], names: Iterable[str], of: str = "") -> None:
    for name in names:
        value = attributes.get(name, "")
        if not isinstance(value, str):
            raise InputError(f"{of}{name} = {value}: expected a text")
        if len(value) > LARGEST_TEXT:
            found = f"has {len(value)} letters"
            raise InputError(f"{of}{name}: {found}, expected at most {LARGEST_TEXT}")


def _check_version(found: Any) -> None:
    if not isinstance(found, (int, np.integer)):
        raise InputError(
            f"schema_version = {found}, expected a whole number up to {SCHEMA_VERSION}"
        )
    if found > SCHEMA_VERSION:
        raise InputError(
            f"schema_version = {found}, expected at most {SCHEMA_VERSION}: made by a newer "
            "version of this package"
        )


def _check_there(held: Iterable[Any], names: Iterable[str], part: str) -> None:
    missing = [name for name in names if name not in held]
    if missing:
        raise InputError(f"the {part} {missing[0]!r} is missing")


def _check_dims(name: str, dims: tuple[str, ...], shape: tuple[int, ...], layout: Layout) -> None:
    expected = [SIZES.get(dim, size) for dim, size in zip(dims, shape, strict=True)]
    if dims != layout.dims or list(shape) != expected:
        found = ", ".join(f"{dim}: {size}" for dim, size in zip(dims, shape, strict=True))
        wanted = ", ".join(f"{dim}: {SIZES[dim]}" if dim in SIZES else dim for dim in layout.dims)
        raise InputError(f"{name}: has the dimensions ({found}), expected ({wanted})")


def _check_kind(name: str, values: Array, kind: str) -> None:
    if values.size == 0:
        return  # an empty list of texts comes back as numbers
    if kind != TEXT:
        _check_type(name, values.dtype, kind)
    elif values.dtype.kind not in "US" and not all(isinstance(v, str) for v in values.flat):
        raise _wrong_type(name, values.dtype, kind)
    if kind == WHOLE and values.dtype.kind == "f":
        _refuse(name, values, ~(np.isfinite(values) & (values == np.round(values))), kind)


def _check_type(name: str, found: Any, kind: str) -> None:
    """Raise InputError unless numpy's type is of a kind of numbers."""
    if not isinstance(found, np.dtype) or found.kind not in ("f" if kind == NUMBER else "fiu"):
        raise _wrong_type(name, found, kind)


def _wrong_type(name: str, found: Any, kind: str) -> InputError:
    return InputError(f"{name}: holds values of the type {found}, expected {kind}")


def _check_range(name: str, values: Array) -> None:
    if name in POSITIVE:
        _refuse(name, values, ~(np.isfinite(values) & (values > 0)), "numbers greater than 0")
    if name in SMALLEST:
        low = SMALLEST[name]
        _refuse(name, values, values < low, f"whole numbers of at least {low}")
    if name in PLACES:
        far = np.isfinite(values) & (np.abs(values) > FARTHEST)
        _refuse(name, values, far, f"at most {FARTHEST:g} m")
    if name in LARGEST:
        _refuse(name, values, values > LARGEST[name], f"0 or {LARGEST[name]}")


def _refuse(name: str, values: Array, bad: NDArray[np.bool_], expected: str) -> None:
    """Raise InputError with the first bad value, if there is one."""
    places = np.argwhere(bad)
    if len(places):
        at = tuple(int(k) for k in places[0])
        where = f"[{', '.join(map(str, at))}]" if at else ""
        raise InputError(f"{name}{where} = {values[at]}: expected {expected}")


def _check_shapes(result: xr.Dataset) -> None:
    """Check the positions of the milestones that were reached, and the mesh of a volume."""
    if result.sizes["prestretch"] == 0:
        raise InputError("prestretch: has no milestone, expected at least one")
    reached = result["converged"].values == 1
    missed = not reached.all()
    if missed and "last_position" in result and "last_prestretch" not in result:
        raise InputError("the variable 'last_prestretch' is missing")
    for name in ("reference_position", "position", *VOLUME[:2]):
        if name in result:
            values = result[name].values
            bad = ~np.isfinite(values)
            if "prestretch" in result[name].dims:
                bad &= reached[:, None, None]
            _refuse(name, values, bad, "finite numbers, m")
    if any(name in result for name in VOLUME):
        _check_there(result.variables, VOLUME, "variable")
        cells, count = result["volume_cells"].values, result.sizes["volume_node"]
        _refuse("volume_cells", cells, (cells < 0) | (cells >= count), f"nodes below {count}")


def _check_told_twice(result: xr.Dataset, mesh: PlanarMesh) -> None:
    """Check that what a result says in two places is the same."""
    larger = np.maximum(result["prestretch_x"].values, result["prestretch_y"].values)
    stretch = result["prestretch"].values
    expected = "the larger of prestretch_x and prestretch_y"
    _refuse("prestretch", stretch, np.abs(stretch - larger) > SAME_STRETCH, expected)
    for axis, name in enumerate(("reference_x", "reference_y")):
        if name in result:
            values = result[name].values
            _refuse(name, values, values != mesh.points[:, axis], "that of reference_position")
    if "layers_present" in result and "sheet_layer" in result:
        present, names = result["layers_present"].values, result["sheet_layer"].values
        there = np.zeros(present.shape, dtype=present.dtype)
        for column, name in enumerate(names):
            there[mesh.faces_of(str(name)), column] = 1
        _refuse("layers_present", present, present != there, "1 where the region has the layer")
