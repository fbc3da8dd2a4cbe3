"""Colours and names of the regions of a mesh, by the layers that lie there."""

from collections.abc import Sequence

import numpy as np

from bilayer.figures.style import BARE_COLOUR, FURTHER_COLOURS, KIRIGAMI_COLOUR, label_text
from bilayer.mesh.planar import PlanarMesh

MANY = {2: "bilayer", 3: "trilayer"}
"""Name of the region with all layers, by their number."""


def regions_of(mesh: PlanarMesh) -> list[int]:
    """Return the regions that a mesh has, those of the most layers first."""
    there = [int(region) for region in np.unique(mesh.region)]
    return sorted(there, key=lambda region: (-len(mesh.layer_sets[region]), region))


def region_name(mesh: PlanarMesh, region: int) -> str:
    """Return the name of a region: "bilayer", "bare substrate", "lower + substrate"."""
    layers = sorted(mesh.layer_sets[region])
    count = len(frozenset().union(*mesh.layer_sets))
    if len(layers) == 1:
        return label_text(f"bare {layers[0]}" if count > 1 else layers[0])
    if len(layers) == count:
        return MANY.get(count, "all layers")
    return label_text(" + ".join(layers))


def region_colours(mesh: PlanarMesh, full: str = KIRIGAMI_COLOUR, bare: str = BARE_COLOUR,
                   others: Sequence[str] = FURTHER_COLOURS) -> dict[int, str]:  # fmt: skip
    """Return a colour for each region of a mesh.

    Parameters
    ----------
    mesh : PlanarMesh
        Its regions.
    full, bare : str
        Where all layers lie, and where one does.
    others : sequence of str
        For the other regions, in the order of their numbers.
    """
    count = len(frozenset().union(*mesh.layer_sets))
    partial = iter(others)
    return {
        region: full if len(mesh.layer_sets[region]) == count
        else bare if len(mesh.layer_sets[region]) == 1
        else next(partial, others[-1])
        for region in sorted(regions_of(mesh))
    }  # fmt: skip
