"""Whether the layers on a planar mesh lie on each other everywhere: what a solver can stack."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen


def check_layering(specimen: Specimen, mesh: PlanarMesh) -> None:
    """Raise InputError unless each triangle has layers without a gap, at the reference surface.

    Parameters
    ----------
    specimen : Specimen
        Tells the order of the layers and the reference surface.
    mesh : PlanarMesh
        Tells which of them lie on each triangle.
    """
    order = specimen.layer_names
    for region in np.unique(mesh.region):
        names = mesh.layer_sets[region]
        place = _place_of(mesh, int(region))
        unknown = sorted(names - set(order))
        if unknown:
            raise InputError(
                f"mesh: has a layer {unknown[0]!r} {place}, expected one of {', '.join(order)}"
            )
        there = [index for index, name in enumerate(order) if name in names]
        _check_gap(order, there, place)
        _check_reference(specimen, there, place)


def _check_gap(order: Sequence[str], there: Sequence[int], place: str) -> None:
    for lower, upper in pairwise(there):
        if upper > lower + 1:
            raise InputError(
                f"layers.{order[lower + 1]}: is cut away {place} between {order[lower]} and "
                f"{order[upper]}, expected no gap between layers"
            )


def _check_reference(specimen: Specimen, there: Sequence[int], place: str) -> None:
    surface = specimen.reference_surface
    number = specimen.layer_names.index(surface.layer)
    bounded = {0.0: {number - 1, number}, 1.0: {number, number + 1}}.get(surface.share, {number})
    if not bounded & set(there):
        raise InputError(
            f"layers.{surface.layer}: does not lie {place}, expected everywhere a layer that has "
            f"the reference surface, {surface}"
        )


def _place_of(mesh: PlanarMesh, region: int) -> str:
    first = np.flatnonzero(mesh.region == region)[0]
    x, y = mesh.points[mesh.triangles[first]].mean(axis=0)
    return f"at ({x:.4g}, {y:.4g}) m"
