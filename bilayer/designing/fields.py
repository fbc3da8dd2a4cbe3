"""Fields of density in a design: sharper from stage to stage, and cut out at the end."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bilayer.designing.variables import value_of, with_values
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.density_field import DensityField
from bilayer.specimen.specimen import Specimen

GREY_WEIGHT, FULL_SHARPNESS = 5e-4, 20.0
"""A sheet that is half kirigami everywhere is as bad as 2.2 % of the diagonal; less if less sharp.

Else a search finds that a share between none and all does what neither can."""
SMALL_CHANGE = 1e-5
"""Of a share, for the slope of what is between."""
LEAST_PART = 5e-4
"""Area of the parts and holes that are cut out, over that of the sheet; smaller ones are not."""


def has_fields(specimen: Specimen) -> bool:
    """Whether a layer has a field of density."""
    return any(_fields(specimen))


def field_layers(specimen: Specimen) -> list[str]:
    """Return the names of the layers that have a field of density."""
    return [name for name, _ in _fields(specimen)]


def with_sharpness(specimen: Specimen, sharpness: float) -> Specimen:
    """Return a specimen whose fields of density are so sharp."""
    for name, field in _fields(specimen):
        specimen = specimen.with_layer(name, pattern=replace(field, sharpness=sharpness))
    return specimen


def greyness(specimen: Specimen, mesh: PlanarMesh) -> float:
    """Return the mean over the sheet of 4 share (1 - share), of all fields, by their sharpness."""
    centres = mesh.points[mesh.triangles].mean(axis=1)
    total = 0.0
    for _, field in _fields(specimen):
        share = field.share_at(centres)
        between = float(mesh.areas @ (4 * share * (1 - share)) / mesh.areas.sum())
        total += min(field.sharpness / FULL_SHARPNESS, 1.0) * between
    return total


def grey_penalty(
    specimen: Specimen, mesh: PlanarMesh, names: Sequence[str]
) -> tuple[float, NDArray[np.float64]]:
    """Return a penalty on shares between none and all, and its slopes by numbers of the design.

    Parameters
    ----------
    specimen : Specimen
        The design.
    mesh : PlanarMesh
        Its planar mesh.
    names : sequence of str
        Numbers of the design; only shares change it.
    """
    slopes = np.zeros(len(names))
    if not has_fields(specimen):
        return 0.0, slopes
    for place, name in enumerate(names):
        if ".share." in name:
            value = value_of(specimen, name)
            ahead, behind = (
                greyness(with_values(specimen, {name: value + sign * SMALL_CHANGE}), mesh)
                for sign in (1.0, -1.0)
            )
            slopes[place] = (ahead - behind) / (2 * SMALL_CHANGE)
    return GREY_WEIGHT * greyness(specimen, mesh), GREY_WEIGHT * slopes


def cut_out(specimen: Specimen) -> Specimen:
    """Return a specimen with the patterns that its fields of density become; else itself.

    Raises
    ------
    InputError
        A field keeps all of the sheet, or nothing.
    """
    outline = specimen.outline
    least = LEAST_PART * outline.area
    for name, field in _fields(specimen):
        specimen = specimen.with_layer(name, pattern=field.cut_pattern(outline, least_area=least))
    return specimen


def _fields(specimen: Specimen) -> Iterator[tuple[str, DensityField]]:
    for layer in specimen.layers:
        if isinstance(layer.pattern, DensityField):
            yield layer.name, layer.pattern
