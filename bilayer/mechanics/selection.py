"""One number per face or node, chosen from the fields by a name such as cauchy_stress.film.top.xx.

The name of a variable is followed by a value for each of its dimensions but the milestones and the
places: the layer, the height in it (bottom, middle, top), the component (xx ... xy, or x, y, z) or
the principal value (first, second, third), in any order. A dimension of length one may be left out.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.dataset import (
    COMPONENTS,
    DISTANCE_FIELD,
    LAYER_FIELDS,
    PRESTRETCH_FIELD,
    PRINCIPAL,
    SCAN_FIELD,
    SHAPE_FIELDS,
)
from bilayer.mesh.planar import PlanarMesh
from bilayer.validation import nearest

PLACES = ("node", "face")
FIELD_NAMES = (*LAYER_FIELDS, *SHAPE_FIELDS, PRESTRETCH_FIELD, DISTANCE_FIELD, SCAN_FIELD)
"""All variables of the fields that have a value at places, and the layers' prestretch."""
SHOWN_UNITS = {
    "1": (1.0, ""),
    "m": (1e3, "mm"),
    "m-1": (1e-3, "1/mm"),
    "m-2": (1e-6, "1/mm2"),
    "m3": (1e9, "mm3"),
    "Pa": (1e-3, "kPa"),
    "J m-3": (1e-3, "mJ/cm3"),
}
"""Factor and name of the unit in which people are shown a unit of the fields."""

PROPER_NAMES = {"cauchy": "Cauchy", "gaussian": "Gaussian", "green": "Green"}


@dataclass(frozen=True, eq=False)
class ScalarField:
    """A number at each face or node.

    Parameters
    ----------
    name : str
        As it was asked for.
    unit : str
        In which people are shown it.
    location : {"node", "face"}
        Where its values are.
    values : (milestones, k) array of float
        In that unit; not a number where there is none.
    """

    name: str
    unit: str
    location: str
    values: NDArray[np.float64]

    @property
    def label(self) -> str:
        """The name in words and the unit."""
        return f"{self.words} ({self.unit})" if self.unit else self.words

    @property
    def words(self) -> str:
        """The name in words, such as "first principal stress, kirigami, top"."""
        variable, *choices = self.name.split(".")
        words = [PROPER_NAMES.get(word, word) for word in variable.split("_")]
        order = [choice for choice in choices if choice in PRINCIPAL]
        component = [choice for choice in choices if choice in COMPONENTS]
        where = [choice for choice in choices if choice not in (*order, *component)]
        return ", ".join([" ".join([*order, *words, *component]), *where])

    def on_faces(self, mesh: PlanarMesh) -> NDArray[np.float64]:
        """Return the values on the faces, those of the nodes as means, (milestones, m)."""
        if self.location == "face":
            return self.values
        return np.asarray(self.values[:, mesh.triangles].mean(axis=2))

    def on_nodes(self, mesh: PlanarMesh) -> NDArray[np.float64]:
        """Return the values at the nodes, those of the faces as means by area, (milestones, n)."""
        if self.location == "node":
            return self.values
        corners, count = mesh.triangles.ravel(), len(mesh.points)
        found = np.full((len(self.values), count), np.nan)
        for row, values in zip(found, self.values, strict=True):
            weights = np.where(np.isfinite(values), mesh.areas, 0.0)
            total = np.bincount(corners, np.repeat(weights * np.nan_to_num(values), 3), count)
            whole = np.bincount(corners, np.repeat(weights, 3), count)
            np.divide(total, whole, out=row, where=whole > 0)
        return found


def needs_layers(name: str) -> bool:
    """Whether a field, by its name with the choice, needs the solver; InputError if unknown."""
    variable = name.split(".")[0]
    if variable not in FIELD_NAMES:
        known = f"expected one of {', '.join(FIELD_NAMES)}{nearest(variable, FIELD_NAMES)}"
        raise InputError(f"field = {name!r}: {known}")
    return variable in LAYER_FIELDS


def scalar_field(fields: xr.Dataset, name: str) -> ScalarField:
    """Return one number per place from the fields.

    Parameters
    ----------
    fields : Dataset
        From `bilayer.fields`.
    name : str
        Such as "cauchy_stress.substrate.top.xx", "energy_density.kirigami" or "mean_curvature".

    Raises
    ------
    InputError
        There is no such field, or the name does not choose one number; the text says what is left.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> field = bilayer.scalar_field(bilayer.fields(result), "mean_curvature")
    >>> figure = bilayer.draw_shapes(result, field=field)
    >>> field.unit
    '1/mm'
    """
    variable, *choices = name.split(".")
    needs_layers(name)
    if variable not in fields:
        raise InputError(
            f"field = {name!r}: this result has none; it has {', '.join(map(str, fields))}"
        )
    values = fields[variable]
    for choice in choices:
        values = _chosen(values, name, choice)
    for dim in _open_dims(values):
        if values.sizes[dim] > 1:
            left = ", ".join(str(v) for v in values[dim].values)
            raise InputError(f"field = {name!r}: expected .{dim} after it, one of {left}")
        values = values.isel({dim: 0})
    location = [dim for dim in PLACES if dim in values.dims]
    if not location:
        raise InputError(f"field = {name!r}: is one number for a whole layer, expected a field")
    factor, unit = SHOWN_UNITS[str(values.attrs["units"])]
    return ScalarField(name, unit, location[0], factor * values.values)


def unit_text(values: xr.DataArray) -> str:
    """Return the unit of a field as a file's names have it: " [Pa]", or "" for numbers."""
    unit = str(values.attrs.get("units", "1"))
    return "" if unit == "1" else f" [{unit}]"


def every_scalar(fields: xr.Dataset) -> Iterable[tuple[str, xr.DataArray]]:
    """Yield each number, vector and tensor per place with its name, layers and heights apart.

    Components of a tensor and of a vector stay together in the last dimension.
    """
    for variable in fields.data_vars:
        values = fields[variable]
        if not any(dim in values.dims for dim in PLACES):
            continue
        apart = ("sheet_layer", "level", *(["principal"] if "xyz" in values.dims else []))
        split = [dim for dim in apart if dim in values.dims]
        if not split:
            yield str(variable), values
            continue
        for choice in np.ndindex(*(values.sizes[dim] for dim in split)):
            part = values.isel(dict(zip(split, choice, strict=True)))
            words = [str(part[dim].values) for dim in split]
            yield ".".join([str(variable), *words]), part


def _open_dims(values: xr.DataArray) -> list[str]:
    return [str(dim) for dim in values.dims if dim not in ("prestretch", *PLACES)]


def _chosen(values: xr.DataArray, name: str, choice: str) -> xr.DataArray:
    """Return the part of a field that a word chooses."""
    known = {dim: [str(v) for v in values[dim].values] for dim in _open_dims(values)}
    for dim, words in known.items():
        if choice in words:
            return values.isel({dim: words.index(choice)})
    words = [word for own in known.values() for word in own]
    expected = f"expected one of {', '.join(words)}" if words else "expected no more"
    raise InputError(f"field = {name!r}: has {choice!r}, {expected}")
